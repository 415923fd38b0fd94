/* main.c - For notebook 00: change it as you like, nothing here is judged.
 *
 * draw exchanges left and right: it should leave in column i what was in column WIDTH - 1 - i.
 * It has one mistake, put there for you to find.
 */
#include "exercises.h"

#include <stdio.h>

color output_image[WIDTH * HEIGHT];
object scene[SCENE_SIZE];
int object_count;
light lights[MAX_LIGHTS];
int num_lights;
camera theCamera;

void draw(color *img) {
    int exchanged = 0;
    for (int j = 0; j < HEIGHT; j++) {
        for (int i = 0; i < WIDTH; i++) {
            int left = j * WIDTH + i;
            int right = j * WIDTH + WIDTH - 1 - i;
            color kept = img[left];
            img[left] = img[right];
            img[right] = kept;
            exchanged++;
        }
    }
    printf("WIDTH * HEIGHT = %d, exchanged = %d\n", WIDTH * HEIGHT, exchanged);
}

int main(void) {
    return 0;
}
