/* fuzz.c - Throws made-up command lines and picture files at the given program (utils.h).
 *
 *   ./fuzz SEED COUNT    COUNT cases in the current folder, which is left as it was; always the same ones for a SEED
 *
 * The drawing functions do nothing here, so that a case takes microseconds. The sanitizers watch the memory: every
 * input lies in a block of its own, of its exact size. This file watches the behaviour, and stops at the first case
 * that breaks a rule.
 */
#include <stdio.h>

/* The program's two outputs are files in memory here, to be looked at. */
static FILE *said_out;
static FILE *said_err;
#undef stdout
#undef stderr
#define stdout said_out
#define stderr said_err
#include "utils.h"

enum { TEXT_MAX = 1 << 14, WORDS_MAX = 6 };

static char out_text[TEXT_MAX];
static char err_text[TEXT_MAX];
static unsigned long case_number;

/* ---- What the program draws with ---------------------------------------------------------------- */

color output_image[WIDTH * HEIGHT];
object scene[SCENE_SIZE];
int object_count;
render_options options;
texture scene_texture;
static unsigned char own_page[TODO_PAGE_SIZE];
unsigned char *todo_page = own_page;
static bool full;

void fill_red(color *img) {
    (void)img;
}

void fill(color *img, color c) {
    img[0] = c;
}

void horizontal_gradient(color *img, color c1, color c2) {
    img[0] = vector_add(c1, c2);
}

void fill_rect(color *img, color c, point3 p1, point3 p2) {
    (void)p1;
    (void)p2;
    img[0] = c;
}

void fill_circle(color *img, float radius, point3 center, color c) {
    (void)radius;
    (void)center;
    img[0] = c;
}

void draw(color *img) {
    img[0] = vector_init(NAN, -INFINITY, INFINITY);
}

void raytrace(void) {
}

bool scene_is_full(void) {
    return full;
}

/* The program's scenes 11 and 15 need the texture; 14 is full here. */
bool setup_scene(int number) {
    object_count = 1;
    full = number == 9;
    scene[0].mat.pattern = number == 6 || number == 10 ? PATTERN_IMAGE : PATTERN_NONE;
    return number >= 0 && number <= 10;
}

/* ---- Drawing lots --------------------------------------------------------------------------------- */

static uint32_t dice;

/* A number of 0 to n - 1. */
static unsigned below(unsigned n) {
    dice = dice * 1664525u + 1013904223u;
    return ray_hash(dice) % n;
}

static const char *one_of(const char *const *list, size_t count) {
    return list[below((unsigned)count)];
}

#define ONE_OF(list) one_of(list, sizeof(list) / sizeof(list)[0])

static void broken(const char *rule) {
    printf("case %lu breaks a rule: %s\nstderr: %s\n", case_number, rule, err_text);
    exit(1);
}

static void hold(bool good, const char *rule) {
    if (!good) {
        broken(rule);
    }
}

/* ---- Picture files -------------------------------------------------------------------------------- */

typedef struct bytes_s {
    unsigned char *data;
    size_t size;
} bytes;

static const char *const STARTS[] = {"P6", "P6", "P6", "P6", "P6", "P6", "P5", "P3", "p6", "6P", "P", "\x89PNG"};
static const char *const BLANKS[] = {" ",    "\n",        "\t", "\r\n", "  ", "\n# a comment\n",
                                     " #\n", "# 9 9 9\n", "#",  "",     "x"};
static const char *const NUMBERS[] = {"0",          "1",   "2",    "3",    "8",     "007",
                                      "-1",         "+2",  "4096", "4097", "65536", "2147483647",
                                      "4294967297", "1e3", "3.",   "0x8",  "",      "99999999999999999999999999999999",
                                      "abc"};
static const char *const LEVELS[] = {"255", "255", "255", "255", "0", "1", "2", "254", "256", "65535", "-255", ""};

static void append(bytes *to, const char *text) {
    size_t n = strlen(text);
    memcpy(to->data + to->size, text, n);
    to->size += n;
}

/* A number for a header: mostly a small good one. */
static const char *side(void) {
    return below(4) == 0 ? ONE_OF(NUMBERS) : NUMBERS[1 + below(4)];
}

/* A header: mostly one blank of each kind, sometimes anything. */
static const char *blank(void) {
    return below(5) == 0 ? ONE_OF(BLANKS) : BLANKS[below(3)];
}

static void append_header(bytes *file) {
    append(file, ONE_OF(STARTS));
    append(file, blank());
    append(file, side());
    append(file, blank());
    append(file, side());
    append(file, blank());
    append(file, ONE_OF(LEVELS));
    append(file, blank());
}

