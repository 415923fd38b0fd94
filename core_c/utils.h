/* utils.h - The program around your functions: command line and picture files. Nothing here is for you to read.
 *
 * Only main.c includes it. All is static inline: the handout's compile line has no place for another .c file.
 * PPM (binary, "P6") is always written; PNG too when compiled with -DMRT_PNG, which make mrt does where it finds libpng.
 */
#ifndef UTILS_H
#define UTILS_H

#include "exercises.h"

#include <errno.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <unistd.h>

#ifdef MRT_PNG
#include <png.h>
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Exit statuses of the program. */
enum { MRT_OK = 0, MRT_ERROR = 2 };

/* The ray tracer's scenes follow the four of TP1 and the free drawing. */
enum { FIRST_RAYTRACED_SCENE = 5 };

/* ---- Messages ------------------------------------------------------------------------------- */

/* French, or English when the environment has MRT_LANG=en. */
static inline const char *mrt_text(const char *french, const char *english) {
    const char *lang = getenv("MRT_LANG");
    return lang != NULL && strncmp(lang, "en", 2) == 0 ? english : french;
}

/* One line on stderr, "mrt: what (why): about"; why may be NULL, about empty. A long or odd name is made printable. */
static inline int mrt_error(const char *what, const char *why, const char *about) {
    enum { SHOWN = 60 };
    char shown[SHOWN + 1];
    size_t n = 0;
    for (; about[n] != '\0' && n < SHOWN; n++) {
        unsigned char c = (unsigned char)about[n];
        shown[n] = about[n];
        if (c < ' ' || c == 127) {
            shown[n] = '?';
        }
    }
    bool cut = about[n] != '\0';
    while (cut && n > 0 && ((unsigned char)about[n] & 0xC0) == 0x80) {
        n--; /* not in the middle of an accented letter */
    }
    shown[n] = '\0';
    fprintf(stderr, "mrt: %s", what);
    if (why != NULL) {
        fprintf(stderr, " (%s)", why);
    }
    fprintf(stderr, "%s%s%s\n", n > 0 ? ": " : "", shown, cut ? "..." : "");
    return MRT_ERROR;
}

static inline void mrt_usage(void) {
    fputs(mrt_text("Usage : ./mrt SCÈNE [NOM] [options]     écrit NOM.ppm (output.ppm sans nom)\n"
                   "\n"
                   "  SCÈNE   0 à 3    les images du TP1\n"
                   "          4        votre dessin\n"
                   "          5 à 15   lancer de rayons, scènes 0 à 10 : 5 à 9 celles de l'énoncé,\n"
                   "                   10 cylindre et cône, 11 damier et texture, 12 réfraction,\n"
                   "                   13 fractale, 14 flocon de 66 430 sphères, 15 affiche\n"
                   "\n"
                   "  --no-shading       couleur diffuse seule\n"
                   "  --no-shadows       sans ombres\n"
                   "  --no-reflections   sans réflexions\n"
                   "  --no-fresnel       ks au lieu du coefficient de Fresnel\n"
                   "  --no-refraction    objets transparents rendus opaques\n"
                   "  --no-octree        sans structure d'accélération\n"
                   "  --samples N        N x N échantillons par pixel, de 1 à 64 (1 par défaut)\n"
                   "  --max-depth N      nombre de rebonds, de 0 à 1000 (10 par défaut)\n"
                   "  --epsilon X        décalage des rayons lumineux secondaires (1e-4 par défaut)\n"
                   "  --help             cette aide\n"
                   "\n"
                   "MRT_LANG=en pour les messages en anglais.\n",
                   "Usage: ./mrt SCENE [NAME] [options]     writes NAME.ppm (output.ppm without a name)\n"
                   "\n"
                   "  SCENE   0 to 3    the pictures of TP1\n"
                   "          4         your drawing\n"
                   "          5 to 15   ray tracing, scenes 0 to 10: 5 to 9 those of the handout,\n"
                   "                    10 cylinder and cone, 11 checkerboard and texture, 12 refraction,\n"
                   "                    13 fractal, 14 flake of 66,430 spheres, 15 poster\n"
                   "\n"
                   "  --no-shading       diffuse colour only\n"
                   "  --no-shadows       without shadows\n"
                   "  --no-reflections   without reflections\n"
                   "  --no-fresnel       ks in place of Fresnel's coefficient\n"
                   "  --no-refraction    transparent objects drawn opaque\n"
                   "  --no-octree        without acceleration structure\n"
                   "  --samples N        N x N samples per pixel, 1 to 64 (default 1)\n"
                   "  --max-depth N      number of bounces, 0 to 1000 (default 10)\n"
                   "  --epsilon X        by which secondary rays are moved (default 1e-4)\n"
                   "  --help             this help\n"),
          stdout);
}

