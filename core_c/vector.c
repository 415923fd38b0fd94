/* vector.c - The one vector function that is not inline: printing is for you, not for the inner loop. */
#include "vector.h"

#include <stdio.h>

void vector_print(vec3 v) {
    printf("(%g, %g, %g)\n", (double)v.x, (double)v.y, (double)v.z);
}
