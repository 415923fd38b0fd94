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

/* TP1.1 - A picture all red. */
void fill_red(color *img) {
    MRT_TODO("TP1.1");
}

/* TP1.2 - A picture all of one colour. */
void fill(color *img, color c) {
    MRT_TODO("TP1.2");
}

/* TP1.3 - A gradient from c1 (top) to c2 (bottom). */
void horizontal_gradient(color *img, color c1, color c2) {
    MRT_TODO("TP1.3");
}

/* TP1.4 - A filled rectangle between two opposite corners. */
void fill_rect(color *img, color c, point3 p1, point3 p2) {
    MRT_TODO("TP1.4");
}

/* TP1.5 - A filled disc. */
void fill_circle(color *img, float radius, point3 center, color c) {
    MRT_TODO("TP1.5");
}

/* TP1.6 - Your own drawing. */
void draw(color *img) {
    MRT_TODO("TP1.6");
}

int main(int argc, char **argv) {
    return mrt_main(argc, argv);
}