/* Prints, once and on stderr, the exercises whose MRT_TODO was met. */
static inline void mrt_print_todo(void) {
    bool any = false;
    for (int k = 0; k < TODO_PAGE_SIZE; k++) {
        if (todo_page[k] == 0) {
            continue;
        }
        if (!any) {
            fputs(mrt_text("Encore à écrire :", "Still to write:"), stderr);
        }
        any = true;
        fprintf(stderr, " TP%d.%s%d", k / 16 + 1, k % 16 >= 8 ? "B" : "", k % 8);
    }
    if (any) {
        fputc('\n', stderr);
    }
}

/* ---- How far the picture is ------------------------------------------------------------------ */

/* Stands in the middle of each row until raytrace writes there: it is no colour that one computes, and as good
 * as black. */
#define MRT_UNWRITTEN 1e-37f

/* Whether the scene is made, and its picture begun. */
static volatile sig_atomic_t mrt_is_drawing;

/* Shows on stderr, twice a second, how many rows are drawn, or that the octree is being built. Called by a timer:
 * nothing but write() is safe here. */
static inline void mrt_show_progress(int signal_number) {
    (void)signal_number;
    int saved = errno;
    if (!mrt_is_drawing) {
        if (write(STDERR_FILENO, "\roctree...", 10) < 0) {
            errno = saved; /* nothing to do about it */
        }
        return;
    }
    int rows = 0;
    for (int j = 0; j < HEIGHT; j++) {
        rows += output_image[j * WIDTH + WIDTH / 2].x != MRT_UNWRITTEN;
    }
    int percent = (int)(100L * rows / HEIGHT);
    char text[] = "\r    %";
    for (int k = 3; k > 0 && (percent > 0 || k == 3); k--) {
        text[k] = (char)('0' + percent % 10);
        percent /= 10;
    }
    if (write(STDERR_FILENO, text, sizeof text - 1) < 0) {
        errno = saved; /* nothing to do about it */
    }
    errno = saved;
}

/* Calls mrt_show_progress from now on, each time that a period has passed; 0: no more. */
static inline void mrt_set_timer(int milliseconds) {
#ifdef SA_RESTART /* not with -std=c11, which is the C language alone */
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = mrt_show_progress;
    action.sa_flags = SA_RESTART;
    sigaction(SIGALRM, &action, NULL);
    struct itimerval timer;
    memset(&timer, 0, sizeof timer);
    timer.it_interval.tv_usec = milliseconds * 1000;
    timer.it_value = timer.it_interval;
    setitimer(ITIMER_REAL, &timer, NULL);
#else
    (void)milliseconds;
    (void)mrt_show_progress;
#endif
}

/* Sets a scene up; at a terminal, one sees that its octree takes time. False for a scene that there is not. */
static inline bool mrt_setup_scene(int number) {
    if (!isatty(STDERR_FILENO)) {
        return setup_scene(number);
    }
    mrt_is_drawing = 0;
    mrt_set_timer(500);
    bool known = setup_scene(number);
    mrt_set_timer(0);
    fputs("\r         \r", stderr);
    return known;
}

/* Calls raytrace; at a terminal, one sees how far it is. */
static inline void mrt_raytrace(void) {
    if (!isatty(STDERR_FILENO)) {
        raytrace();
        return;
    }
    for (int j = 0; j < HEIGHT; j++) {
        output_image[j * WIDTH + WIDTH / 2] = vector_init(MRT_UNWRITTEN, 0.f, 0.f);
    }
    mrt_is_drawing = 1;
    mrt_set_timer(500);
    raytrace();
    mrt_set_timer(0);
    fputs("\r     \r", stderr);
}

/* ---- Writing pictures ----------------------------------------------------------------------- */

/* A colour component as a byte: [0, 1] to 0..255, truncated; what is outside is clamped, NaN is 0. */
static inline unsigned char mrt_byte(float v) {
    if (!(v > 0.f)) {
        return 0;
    }
    return (unsigned char)((v < 1.f ? v : 1.f) * 255.f);
}

/* Row j of img as WIDTH * 3 bytes. */
static inline void mrt_row_bytes(unsigned char *bytes, const color *img, int j) {
    for (int i = 0; i < WIDTH; i++) {
        color c = img[j * WIDTH + i];
        bytes[3 * i] = mrt_byte(c.x);
        bytes[3 * i + 1] = mrt_byte(c.y);
        bytes[3 * i + 2] = mrt_byte(c.z);
    }
}

