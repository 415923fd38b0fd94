/* probe.c - trace_ray for judging raytrace alone.
 *
 * It stands in the place of the submission's trace_ray, whether that is written or not: each direction has a colour of
 * its own, so that the picture tells which ray each pixel was given.
 */
#include "exercises.h"

color trace_ray(ray *r) {
    vec3 half = vector_init(0.5f, 0.5f, 0.5f);
    return vector_add(half, vector_float_mul(0.5f, vector_normalized(r->dir)));
}
