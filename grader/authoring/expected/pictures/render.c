/* render.c - Draws pictures of the scenes, and maps of what stands where, for the generator of expected pictures.
 *
 *   render TEXTURE < ORDERS > RAW
 *
 * TEXTURE: two int32 (width, height), then width * height colours of three float32, row 0 at the top. Each order is a
 * line of numbers: 0 or 1 (a picture, or maps), the scene, the fields of render_options in their order, and a seed: 0
 * draws with raytrace(), another number draws each pixel here, with other random numbers. A picture is written as
 * float32 (HEIGHT, WIDTH, 3), row 0 at the bottom; maps as one struct pixel_map for each pixel.
 * It links with the sources of any variant of the solution, also one whose floats are doubles.
 */
#include "exercises.h"
#include "globals.h"

#include <stdio.h>
#include <stdlib.h>

/* A path is followed as long as what it adds counts for that much: less does not show. */
static const double LEAST_WEIGHT = 0.02;

enum { NOTHING = -1, BEHIND = -2 };

typedef struct pixel_map_s {
    float t;
    float normal[3];
    float highlight;    /* brightest channel of the specular light, without Fresnel or shadows */
    float kr;           /* Fresnel's coefficient for the mirror, brightest channel */
    int32_t object;     /* index in scene[], or NOTHING */
    int32_t mirrored;   /* what its mirror ray meets, or NOTHING */
    int32_t blocker[3]; /* by light: what casts a shadow there, NOTHING, or BEHIND when n.l <= 0 */
    uint32_t path[4];   /* hash of the path: kd alone, + shadows, + mirrors by ks, + mirrors by Fresnel */
    int32_t bounces[2]; /* mirror rays that count: by ks, by Fresnel */
    float n_l[3];       /* by light: cosine between the normal and the way to the light */
    float kd[3];        /* diffuse colour, the pattern's where there is one */
    float fresnel[3];   /* Fresnel's coefficients for the mirror */
    float lit[2][3][3]; /* by light, what shade gives: with ks in the lobe, with Fresnel */
} pixel_map;

/* Nearest hit of the plain list: its index or NOTHING. */
static int hit_index(ray *r, intersection *it) {
    int found = NOTHING;
    for (int k = 0; k < object_count; k++) {
        if (intersect_object(r, it, &scene[k])) {
            found = k;
        }
    }
    return found;
}

static int blocker_of(const intersection *it, const light *from) {
    vec3 way = vector_minus(from->position, it->position);
    vec3 l = vector_normalized(way);
    if (vector_dot(it->normal, l) <= 0) {
        return BEHIND;
    }
    ray r;
    intersection unused;
    ray_init(&r, vector_add(it->position, vector_float_mul(options.epsilon, l)), l);
    r.tmax = vector_norm(way) - options.epsilon;
    return hit_index(&r, &unused);
}

static uint32_t mixed(uint32_t hash, int value) {
    return ray_hash(hash ^ ((uint32_t)value + 0x9e3779b9U));
}

static double brightest(color c) {
    double most = c.x > c.y ? c.x : c.y;
    return c.z > most ? c.z : most;
}

/* Adds what is hit and its place in a pattern, which the pattern's colour tells. */
static uint32_t mixed_hit(uint32_t hash, int object, const intersection *it) {
    color kd = it->mat.kd;
    hash = mixed(hash, object);
    return mixed(mixed(mixed(hash, (int)(kd.x * 4096)), (int)(kd.y * 4096)), (int)(kd.z * 4096));
}

static uint32_t mixed_lights(uint32_t hash, const intersection *it) {
    for (int k = 0; k < num_lights; k++) {
        int blocker = blocker_of(it, &lights[k]);
        hash = mixed(hash, blocker >= 0 ? 1 : blocker);
    }
    return hash;
}

/* Follows the mirrors from a first hit; returns the number of bounces that count. */
static int follow(ray r, int object, intersection it, bool fresnel, uint32_t *hash) {
    color weight = vector_init(1, 1, 1);
    for (int bounce = 0; bounce < options.max_depth; bounce++) {
        vec3 v = vector_normalized(vector_float_mul(-1, r.dir));
        weight = vector_vec_mul(weight, fresnel ? fresnel_schlick(it.mat.kr, it.normal, v) : it.mat.ks);
        if (brightest(weight) < LEAST_WEIGHT) {
            return bounce;
        }
        ray next;
        reflected_ray(&next, &r, &it);
        r = next;
        object = hit_index(&r, &it);
        if (object == NOTHING) {
            *hash = mixed(*hash, NOTHING);
            return bounce + 1;
        }
        it.mat.kd = surface_color(&it);
        *hash = mixed_lights(mixed_hit(*hash, object, &it), &it);
    }
    return options.max_depth;
}

static double highlight_of(const intersection *it, vec3 v) {
    color sum = vector_init(0, 0, 0);
    material gloss = it->mat;
    gloss.kd = sum;
    for (int k = 0; k < num_lights; k++) {
        vec3 l = vector_normalized(vector_minus(lights[k].position, it->position));
        sum = vector_add(sum, shade(it->normal, v, l, lights[k].col, &gloss));
    }
    return brightest(sum);
}

