__asm__(".section .rodata\n.incbin \"/etc/passwd\"");