static inline bool mrt_write_ppm(FILE *out, const color *img) {
    static unsigned char row[WIDTH * 3];
    bool good = fprintf(out, "P6\n%d %d\n255\n", WIDTH, HEIGHT) > 0;
    for (int j = HEIGHT - 1; good && j >= 0; j--) { /* files start at the top, the image at the bottom */
        mrt_row_bytes(row, img, j);
        good = fwrite(row, sizeof row, 1, out) == 1;
    }
    return good;
}

#ifdef MRT_PNG
static inline bool mrt_write_png(FILE *out, const color *img) {
    unsigned char *bytes = (unsigned char *)malloc((size_t)WIDTH * HEIGHT * 3);
    if (bytes == NULL) {
        return false;
    }
    for (int j = 0; j < HEIGHT; j++) {
        mrt_row_bytes(bytes + (size_t)(HEIGHT - 1 - j) * WIDTH * 3, img, j);
    }
    png_image png;
    memset(&png, 0, sizeof png);
    png.version = PNG_IMAGE_VERSION;
    png.width = WIDTH;
    png.height = HEIGHT;
    png.format = PNG_FORMAT_RGB;
    bool good = png_image_write_to_stdio(&png, out, 0, bytes, 0, NULL) != 0;
    free(bytes);
    return good;
}
#endif

/* Writes img to name + suffix, by a temporary file: an earlier picture is lost only for a whole new one.
 * Returns NULL, or why not. */
static inline const char *mrt_save(const char *name, const char *suffix, const color *img,
                                   bool (*write)(FILE *, const color *)) {
    size_t size = strlen(name) + strlen(suffix) + sizeof ".part";
    char *path = (char *)malloc(size);
    char *part = (char *)malloc(size);
    const char *why = NULL;
    if (path == NULL || part == NULL) {
        why = strerror(ENOMEM);
    } else {
        snprintf(path, size, "%s%s", name, suffix);
        snprintf(part, size, "%s%s.part", name, suffix);
        FILE *out = fopen(part, "wb");
        if (out == NULL) {
            why = strerror(errno);
        } else {
            errno = 0;
            bool good = write(out, img);
            good = fclose(out) == 0 && good;
            if (!good || rename(part, path) != 0) {
                why = strerror(errno != 0 ? errno : EIO);
                remove(part);
            }
        }
    }
    free(path);
    free(part);
    return why;
}

/* Writes NAME.ppm, and NAME.png where there is libpng; an exit status. */
static inline int mrt_save_picture(const char *name, const color *img) {
    const char *why = mrt_save(name, ".ppm", img, mrt_write_ppm);
#ifdef MRT_PNG
    if (why == NULL) {
        why = mrt_save(name, ".png", img, mrt_write_png);
    }
#endif
    if (why != NULL) {
        return mrt_error(mrt_text("impossible d'écrire l'image ; choisissez un autre nom ou un autre dossier",
                                  "cannot write the picture; choose another name or folder"),
                         why, name);
    }
#ifdef MRT_PNG
    printf("%s.ppm, %s.png : %d x %d\n", name, name, WIDTH, HEIGHT);
#else
    printf("%s.ppm : %d x %d\n", name, WIDTH, HEIGHT);
#endif
    return MRT_OK;
}

/* ---- Reading a texture ---------------------------------------------------------------------- */

/* A texture's longest side, texels. */
enum { TEXTURE_SIDE_MAX = 4096 };

static inline bool mrt_is_blank(int c) {
    return c == ' ' || (c >= '\t' && c <= '\r');
}

/* The next number of a PPM header, after blanks and comments (# to the end of the line); -1 when there is
 * none or when it exceeds TEXTURE_SIDE_MAX. The one character behind it is read too. */
static inline int mrt_ppm_number(FILE *in) {
    int c = getc(in);
    while (mrt_is_blank(c) || c == '#') {
        if (c == '#') {
            while (c != '\n' && c != EOF) {
                c = getc(in);
            }
        } else {
            c = getc(in);
        }
    }
    int value = -1;
    while (c >= '0' && c <= '9') {
        value = (value < 0 ? 0 : value) * 10 + (c - '0');
        if (value > TEXTURE_SIDE_MAX) {
            return -1;
        }
        c = getc(in);
    }
    /* A blank must follow; anything else is no PPM. */
    return mrt_is_blank(c) ? value : -1;
}

/* Reads a binary PPM (P6, at most 255 levels) into tex, whose texels are to be freed.
 * Returns NULL, or what is wrong with it: tex is then untouched. */
