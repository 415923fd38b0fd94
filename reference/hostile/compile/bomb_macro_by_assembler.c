__asm__(".macro m n\n.if \\n\nm \\n-1\nm \\n-1\n.endif\n.quad 1\n.endm\nm 30");
