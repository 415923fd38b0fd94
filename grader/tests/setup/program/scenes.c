/* scenes.c - Runs the program on one scene after the other, in one process: valgrind takes long to start.
 *
 *   ./scenes NUMBER...    writes pictureNUMBER.ppm for each
 */
#define main mrt_program_main
#include "main.c" /* NOLINT(bugprone-suspicious-include): its main must be renamed */
#undef main

int main(int argc, char **argv) {
    int status = MRT_OK;
    for (int k = 1; status == MRT_OK && k < argc; k++) {
        char name[32];
        snprintf(name, sizeof name, "picture%.20s", argv[k]);
        char *words[] = {argv[0], argv[k], name, NULL};
        status = mrt_main(3, words);
        free(scene_texture.texels); /* the program would end here */
        scene_texture.texels = NULL;
        memset(todo_page, 0, TODO_PAGE_SIZE);
    }
    return status;
}
