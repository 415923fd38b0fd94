/* helpers.h - What several functions use. */
#ifndef HELPERS_H
#define HELPERS_H

#include "exercises.h"

#define DOT(a, b) vector_dot((a), (b))
#define TIMES(a, b) vector_vec_mul((a), (b))
#define SET(place, value) ((place) = (value))
#define RETURN_IF(condition, value)                                                                                    \
    do {                                                                                                               \
        if (condition) {                                                                                               \
            return (value);                                                                                            \
        }                                                                                                              \
    } while (0)

static inline vec3 opposite(vec3 v) {
    return vector_init(-v.x, -v.y, -v.z);
}

static inline point3 along(const ray *r, float t) {
    return vector_add(r->orig, vector_float_mul(t, r->dir));
}

#endif
