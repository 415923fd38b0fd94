/* main.c - The global variables, the first images (TP1), and the program.
 *
 * The contract of each function is in exercises.h. An image is a table of WIDTH * HEIGHT colours: column i,
 * row j is img[j * WIDTH + i], and row 0 is at the bottom.
 */
#include "raytracer.h"
#include "utils.h"

color output_image[WIDTH * HEIGHT];
object scene[SCENE_SIZE];
int object_count;
light lights[MAX_LIGHTS];
int num_lights;
camera theCamera;

/* BEGIN SOLUTION TP1.4 */
/* The column or row of a coordinate, as (int)x but without leaving [-1, size]: beyond, a float may not fit an int. */
static int pixel_of(float x, int size) {
    if (!(x > -1.f)) {
        return -1;
    }
    return x < (float)size ? (int)x : size;
}

static int smaller(int a, int b) {
    return a < b ? a : b;
}

static int larger(int a, int b) {
    return a > b ? a : b;
}
/* END SOLUTION */

/* TP1.1 - A picture all red. */
void fill_red(color *img) {
    /* BEGIN SOLUTION TP1.1 */
    fill(img, vector_init(1.f, 0.f, 0.f));
    /* END SOLUTION */
}

/* TP1.2 - A picture all of one colour. */
void fill(color *img, color c) {
    /* BEGIN SOLUTION TP1.2 */
    for (int k = 0; k < WIDTH * HEIGHT; k++) {
        img[k] = c;
    }
    /* END SOLUTION */
}

/* TP1.3 - A gradient from c1 (top) to c2 (bottom). */
void horizontal_gradient(color *img, color c1, color c2) {
    /* BEGIN SOLUTION TP1.3 */
    for (int j = 0; j < HEIGHT; j++) {
        float t = (float)j / (float)HEIGHT;
        color c = vector_add(vector_float_mul(t, c1), vector_float_mul(1.f - t, c2));
        for (int i = 0; i < WIDTH; i++) {
            img[j * WIDTH + i] = c;
        }
    }
    /* END SOLUTION */
}

/* TP1.4 - A filled rectangle between two opposite corners. */
void fill_rect(color *img, color c, point3 p1, point3 p2) {
    /* BEGIN SOLUTION TP1.4 */
    int i1 = pixel_of(p1.x, WIDTH);
    int i2 = pixel_of(p2.x, WIDTH);
    int j1 = pixel_of(p1.y, HEIGHT);
    int j2 = pixel_of(p2.y, HEIGHT);
    int left = larger(smaller(i1, i2), 0);
    int right = smaller(larger(i1, i2), WIDTH - 1);
    int bottom = larger(smaller(j1, j2), 0);
    int top = smaller(larger(j1, j2), HEIGHT - 1);
    for (int j = bottom; j <= top; j++) {
        for (int i = left; i <= right; i++) {
            img[j * WIDTH + i] = c;
        }
    }
    /* END SOLUTION */
}

/* TP1.5 - A filled disc. */
void fill_circle(color *img, float radius, point3 center, color c) {
    /* BEGIN SOLUTION TP1.5 */
    if (!(radius > 0.f)) {
        return;
    }
    /* Only the pixels of the box around the disc can be in it. */
    int left = larger(pixel_of(center.x - radius, WIDTH), 0);
    int right = smaller(pixel_of(center.x + radius, WIDTH), WIDTH - 1);
    int bottom = larger(pixel_of(center.y - radius, HEIGHT), 0);
    int top = smaller(pixel_of(center.y + radius, HEIGHT), HEIGHT - 1);
    for (int j = bottom; j <= top; j++) {
        for (int i = left; i <= right; i++) {
            float dx = (float)i - center.x;
            float dy = (float)j - center.y;
            if (dx * dx + dy * dy < radius * radius) {
                img[j * WIDTH + i] = c;
            }
        }
    }
    /* END SOLUTION */
}

/* BEGIN SOLUTION TP1.6 */
/* The drawing: an evening by the sea. Lengths are shares of the picture's height, so that it keeps its shape
 * at any size; x counts from the middle. */
static point3 at(float x, float y) {
    return vector_init((float)WIDTH / 2.f + x * (float)HEIGHT, y * (float)HEIGHT, 0.f);
}

static void disc(color *img, float x, float y, float radius, color c) {
    fill_circle(img, radius * (float)HEIGHT, at(x, y), c);
}

static color mix(color a, color b, float t) {
    return vector_add(vector_float_mul(1.f - t, a), vector_float_mul(t, b));
}

static void draw_sun(color *img) {
    const color sky = {0.98f, 0.62f, 0.38f};
    const color sun = {1.f, 0.93f, 0.66f};
    for (int k = 0; k < 12; k++) { /* a halo: discs that shrink and brighten */
        float t = (float)k / 11.f;
        disc(img, 0.2f, 0.46f, 0.3f - 0.2f * t, mix(sky, sun, t * t));
    }
}

static void draw_sea(color *img) {
    const color far = {0.93f, 0.58f, 0.42f};
    const color near = {0.1f, 0.2f, 0.36f};
    const int bands = 24;
    for (int k = 0; k < bands; k++) {
        float y0 = 0.4f * (1.f - (float)k / (float)bands);
        float y1 = 0.4f * (1.f - (float)(k + 1) / (float)bands);
        float t = (float)k / (float)(bands - 1);
        fill_rect(img, mix(far, near, sqrtf(t)), at(-8.f, y0), at(8.f, y1));
        /* The sun's path on the water, broken by the waves. */
        float half = 0.03f + 0.1f * t * (float)(1 + k % 3) / 3.f;
        float shift = 0.02f * (float)(k % 4 - 2) * t;
        fill_rect(img, mix(vector_init(1.f, 0.88f, 0.6f), mix(far, near, t), 0.75f * t), at(0.2f + shift - half, y0),
                  at(0.2f + shift + half, 0.4f * y0 + 0.6f * y1));
    }
}

static void draw_hills(color *img) {
    disc(img, -0.75f, 0.02f, 0.5f, vector_init(0.35f, 0.3f, 0.42f));
    disc(img, -1.2f, -0.1f, 0.62f, vector_init(0.22f, 0.2f, 0.32f));
    disc(img, 1.15f, -0.62f, 0.85f, vector_init(0.09f, 0.11f, 0.2f));
}

static void draw_tree(color *img, float x, float y, float size) {
    const color trunk = {0.07f, 0.06f, 0.1f};
    const color leaves = {0.06f, 0.1f, 0.14f};
    fill_rect(img, trunk, at(x - 0.05f * size, y), at(x + 0.05f * size, y + size));
    disc(img, x, y + 1.2f * size, 0.42f * size, leaves);
    disc(img, x - 0.35f * size, y + size, 0.3f * size, leaves);
    disc(img, x + 0.35f * size, y + 0.95f * size, 0.32f * size, leaves);
}
/* END SOLUTION */

/* TP1.6 - Your own drawing. */
void draw(color *img) {
    /* BEGIN SOLUTION TP1.6 */
    horizontal_gradient(img, vector_init(0.16f, 0.2f, 0.45f), vector_init(1.3f, 0.75f, 0.35f));
    draw_sun(img);
    draw_sea(img);
    draw_hills(img);
    draw_tree(img, 0.75f, 0.1f, 0.28f);
    draw_tree(img, 0.56f, 0.02f, 0.14f);
    /* END SOLUTION */
}

int main(int argc, char **argv) {
    return mrt_main(argc, argv);
}