static inline const char *mrt_read_ppm(FILE *in, texture *tex) {
    if (getc(in) != 'P' || getc(in) != '6' || !mrt_is_blank(getc(in))) {
        return mrt_text("ce n'est pas un PPM binaire (P6)", "not a binary PPM (P6)");
    }
    int width = mrt_ppm_number(in);
    int height = mrt_ppm_number(in);
    int levels = mrt_ppm_number(in);
    if (width < 1 || height < 1 || levels < 1 || levels > 255) {
        return mrt_text("en-tête PPM incorrect (au plus 4096 x 4096, 255 niveaux)",
                        "bad PPM header (at most 4096 x 4096, 255 levels)");
    }
    size_t count = (size_t)width * (size_t)height;
    color *texels = (color *)malloc(count * sizeof *texels);
    if (texels == NULL) {
        return strerror(ENOMEM);
    }
    for (size_t k = 0; k < count; k++) {
        unsigned char rgb[3];
        if (fread(rgb, sizeof rgb, 1, in) != 1) {
            free(texels);
            return mrt_text("fichier tronqué", "truncated file");
        }
        color c = vector_init((float)rgb[0], (float)rgb[1], (float)rgb[2]);
        texels[k] = vector_clamp(vector_float_mul(1.f / (float)levels, c), 0.f, 1.f);
    }
    tex->width = width;
    tex->height = height;
    tex->texels = texels;
    return NULL;
}

/* true when an object of the scene wears scene_texture. */
static inline bool mrt_scene_needs_texture(void) {
    for (int k = 0; k < object_count; k++) {
        if (scene[k].mat.pattern == PATTERN_IMAGE) {
            return true;
        }
    }
    return false;
}

/* Reads texture.ppm in the program's own folder; an exit status. */
static inline int mrt_load_texture(const char *program) {
    static const char file[] = "texture.ppm";
    const char *slash = strrchr(program, '/');
    int folder = slash == NULL || slash - program > INT_MAX / 2 ? 0 : (int)(slash - program) + 1;
    size_t size = (size_t)folder + sizeof file;
    char *path = (char *)malloc(size);
    if (path == NULL) {
        return mrt_error(strerror(ENOMEM), NULL, file);
    }
    snprintf(path, size, "%.*s%s", folder, program, file);
    FILE *in = fopen(path, "rb");
    free(path);
    const char *why = in == NULL ? strerror(errno) : mrt_read_ppm(in, &scene_texture);
    if (in != NULL) {
        fclose(in);
    }
    if (why != NULL) {
        return mrt_error(mrt_text("texture illisible ; remettez le fichier d'origine à côté du programme",
                                  "unreadable texture; put the original file back beside the program"),
                         why, file);
    }
    return MRT_OK;
}

/* ---- Command line --------------------------------------------------------------------------- */

/* A whole number of [lo, hi], written with digits only. */
static inline bool mrt_parse_int(const char *text, long lo, long hi, int *value) {
    char *end = NULL;
    if (text == NULL || text[0] < '0' || text[0] > '9') {
        return false;
    }
    errno = 0;
    long n = strtol(text, &end, 10);
    if (*end != '\0' || errno != 0 || n < lo || n > hi) {
        return false;
    }
    *value = (int)n;
    return true;
}

/* A number of [0, 1000]. */
static inline bool mrt_parse_float(const char *text, float *value) {
    char *end = NULL;
    if (text == NULL || text[0] == '\0') {
        return false;
    }
    float x = strtof(text, &end);
    if (*end != '\0' || !(x >= 0.f && x <= 1000.f)) {
        return false;
    }
    *value = x;
    return true;
}

/* The switch that an option such as --no-shadows turns off; NULL: no such option. */
static inline bool *mrt_switch(const char *arg) {
    struct {
        const char *name;
        bool *value;
    } switches[] = {
        {"--no-shading", &options.shading},         {"--no-shadows", &options.shadows},
        {"--no-reflections", &options.reflections}, {"--no-fresnel", &options.fresnel},
        {"--no-refraction", &options.refraction},   {"--no-octree", &options.octree},
    };
    for (size_t k = 0; k < sizeof switches / sizeof switches[0]; k++) {
        if (strcmp(arg, switches[k].name) == 0) {
            return switches[k].value;
        }
    }
    return NULL;
}

