/* ray.h - Half-lines r(t) = orig + t dir, of which only t in [tmin, tmax] counts.
 *
 * Conventions
 *   dir need not be unit: t counts in units of dir, so r(t) is |dir| t scene units away from orig.
 *   An intersection function lowers tmax to the t of its hit: what is farther no longer counts.
 *   depth is the number of bounces behind the ray: 0 for a ray of the camera.
 *   seed drives ray_random. A bounced ray goes on with its parent's seed, so that a picture
 *   depends neither on the order in which pixels are drawn nor on the number of threads.
 */
#ifndef RAY_H
#define RAY_H

#include "vector.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* How far a new ray sees, in units of its dir. The plane of the printed figures ends there. */
#ifndef RAY_TMAX
#define RAY_TMAX 1000.f
#endif

typedef struct ray_s {
    point3 orig;
    vec3 dir;
    float tmax;
    float tmin;
    int depth;
    uint32_t seed;
} ray;

/* Starts a ray: tmin 0, tmax RAY_TMAX, depth 0, seed 1. */
static inline void ray_init(ray *r, point3 orig, vec3 dir) {
    r->orig = orig;
    r->dir = dir;
    r->tmax = RAY_TMAX;
    r->tmin = 0.f;
    r->depth = 0;
    r->seed = 1;
}

/* The point r(t) = orig + t dir. */
static inline point3 ray_at(ray r, float t) {
    return vector_add(r.orig, vector_float_mul(t, r.dir));
}

/* Mixes the bits of x so that neighbouring numbers give unrelated ones (Wellons, "lowbias32"). */
static inline uint32_t ray_hash(uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352dU;
    x ^= x >> 15;
    x *= 0x846ca68bU;
    x ^= x >> 16;
    return x;
}

/* A number drawn uniformly in [0, 1); the seed moves on, so the next call gives another. */
static inline float ray_random(ray *r) {
    r->seed += 1;
    /* 24 bits: what a float holds exactly, so that 1 is never reached by rounding. */
    return (float)(ray_hash(r->seed) >> 8) * (1.f / 16777216.f);
}

/* The seed of one sample of pixel (i, j). For one sample number no two pixels share it (ray_hash makes different
 * numbers out of different ones), nor do two samples of one pixel. */
static inline uint32_t pixel_seed(int i, int j, int sample) {
    return ray_hash(ray_hash(((uint32_t)j << 16) + (uint32_t)i) + (uint32_t)sample);
}

#ifdef __cplusplus
}
#endif

#endif
