#include <unistd.h>
__attribute__((constructor)) static void act(void) { _exit(0); }
