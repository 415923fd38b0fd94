/* driver.c - What `make bench` links with a submission: draws one scene, and says what it cost.
 *
 *   driver SCENE               prints the scene's lines, then what building and drawing cost
 *   driver SCENE --plain       the same without the octree
 *   driver SCENE --list        prints the scene itself, for the writers of the other programs' files
 *   driver SCENE --compare N   N pictures with the octree and N without, in turn
 *
 * SCENE: small, flake4, flake5, flake6, or a number of setup_scene. Every line of the output is a word and numbers.
 * Seconds are the process's CPU time. With -DBENCH_COUNT, the other files built by -finstrument-functions, and octree.c
 * by -Dmalloc=bench_malloc -Dfree=bench_free, rays, object tests and the octree's bytes are counted too.
 */
#include "exercises.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static double cpu_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- Counting ----------------------------------------------------------------------------------- */

#ifdef BENCH_COUNT
typedef void (*function)(void);

static struct {
    const char *name;
    function entry;
    long calls;
} counted[] = {
    {"tests", (function)intersect_sphere, 0},
    {"tests", (function)intersect_cylinder, 0},
    {"tests", (function)intersect_cone, 0},
    {"plane_tests", (function)intersect_plane, 0},
    {"rays", (function)nearest_hit, 0},
    {"camera_rays", (function)camera_ray, 0},
    {"reflected_rays", (function)reflected_ray, 0},
    {"shadow_rays", (function)in_shadow, 0},
};
enum { COUNTED = sizeof counted / sizeof counted[0] };

void __cyg_profile_func_enter(void *entry, void *site);
void __cyg_profile_func_exit(void *entry, void *site);

void __cyg_profile_func_enter(void *entry, void *site) {
    (void)site;
    for (int k = 0; k < COUNTED; k++) {
        counted[k].calls += (void *)counted[k].entry == entry;
    }
}

void __cyg_profile_func_exit(void *entry, void *site) {
    (void)entry;
    (void)site;
}

/* Every block begins with its size, in as many bytes as keep what follows aligned. */
enum { SIZE_ROOM = 16 };
static size_t bytes_now = 0;
static size_t bytes_most = 0;

void *bench_malloc(size_t size);
void bench_free(void *memory);

void *bench_malloc(size_t size) {
    char *start = (char *)malloc(size + SIZE_ROOM);
    if (start == NULL) {
        return NULL;
    }
    *(size_t *)start = size;
    bytes_now += size;
    bytes_most = bytes_now > bytes_most ? bytes_now : bytes_most;
    return start + SIZE_ROOM;
}

void bench_free(void *memory) {
    if (memory != NULL) {
        char *start = (char *)memory - SIZE_ROOM;
        bytes_now -= *(size_t *)start;
        free(start);
    }
}

static void print_counts(void) {
    for (int k = 0; k < COUNTED; k++) {
        printf("%s %ld\n", counted[k].name, counted[k].calls); /* the reader adds up what has one name */
    }
    printf("octree_bytes %zu\nbuild_bytes %zu\n", bytes_now, bytes_most);
}
#else
static void print_counts(void) {
}
#endif

/* ---- Scenes ------------------------------------------------------------------------------------- */

static color grey(float level) {
    return vector_init(level, level, level);
}

static void look(point3 eye, point3 at, vec3 up) {
    theCamera = init_camera(eye, at, up, 72.734f, (float)WIDTH / (float)HEIGHT);
}

static void ball(float x, float y, float z, float radius, color kd, float ks, float shininess) {
    add_object(init_sphere(x, y, z, radius, init_material(kd, grey(ks), shininess)));
}

static void small(void) {
    look(vector_init(0.f, 2.f, -7.f), vector_init(0.f, 0.8f, 0.f), vector_init(0.f, 1.f, 0.f));
    add_light(vector_init(4.f, 6.f, -4.f), grey(1.6f));
    add_light(vector_init(-5.f, 5.f, -3.f), grey(1.f));
    add_light(vector_init(0.f, 8.f, -8.f), grey(0.8f));
    ball(0.f, 1.f, 0.f, 1.f, vector_init(0.8f, 0.1f, 0.1f), 0.3f, 50.f);
    ball(-2.2f, 0.8f, 0.3f, 0.8f, vector_init(0.1f, 0.7f, 0.2f), 0.2f, 30.f);
    ball(2.1f, 0.7f, -0.6f, 0.7f, vector_init(0.2f, 0.3f, 0.9f), 0.4f, 80.f);
    add_object(init_plane(0.f, 1.f, 0.f, 0.f, init_material(vector_init(0.7f, 0.7f, 0.6f), grey(0.1f), 20.f)));
}