/* A picture file; at most 200 bytes of header, 200 of texels. To be freed. */
static bytes make_picture(void) {
    bytes file = {(unsigned char *)malloc(512), 0};
    append_header(&file);
    for (unsigned n = below(200); n > 0; n--) {
        file.data[file.size++] = (unsigned char)below(256);
    }
    for (unsigned n = below(3) == 0 ? below(4) : 0; n > 0; n--) { /* a few wrong bytes */
        file.data[below((unsigned)file.size)] = (unsigned char)below(256);
    }
    if (below(4) == 0) { /* cut short */
        file.size = 1 + below((unsigned)file.size);
    }
    bytes exact = {(unsigned char *)malloc(file.size), file.size};
    memcpy(exact.data, file.data, file.size);
    free(file.data);
    return exact;
}

static void check_texels(const texture *tex) {
    hold(tex->width >= 1 && tex->width <= TEXTURE_SIDE_MAX, "a texture's width lies in 1..4096");
    hold(tex->height >= 1 && tex->height <= TEXTURE_SIDE_MAX, "a texture's height lies in 1..4096");
    hold(tex->texels != NULL, "a texture that was read has texels");
    for (int k = 0; k < tex->width * tex->height; k++) {
        color c = tex->texels[k];
        hold(c.x >= 0.f && c.x <= 1.f && c.y >= 0.f && c.y <= 1.f && c.z >= 0.f && c.z <= 1.f,
             "a texel's components lie in [0, 1]");
    }
}

/* Reads one made-up file; true when it was taken for a picture. */
static bool read_a_picture(void) {
    bytes file = make_picture();
    FILE *in = fmemopen(file.data, file.size, "rb");
    texture tex = {-1, -1, NULL};
    const char *why = mrt_read_ppm(in, &tex);
    if (why == NULL) {
        check_texels(&tex);
    } else {
        hold(why[0] != '\0' && strchr(why, '\n') == NULL, "a refusal says why");
        hold(tex.width == -1 && tex.height == -1 && tex.texels == NULL, "a refusal leaves the texture as it was");
    }
    fclose(in);
    free(tex.texels);
    free(file.data);
    return why == NULL;
}

/* ---- Command lines -------------------------------------------------------------------------------- */

static const char *const PROGRAMS[] = {"./mrt", "mrt", "", "/", "missing/mrt", "./folder/../mrt"};
static const char *const SCENES[] = {"0", "1", "2", "3", "4", "5", "11", "14", "15", "16", "007", "2147483647"};
static const char *const NAMES[] = {"picture", "a b", "\xc3\xa9t\xc3\xa9", "a\nb", "%s%n", "missing/picture", "folder"};
static const char *const OPTIONS[] = {
    "--no-shading", "--no-shadows", "--no-reflections", "--no-fresnel", "--help", "-h", "--no-refraction",
    "--no-octree",  "--samples",    "--epsilon",        "--max-depth",  "-",      "--", "--sample",
    "--no-"};
static const char *const VALUES[] = {"1",
                                     "64",
                                     "65",
                                     "0",
                                     "1000",
                                     "1001",
                                     "-1",
                                     "1e-4",
                                     "nan",
                                     "inf",
                                     "1e99",
                                     "",
                                     "1,5",
                                     "0x1p",
                                     " 2",
                                     "3 ",
                                     "99999999999999999999"};

static char *copy_of(const char *text) {
    size_t size = strlen(text) + 1;
    char *copy = (char *)malloc(size);
    memcpy(copy, text, size);
    return copy;
}

/* Any bytes, up to 10,000; no '/', so that nothing is written elsewhere. */
static char *odd_word(void) {
    size_t n = below(20) == 0 ? below(10000) : below(80);
    char *word = (char *)malloc(n + 1);
    for (size_t k = 0; k < n; k++) {
        unsigned char c = (unsigned char)(1 + below(255));
        word[k] = (char)(c == '/' ? '_' : c);
    }
    word[n] = '\0';
    return word;
}

static char *make_word(int place) {
    switch (below(12)) {
    case 0:
        return odd_word();
    case 1:
    case 2:
        return copy_of(ONE_OF(OPTIONS));
    case 3:
        return copy_of(ONE_OF(VALUES));
    default:
        return copy_of(place == 1 ? ONE_OF(SCENES) : place == 2 ? ONE_OF(NAMES) : ONE_OF(OPTIONS));
    }
}

static void write_texture(void) {
    bytes file = make_picture();
    FILE *out = fopen("texture.ppm", "wb");
    hold(out != NULL && fwrite(file.data, file.size, 1, out) == 1 && fclose(out) == 0, "the test can write a texture");
    free(file.data);
}

