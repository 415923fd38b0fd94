/* edges.c - Calls every function of TP1 with every combination of extreme numbers.
 *
 * The sanitizers watch each write, and each number that is turned into an integer. Built with the solution's own
 * main.c inside, for a small picture.
 */
#define main mrt_program_main
#include "main.c" /* NOLINT(bugprone-suspicious-include): its main must be renamed */
#undef main

static const float EXTREMES[] = {0.f,      -0.f,     1e-40f,    -0.5f,        -1.f,   (float)WIDTH - 1.f,
                                 WIDTH,    HEIGHT,   WIDTH + 1, 2147483648.f, -1e10f, 3.4e38f,
                                 -3.4e38f, INFINITY, -INFINITY, NAN};
enum { COUNT = sizeof EXTREMES / sizeof EXTREMES[0] };

static const color INK = {0.25f, 0.5f, 0.75f};

static void stop(const char *rule) {
    printf("broken: %s\n", rule);
    exit(1);
}

/* How many pixels have ink; all the others must be black, as before the call. */
static int inked(const color *img) {
    int count = 0;
    for (int k = 0; k < WIDTH * HEIGHT; k++) {
        float sum = img[k].x + img[k].y + img[k].z;
        if (sum != 0.f && (img[k].x != INK.x || img[k].y != INK.y || img[k].z != INK.z)) {
            stop("a shape paints its colour and nothing else");
        }
        count += sum != 0.f;
    }
    return count;
}

static void wipe(color *img) {
    memset(img, 0, sizeof(color) * WIDTH * HEIGHT);
}

static int rectangles(color *img) {
    int calls = 0;
    for (int k = 0; k < COUNT * COUNT * COUNT * COUNT; k++) {
        point3 p1 = {EXTREMES[k % COUNT], EXTREMES[k / COUNT % COUNT], NAN};
        point3 p2 = {EXTREMES[k / COUNT / COUNT % COUNT], EXTREMES[k / COUNT / COUNT / COUNT], 0.f};
        wipe(img);
        fill_rect(img, INK, p1, p2);
        inked(img);
        calls++;
    }
    return calls;
}

static int circles(color *img) {
    int calls = 0;
    for (int k = 0; k < COUNT * COUNT * COUNT; k++) {
        float radius = EXTREMES[k % COUNT];
        point3 center = {EXTREMES[k / COUNT % COUNT], EXTREMES[k / COUNT / COUNT], NAN};
        wipe(img);
        fill_circle(img, radius, center, INK);
        if (inked(img) > 0 && !(radius > 0.f)) {
            stop("without a positive radius there is no disc");
        }
        calls++;
    }
    return calls;
}

static int colors(color *img) {
    int calls = 0;
    for (int k = 0; k < COUNT * COUNT; k++) {
        float a = EXTREMES[k % COUNT];
        float b = EXTREMES[k / COUNT];
        fill_red(img);
        fill(img, vector_init(a, b, a));
        horizontal_gradient(img, vector_init(a, a, b), vector_init(b, a, a));
        draw(img);
        calls += 4;
    }
    return calls;
}

/* A colour outside [0, 1] has a byte too. */
static void bytes_of_extremes(void) {
    for (int k = 0; k < COUNT; k++) {
        float v = EXTREMES[k];
        if (mrt_byte(v) != (v >= 1.f ? 255 : 0)) {
            stop("a component is clamped to [0, 1], NaN to 0");
        }
    }
}

static void big_shapes_cover(color *img) {
    wipe(img);
    fill_rect(img, INK, vector_init(-INFINITY, 3.4e38f, 0.f), vector_init(INFINITY, -3.4e38f, 0.f));
    if (inked(img) != WIDTH * HEIGHT) {
        stop("an endless rectangle covers the picture");
    }
    wipe(img);
    fill_circle(img, 1e10f, vector_init(3.f, 2.f, 0.f), INK);
    if (inked(img) != WIDTH * HEIGHT) {
        stop("a huge disc covers the picture");
    }
}

int main(void) {
    color *img = (color *)malloc(sizeof(color) * WIDTH * HEIGHT);
    if (img == NULL) {
        return 1;
    }
    int calls = rectangles(img) + circles(img) + colors(img);
    bytes_of_extremes();
    big_shapes_cover(img);
    free(img);
    printf("%d calls\n", calls);
    return 0;
}