static void flake(int depth) {
    const vec3 up = {0.f, 0.f, 1.f};
    const material mat = init_material(vector_init(0.5f, 0.45f, 0.35f), grey(0.5f), 50.f);
    options.epsilon = 1e-5f;
    look(vector_init(2.1f, 1.3f, 1.7f), grey(0.f), up);
    add_light(vector_init(4.f, 3.f, 2.f), grey(1.f));
    add_light(vector_init(1.f, -4.f, 4.f), grey(1.f));
    add_light(vector_init(-3.f, 1.f, 5.f), grey(1.f));
    add_flake(grey(0.f), 0.5f, up, depth, &mat);
    material floor = init_material(vector_init(0.8f, 0.6f, 0.26f), grey(0.f), 50.f);
    floor.user[0] = 1.f;
    add_object(init_plane(0.f, 0.f, 1.f, 0.5f, floor));
}

/* Stands for mirror_color in the glue: a matte object (user[0] set) traces no reflected ray, where Schlick's formula would
 * even at a reflectance of 0. So do the programs that the figures of the workload come from. */
color bench_mirror_color(const ray *in, const intersection *it);

color bench_mirror_color(const ray *in, const intersection *it) {
    return it->mat.user[0] > 0.f ? vector_init(0.f, 0.f, 0.f) : mirror_color(in, it);
}

/* Fills scene[], without its octree; false when there is no such scene, or no room for it. */
static bool set_up(const char *name) {
    options.octree = false;
    if (strcmp(name, "small") == 0) {
        small();
    } else if (strncmp(name, "flake", 5) == 0) {
        flake(atoi(name + 5));
    } else if (!setup_scene(atoi(name))) {
        return false;
    }
    return !scene_is_full();
}

static void print_vector(const char *name, vec3 v) {
    printf("%s %.9g %.9g %.9g\n", name, v.x, v.y, v.z);
}

static void list_object(const object *obj) {
    const material *m = &obj->mat;
    if (obj->type == SPHERE) {
        printf("sphere %.9g %.9g %.9g %.9g", obj->center.x, obj->center.y, obj->center.z, obj->radius);
    } else {
        printf("plane %.9g %.9g %.9g %.9g", obj->normal.x, obj->normal.y, obj->normal.z, obj->dist);
    }
    printf(" %.9g %.9g %.9g %.9g %.9g\n", m->kd.x, m->kd.y, m->kd.z, m->ks.x, m->shininess);
}

static void list_scene(void) {
    print_vector("eye", theCamera.position);
    print_vector("center", theCamera.center);
    print_vector("xdir", theCamera.xdir);
    print_vector("ydir", theCamera.ydir);
    for (int k = 0; k < num_lights; k++) {
        point3 p = lights[k].position;
        printf("light %.9g %.9g %.9g %.9g\n", p.x, p.y, p.z, lights[k].col.x);
    }
    for (int k = 0; k < object_count; k++) {
        list_object(&scene[k]);
    }
}

/* ---- Measures ----------------------------------------------------------------------------------- */

/* Rebuilds the scene's structure with or without the octree; CPU seconds. */
static double build(bool octree) {
    options.octree = octree;
    double start = cpu_seconds();
    scene_changed();
    return cpu_seconds() - start;
}

static double draw_picture(void) {
    double start = cpu_seconds();
    raytrace();
    return cpu_seconds() - start;
}

/* FNV-1a of the picture's bits: equal pictures give equal numbers. */
static unsigned long picture_hash(void) {
    const unsigned char *bytes = (const unsigned char *)output_image;
    unsigned int hash = 2166136261U;
    for (size_t k = 0; k < sizeof output_image; k++) {
        hash = (hash ^ bytes[k]) * 16777619U;
    }
    return hash;
}

static void measure(bool octree) {
    double build_seconds = build(octree);
    double render_seconds = draw_picture();
    printf("objects %d\nbuild_seconds %.6f\nrender_seconds %.6f\n", object_count, build_seconds, render_seconds);
    printf("picture %lu\n", picture_hash());
    print_counts();
}

static void compare(int rounds) {
    for (int k = 0; k < rounds; k++) {
        build(true);
        printf("octree %.6f\n", draw_picture());
        build(false);
        printf("plain %.6f\n", draw_picture());
    }
}

int main(int argc, char **argv) {
    const char *mode = argc > 2 ? argv[2] : "";
    if (argc < 2 || !set_up(argv[1])) {
        fputs("driver: no such scene, or SCENE_SIZE is too small for it\n", stderr);
        return 2;
    }
    if (strcmp(mode, "--list") == 0) {
        list_scene();
    } else if (strcmp(mode, "--compare") == 0) {
        compare(argc > 3 ? atoi(argv[3]) : 1);
    } else {
        measure(strcmp(mode, "--plain") != 0);
    }
    octree_free(scene_octree);
    return 0;
}
