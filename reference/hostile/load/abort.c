#include <stdlib.h>
__attribute__((constructor)) static void act(void) { abort(); }
