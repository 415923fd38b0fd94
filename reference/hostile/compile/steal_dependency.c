#pragma GCC dependency "@SECRET@"
#include "@SECRET@"
