/* globals.h - Sizes, and the global variables that main.c defines.
 *
 * The picture's size is chosen when compiling: make mrt WIDTH=640 HEIGHT=360.
 *
 * The image is one table of WIDTH * HEIGHT colours. The pixel in column i and row j is
 * output_image[j * WIDTH + i]; row 0 is the BOTTOM of the picture, column 0 its left side.
 */
#ifndef GLOBALS_H
#define GLOBALS_H

#include "scene.h"

#ifdef __cplusplus
extern "C" {
#endif

#ifndef WIDTH
#define WIDTH 1280
#endif
#ifndef HEIGHT
#define HEIGHT 720
#endif
#if WIDTH < 1 || HEIGHT < 1 || WIDTH > 32768 || HEIGHT > 32768
#error "WIDTH and HEIGHT must lie between 1 and 32768"
#endif

/* The most objects a scene can hold; a larger scene needs -DSCENE_SIZE=... */
#ifndef SCENE_SIZE
#define SCENE_SIZE 70000
#endif

#define MAX_LIGHTS 3

/* Default of options.epsilon, scene units. */
#define EPSILON 1e-4f

extern color output_image[WIDTH * HEIGHT];
extern object scene[SCENE_SIZE];
extern int object_count; /* scene[0] to scene[object_count - 1] are in use */
extern light lights[MAX_LIGHTS];
extern int num_lights;
extern camera theCamera;

#ifdef __cplusplus
}
#endif

#endif