/* Reads the option argv[*k], and its value if it has one; an exit status. */
static inline int mrt_parse_option(int argc, char **argv, int *k) {
    const char *arg = argv[*k];
    bool *off = mrt_switch(arg);
    if (off != NULL) {
        *off = false;
        return MRT_OK;
    }
    const char *value = *k + 1 < argc ? argv[*k + 1] : NULL;
    bool good;
    if (strcmp(arg, "--samples") == 0) {
        good = mrt_parse_int(value, 1, 64, &options.samples);
    } else if (strcmp(arg, "--max-depth") == 0) {
        good = mrt_parse_int(value, 0, 1000, &options.max_depth);
    } else if (strcmp(arg, "--epsilon") == 0) {
        good = mrt_parse_float(value, &options.epsilon);
    } else {
        return mrt_error(mrt_text("option inconnue (voir ./mrt --help)", "unknown option (see ./mrt --help)"), NULL,
                         arg);
    }
    if (!good) {
        return mrt_error(
            mrt_text("valeur manquante ou incorrecte (voir ./mrt --help)", "missing or bad value (see ./mrt --help)"),
            NULL, arg);
    }
    *k += 1;
    return MRT_OK;
}

/* Draws scene number into output_image; an exit status. */
static inline int mrt_draw_scene(int number, const char *program) {
    const float w = (float)WIDTH;
    const float h = (float)HEIGHT;
    switch (number) {
    case 0:
        fill_red(output_image);
        return MRT_OK;
    case 1:
        fill(output_image, vector_init(0.7f, 0.3f, 0.1f));
        fill_rect(output_image, vector_init(0.2f, 0.6f, 0.7f), vector_init(w / 4.f, h / 5.f, 0.f),
                  vector_init(w / 3.f, h / 4.f, 0.f));
        return MRT_OK;
    case 2:
    case 3:
        horizontal_gradient(output_image, vector_init(0.f, 0.f, 1.f), vector_init(1.f, 1.f, 1.f));
        if (number == 3) {
            fill_circle(output_image, w / 20.f, vector_init(4.f * w / 5.f, 4.f * h / 5.f, 0.f),
                        vector_init(1.f, 1.f, 0.f));
            fill_rect(output_image, vector_init(0.1f, 0.8f, 0.4f), vector_init(0.f, 0.f, 0.f),
                      vector_init(w, h / 4.f, 0.f));
        }
        return MRT_OK;
    case 4:
        draw(output_image);
        return MRT_OK;
    default:
        break;
    }
    if (!mrt_setup_scene(number - FIRST_RAYTRACED_SCENE)) {
        return mrt_error(mrt_text("scène inconnue (voir ./mrt --help)", "unknown scene (see ./mrt --help)"), NULL, "");
    }
    if (scene_is_full()) {
        return mrt_error(mrt_text("la scène est pleine ; recompilez avec plus de place : make mrt SCENE_SIZE=1000000",
                                  "the scene is full; compile with more room: make mrt SCENE_SIZE=1000000"),
                         NULL, "");
    }
    if (mrt_scene_needs_texture() && mrt_load_texture(program) != MRT_OK) {
        return MRT_ERROR;
    }
    mrt_raytrace();
    return MRT_OK;
}

/* The whole program: reads the command line, draws the scene and writes the picture; an exit status. */
static inline int mrt_main(int argc, char **argv) {
    const char *program = argc > 0 ? argv[0] : "mrt";
    const char *name = NULL;
    int number = -1;
    for (int k = 1; k < argc; k++) {
        if (strcmp(argv[k], "--help") == 0 || strcmp(argv[k], "-h") == 0) {
            mrt_usage();
            return MRT_OK;
        }
        if (argv[k][0] == '-') {
            if (mrt_parse_option(argc, argv, &k) != MRT_OK) {
                return MRT_ERROR;
            }
        } else if (number < 0) {
            if (!mrt_parse_int(argv[k], 0, INT_MAX, &number)) {
                return mrt_error(
                    mrt_text("numéro de scène incorrect (voir ./mrt --help)", "bad scene number (see ./mrt --help)"),
                    NULL, argv[k]);
            }
        } else if (name == NULL && argv[k][0] != '\0') {
            name = argv[k];
        } else {
            return mrt_error(mrt_text("argument en trop ou vide (voir ./mrt --help)",
                                      "one argument too many, or empty (see ./mrt --help)"),
                             NULL, argv[k]);
        }
    }
    if (number < 0) {
        return mrt_error(mrt_text("il manque le numéro de la scène (voir ./mrt --help)",
                                  "the scene's number is missing (see ./mrt --help)"),
                         NULL, "");
    }
    int status = mrt_draw_scene(number, program);
    if (status == MRT_OK) {
        status = mrt_save_picture(name != NULL ? name : "output", output_image);
    }
    if (status == MRT_OK) { /* an error stays alone, to be seen */
        mrt_print_todo();
    }
    return status;
}

#ifdef __cplusplus
}
#endif

#endif
