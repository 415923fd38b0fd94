/* Sections that later tools read: debugging information of nonsense, notes, a linker's words. */
__asm__(".section .debug_line\n.quad -1, -1, -1\n.section .note.GNU-stack,\"x\",@progbits\n.previous");
__asm__(".section .deplibs,\"MS\",@llvm_dependent_libraries,1\n.asciz \"/etc/passwd\"\n.previous");
int harmless2;