/* The program's answer to a command line; what it said stands in out_text and err_text. */
static int answer(int argc, char **argv) {
    const render_options defaults = {true, true, true, true, true, true, 1, 10, EPSILON};
    options = defaults;
    memset(own_page, 0, sizeof own_page);
    own_page[below(TODO_PAGE_SIZE)] = (unsigned char)below(2);
    out_text[0] = err_text[0] = '\0';
    said_out = fmemopen(out_text, sizeof out_text, "w");
    said_err = fmemopen(err_text, sizeof err_text, "w");
    int status = mrt_main(argc, argv);
    fclose(said_out);
    fclose(said_err);
    free(scene_texture.texels);
    scene_texture.texels = NULL;
    return status;
}

/* One line, of a bearable length, without control characters. */
static bool is_one_line(const char *text) {
    size_t n = strlen(text);
    for (size_t k = 0; k + 1 < n; k++) {
        if ((unsigned char)text[k] < ' ' || text[k] == 127) {
            return false;
        }
    }
    return n > 0 && n < 300 && text[n - 1] == '\n';
}

/* Removes NAME.ppm; false when it is not there, or when a half-made one is. */
static bool remove_picture(const char *name) {
    char path[512];
    snprintf(path, sizeof path, "%s.ppm.part", name);
    if (remove(path) == 0) {
        return false;
    }
    snprintf(path, sizeof path, "%s.ppm", name);
    return remove(path) == 0;
}

/* The words that are neither options nor values: the second is the picture's name. */
static const char *picture_name(int argc, char **argv) {
    int place = 0;
    for (int k = 1; k < argc; k++) {
        bool takes_value = strcmp(argv[k], "--samples") == 0 || strcmp(argv[k], "--max-depth") == 0 ||
                           strcmp(argv[k], "--epsilon") == 0;
        if (takes_value) {
            k++;
        } else if (argv[k][0] != '-' && ++place == 2) {
            return argv[k];
        }
    }
    return "output";
}

static void check_answer(int status, int argc, char **argv) {
    bool helped = out_text[0] != '\0';
    const char *todo = mrt_text("Encore \xc3\xa0 \xc3\xa9"
                                "crire : TP",
                                "Still to write: TP");
    hold(status == MRT_OK || status == MRT_ERROR, "the exit status is 0 or 2");
    if (status == MRT_ERROR) {
        hold(is_one_line(err_text) && strncmp(err_text, "mrt: ", 5) == 0, "an error is one line on stderr");
        hold(!helped, "an error says nothing on stdout");
        hold(!remove_picture(picture_name(argc, argv)), "an error leaves no picture");
    } else if (helped) {
        hold(err_text[0] == '\0', "help says nothing on stderr");
    } else {
        hold(err_text[0] == '\0' || (is_one_line(err_text) && strncmp(err_text, todo, strlen(todo)) == 0),
             "a success says nothing on stderr, but for the exercises to do");
        hold(remove_picture(picture_name(argc, argv)), "a success writes its picture, whole");
    }
    hold(options.samples >= 1 && options.samples <= 64, "samples lies in 1..64");
    hold(options.max_depth >= 0 && options.max_depth <= 1000, "max_depth lies in 0..1000");
    hold(options.epsilon >= 0.f && options.epsilon <= 1000.f, "epsilon lies in [0, 1000]");
}

/* Runs the program once; its exit status. */
static int run_a_command(void) {
    int argc = (int)below(WORDS_MAX + 1);
    char **argv = (char **)malloc(((size_t)argc + 1) * sizeof *argv);
    for (int k = 0; k < argc; k++) {
        argv[k] = k > 0 ? make_word(k) : below(20) == 0 ? odd_word() : copy_of(ONE_OF(PROGRAMS));
    }
    argv[argc] = NULL;
    setenv("MRT_LANG", below(2) == 0 ? "en" : "fr", 1);
    if (below(8) == 0) {
        write_texture();
    }
    int status = answer(argc, argv);
    check_answer(status, argc, argv);
    for (int k = 0; k < argc; k++) {
        free(argv[k]);
    }
    free((void *)argv);
    return status;
}

int main(int argc, char **argv) {
    if (argc != 3) {
        return 1;
    }
    dice = (uint32_t)strtoul(argv[1], NULL, 10);
    unsigned long count = strtoul(argv[2], NULL, 10);
    unsigned long taken = 0;
    unsigned long done = 0;
    for (case_number = 0; case_number < count; case_number++) {
        if (below(2) == 0) {
            taken += read_a_picture();
        } else {
            done += run_a_command() == MRT_OK;
        }
    }
    remove("texture.ppm");
    printf("%lu cases, %lu pictures read, %lu commands done\n", count, taken, done);
    return 0;
}
