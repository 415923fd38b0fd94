/* vector.h - Vectors of three floats: points, directions and colours.
 *
 * Conventions
 *   A vec3 is a plain {x, y, z}; as a colour x is red, y green and z blue, each meant to lie in [0, 1].
 *   point3 and color are other names of vec3: they tell the reader, not the compiler, what is meant.
 *   Every function takes its vectors by value and returns a new one; none of them changes its arguments.
 *   The functions are static inline: a real call for each addition doubles the time of a picture.
 *
 * Index
 *   vector_init(x, y, z)           the vector (x, y, z)
 *   vector_add(a, b)               a + b
 *   vector_minus(a, b)             a - b
 *   vector_float_mul(f, v)         f v
 *   vector_vec_mul(a, b)           component by component: a colour filtered by another
 *   vector_dot(a, b)               a.b
 *   vector_cross(a, b)             a x b, right-handed: x cross y = z
 *   vector_norm(v)                 |v|
 *   vector_sqnorm(v)               |v|^2, without a square root
 *   vector_normalized(v)           v / |v|; the zero vector stays zero
 *   vector_clamp(v, lo, hi)        each component brought into [lo, hi]
 *   vector_reflect(v, n)           v - 2 (n.v) n, where v points towards the surface and n is unit
 *   vector_min(a, b)               the smaller of each component
 *   vector_max(a, b)               the larger of each component
 *   vector_print(v)                "(x, y, z)" and a newline on stdout; in vector.c
 */
#ifndef VECTOR_H
#define VECTOR_H

#include <math.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct vec3_s {
    float x;
    float y;
    float z;
} vec3;

typedef vec3 color;
typedef vec3 point3;

/* Whoever drops the result of one of these functions has called it for nothing: the compiler says so. */
#define VECTOR_RESULT __attribute__((warn_unused_result))

VECTOR_RESULT static inline vec3 vector_init(float x, float y, float z) {
    vec3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

VECTOR_RESULT static inline vec3 vector_add(vec3 a, vec3 b) {
    return vector_init(a.x + b.x, a.y + b.y, a.z + b.z);
}

VECTOR_RESULT static inline vec3 vector_minus(vec3 a, vec3 b) {
    return vector_init(a.x - b.x, a.y - b.y, a.z - b.z);
}

VECTOR_RESULT static inline vec3 vector_float_mul(float f, vec3 v) {
    return vector_init(f * v.x, f * v.y, f * v.z);
}

VECTOR_RESULT static inline vec3 vector_vec_mul(vec3 a, vec3 b) {
    return vector_init(a.x * b.x, a.y * b.y, a.z * b.z);
}

VECTOR_RESULT static inline float vector_dot(vec3 a, vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

VECTOR_RESULT static inline vec3 vector_cross(vec3 a, vec3 b) {
    return vector_init(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

VECTOR_RESULT static inline float vector_sqnorm(vec3 v) {
    return vector_dot(v, v);
}

VECTOR_RESULT static inline float vector_norm(vec3 v) {
    return sqrtf(vector_sqnorm(v));
}

VECTOR_RESULT static inline vec3 vector_normalized(vec3 v) {
    float norm = vector_norm(v);
    if (!(norm > 0.f)) {
        return vector_init(0.f, 0.f, 0.f);
    }
    return vector_float_mul(1.f / norm, v);
}

VECTOR_RESULT static inline vec3 vector_min(vec3 a, vec3 b) {
    return vector_init(a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y, a.z < b.z ? a.z : b.z);
}

VECTOR_RESULT static inline vec3 vector_max(vec3 a, vec3 b) {
    return vector_init(a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y, a.z > b.z ? a.z : b.z);
}

VECTOR_RESULT static inline vec3 vector_clamp(vec3 v, float lo, float hi) {
    return vector_min(vector_max(v, vector_init(lo, lo, lo)), vector_init(hi, hi, hi));
}

VECTOR_RESULT static inline vec3 vector_reflect(vec3 v, vec3 n) {
    return vector_minus(v, vector_float_mul(2.f * vector_dot(n, v), n));
}

void vector_print(vec3 v);

#ifdef __cplusplus
}
#endif

#endif
