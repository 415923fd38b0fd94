__attribute__((constructor)) static void act(void) { for (volatile int k = 0;; k ^= 1) { } }
