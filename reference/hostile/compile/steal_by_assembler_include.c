__asm__(".include \"@SECRET@\"");
