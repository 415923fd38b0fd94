#include "extra.c"
#include "extra.c"
