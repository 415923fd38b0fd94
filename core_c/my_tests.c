/* my_tests.c - Your own tests. It is never judged: write what helps you.
 *
 * make try builds this file with your functions, with the tools that catch wrong accesses to memory, and runs it.
 * A test calls a function with values whose answer you know without a computer. Here are two, to begin with.
 */
#include "raytracer.h"

#include <stdio.h>

/* Says whether a fact holds, and what the fact is. */
static void expect(bool fact, const char *what) {
    printf("%s  %s\n", fact ? "ok    " : "FAUX  ", what);
}

static bool near(float a, float b) {
    return fabsf(a - b) < 1e-4f;
}

static void test_fill(void) {
    fill(output_image, vector_init(0.25f, 0.5f, 0.75f));
    expect(near(output_image[0].y, 0.5f), "fill : premier pixel | first pixel");
    expect(near(output_image[WIDTH * HEIGHT - 1].z, 0.75f), "fill : dernier pixel | last pixel");
}

/* From 5 before a ball of radius 1, straight at its centre: the ball is met at t = 4, its normal looks back. */
static void test_intersect_sphere(void) {
    object ball = init_sphere(0.f, 0.f, 0.f, 1.f, init_material(sky_color(), sky_color(), 1.f));
    ray r;
    intersection it;
    ray_init(&r, vector_init(0.f, 0.f, -5.f), vector_init(0.f, 0.f, 1.f));
    bool hit = intersect_sphere(&r, &it, &ball);
    expect(hit, "intersect_sphere : touchée | hit");
    expect(hit && near(r.tmax, 4.f), "intersect_sphere : t = 4");
    expect(hit && near(it.normal.z, -1.f), "intersect_sphere : normale | normal (0, 0, -1)");
}

int main(void) {
    test_fill();
    test_intersect_sphere();
    return 0;
}