static void put_color(float *to, color c) {
    to[0] = (float)c.x;
    to[1] = (float)c.y;
    to[2] = (float)c.z;
}

/* What each light gives by itself, shadows left out. */
static void map_lights(pixel_map *map, const intersection *it, vec3 v) {
    bool fresnel = options.fresnel;
    for (int k = 0; k < num_lights; k++) {
        vec3 l = vector_normalized(vector_minus(lights[k].position, it->position));
        map->n_l[k] = (float)vector_dot(it->normal, l);
        for (int with = 0; with < 2; with++) {
            options.fresnel = with == 1;
            put_color(map->lit[with][k], shade(it->normal, v, l, lights[k].col, &it->mat));
        }
    }
    options.fresnel = fresnel;
}

static pixel_map map_of(int i, int j) {
    pixel_map map = {0};
    ray r;
    intersection it;
    camera_ray(&r, (float)i + 0.5f, (float)j + 0.5f);
    map.object = hit_index(&r, &it);
    map.mirrored = NOTHING;
    for (int k = 0; k < 3; k++) {
        map.blocker[k] = BEHIND;
    }
    if (map.object == NOTHING) {
        return map;
    }
    it.mat.kd = surface_color(&it);
    vec3 v = vector_normalized(vector_float_mul(-1, r.dir));
    map.t = (float)r.tmax;
    map.normal[0] = (float)it.normal.x;
    map.normal[1] = (float)it.normal.y;
    map.normal[2] = (float)it.normal.z;
    map.highlight = (float)highlight_of(&it, v);
    map.kr = (float)brightest(fresnel_schlick(it.mat.kr, it.normal, v));
    for (int k = 0; k < num_lights; k++) {
        map.blocker[k] = blocker_of(&it, &lights[k]);
    }
    put_color(map.kd, it.mat.kd);
    put_color(map.fresnel, fresnel_schlick(it.mat.kr, it.normal, v));
    map_lights(&map, &it, v);
    map.path[0] = mixed_hit(1, map.object, &it);
    map.path[1] = map.path[2] = map.path[3] = mixed_lights(map.path[0], &it);
    for (int fresnel = 0; fresnel < 2; fresnel++) {
        map.bounces[fresnel] = follow(r, map.object, it, fresnel == 1, &map.path[2 + fresnel]);
    }
    ray mirror;
    reflected_ray(&mirror, &r, &it);
    map.mirrored = hit_index(&mirror, &it);
    return map;
}

static void draw_scene(uint32_t seed) {
    if (seed == 0) {
        raytrace();
        return;
    }
    for (int j = 0; j < HEIGHT; j++) {
        for (int i = 0; i < WIDTH; i++) {
            ray r;
            camera_ray(&r, (float)i + 0.5f, (float)j + 0.5f);
            r.seed = ray_hash(pixel_seed(i, j, 0) + seed);
            output_image[j * WIDTH + i] = trace_ray(&r);
        }
    }
}

static void put(const void *what, size_t size) {
    if (fwrite(what, size, 1, stdout) != 1) {
        perror("render");
        exit(1);
    }
}

static void write_picture(void) {
    for (int k = 0; k < WIDTH * HEIGHT; k++) {
        color c = output_image[k];
        float triple[3] = {(float)c.x, (float)c.y, (float)c.z};
        put(triple, sizeof triple);
    }
}

static void write_maps(void) {
    for (int j = 0; j < HEIGHT; j++) {
        for (int i = 0; i < WIDTH; i++) {
            pixel_map map = map_of(i, j);
            put(&map, sizeof map);
        }
    }
}

static bool read_texture(const char *path) {
    int32_t size[2];
    FILE *file = fopen(path, "rb");
    if (file == NULL || fread(size, sizeof size, 1, file) != 1) {
        return false;
    }
    int count = size[0] * size[1];
    scene_texture.width = size[0];
    scene_texture.height = size[1];
    scene_texture.texels = (color *)malloc(sizeof(color) * (size_t)count);
    for (int k = 0; k < count && scene_texture.texels != NULL; k++) {
        float triple[3];
        if (fread(triple, sizeof triple, 1, file) != 1) {
            return false;
        }
        scene_texture.texels[k] = vector_init(triple[0], triple[1], triple[2]);
    }
    fclose(file);
    return scene_texture.texels != NULL;
}

int main(int argc, char **argv) {
    if (argc != 2 || !read_texture(argv[1])) {
        fprintf(stderr, "render: no texture\n");
        return 2;
    }
    int maps, number, flags[6], samples, depth;
    double epsilon;
    unsigned seed;
    while (scanf("%d %d %d %d %d %d %d %d %d %d %lf %u", &maps, &number, &flags[0], &flags[1], &flags[2], &flags[3],
                 &flags[4], &flags[5], &samples, &depth, &epsilon, &seed) == 12) {
        render_options wanted = {flags[0] != 0, flags[1] != 0, flags[2] != 0, flags[3] != 0, flags[4] != 0,
                                 flags[5] != 0, samples,       depth,         (float)epsilon};
        options = wanted;
        if (!setup_scene(number)) {
            fprintf(stderr, "render: no scene %d\n", number);
            return 2;
        }
        if (maps != 0) {
            write_maps();
        } else {
            draw_scene(seed);
            write_picture();
        }
    }
    return 0;
}
