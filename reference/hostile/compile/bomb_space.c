__asm__(".section .data\n.space 0x10000000000, 1");
