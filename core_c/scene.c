/* scene.c - Given: constructors, the glue between your functions, and the scenes.
 *
 * Read it as you like; change nothing: your work is always judged with the original file.
 */
#include "exercises.h"

static const float PI = 3.14159265f;

render_options options = {true, true, true, true, true, true, 1, 10, EPSILON};
texture scene_texture = {0, 0, NULL};
octree_node *scene_octree = NULL;

static unsigned char own_todo_page[TODO_PAGE_SIZE];
unsigned char *todo_page = own_todo_page;

/* Indices in scene[] of the planes: they are tested apart, since no box holds them. */
static int planes[SCENE_SIZE];
static int plane_count = 0;

static bool refused = false;

/* ---- Exercises still to do ------------------------------------------------------------------- */

void todo_note(const char *id) {
    if (id[0] != 'T' || id[1] != 'P' || id[2] < '1' || id[2] > '8' || id[3] != '.') {
        return;
    }
    const char *digit = id + 4;
    int bonus = *digit == 'B' ? 8 : 0;
    if (bonus != 0) {
        digit++;
    }
    if (digit[0] >= '1' && digit[0] <= '7' && digit[1] == '\0') {
        todo_page[16 * (id[2] - '1') + bonus + (digit[0] - '0')] = 1;
    }
}

/* ---- Constructors ---------------------------------------------------------------------------- */

static color grey(float level) {
    return vector_init(level, level, level);
}

material init_material(color kd, color ks, float shininess) {
    material mat;
    mat.kd = kd;
    mat.ks = ks;
    mat.shininess = shininess;
    mat.kr = ks;
    mat.refraction_index = 0.f;
    mat.pattern = PATTERN_NONE;
    mat.kd2 = grey(0.f);
    mat.pattern_origin = grey(0.f);
    mat.pattern_size = 1.f;
    for (int k = 0; k < 4; k++) {
        mat.user[k] = 0.f;
    }
    return mat;
}

object init_cylinder(point3 base, vec3 axis, float length, float radius, material mat) {
    object obj;
    obj.type = CYLINDER;
    obj.radius = radius;
    obj.base = base;
    obj.axis = vector_normalized(axis);
    obj.length = length;
    obj.mat = mat;
    return obj;
}

object init_cone(point3 base, vec3 axis, float length, float radius, material mat) {
    object obj = init_cylinder(base, axis, length, radius, mat);
    obj.type = CONE;
    return obj;
}

object init_sphere(float x, float y, float z, float radius, material mat) {
    /* By way of the union's largest member, so that no byte is left uninitialised. */
    object obj = init_cylinder(grey(0.f), grey(0.f), 0.f, radius, mat);
    obj.type = SPHERE;
    obj.center = vector_init(x, y, z);
    return obj;
}

object init_plane(float nx, float ny, float nz, float d, material mat) {
    object obj = init_cylinder(grey(0.f), grey(0.f), 0.f, 0.f, mat);
    obj.type = PLANE;
    obj.normal = vector_normalized(vector_init(nx, ny, nz));
    obj.dist = d;
    return obj;
}

camera init_camera(point3 position, point3 at, vec3 up, float fov, float aspect) {
    camera cam;
    cam.position = position;
    cam.zdir = vector_normalized(vector_minus(at, position));
    cam.xdir = vector_normalized(vector_cross(up, cam.zdir));
    cam.ydir = vector_normalized(vector_cross(cam.zdir, cam.xdir));
    cam.center = vector_float_mul(1.f / tanf(0.5f * fov * PI / 180.f), cam.zdir);
    cam.fov = fov;
    cam.aspect = aspect;
    return cam;
}

/* ---- Building a scene ------------------------------------------------------------------------ */

bool add_object(object obj) {
    if (object_count < 0 || object_count >= SCENE_SIZE) {
        refused = true;
        return false;
    }
    scene[object_count++] = obj;
    return true;
}

bool add_light(point3 position, color col) {
    if (num_lights < 0 || num_lights >= MAX_LIGHTS) {
        refused = true;
        return false;
    }
    lights[num_lights].position = position;
    lights[num_lights].col = col;
    num_lights++;
    return true;
}

bool scene_is_full(void) {
    return refused;
}

/* v turned about a unit axis by the angle that has this cosine and sine (Rodrigues' formula). */
static vec3 rotated(vec3 v, vec3 axis, float cosine, float sine) {
    vec3 turned = vector_float_mul(cosine, v);
    turned = vector_add(turned, vector_float_mul(sine, vector_cross(axis, v)));
    return vector_add(turned, vector_float_mul((1.f - cosine) * vector_dot(axis, v), axis));
}

/* v turned by the rotation that brings the z axis to a unit direction. */
static vec3 turned_from_z(vec3 v, vec3 direction) {
    vec3 axis = vector_init(-direction.y, direction.x, 0.f);
    float sine = vector_norm(axis);
    if (sine < 1e-6f) { /* nothing to turn or, upside down, half a turn about x */
        return direction.z > 0.f ? v : vector_init(v.x, -v.y, -v.z);
    }
    return rotated(v, vector_float_mul(1.f / sine, axis), direction.z, sine);
}

/* Direction of the k-th of the nine spheres that stand on a sphere whose own direction is z. */
static vec3 flake_direction(int k) {
    const float d = sqrtf(0.5f);
    const vec3 corner[3] = {{d, d, 0.f}, {d, 0.f, -d}, {0.f, d, -d}};
    /* By asin(2 / sqrt 6) about (1, -1, 0): the three then lie evenly about z ... */
    vec3 v = rotated(corner[k % 3], vector_init(d, -d, 0.f), sqrtf(1.f / 3.f), sqrtf(2.f / 3.f));
    /* ... and there are three such triples, a third of a turn apart. */
    float turn = 2.f * PI / 3.f * (float)(k / 3);
    return rotated(v, vector_init(0.f, 0.f, 1.f), cosf(turn), sinf(turn));
}

void add_flake(point3 center, float radius, vec3 direction, int depth, const material *mat) {
    if (!add_object(init_sphere(center.x, center.y, center.z, radius, *mat)) || depth <= 0) {
        return;
    }
    for (int k = 0; k < 9; k++) {
        vec3 out = vector_normalized(turned_from_z(flake_direction(k), direction));
        point3 child = vector_add(center, vector_float_mul(radius * 4.f / 3.f, out));
        add_flake(child, radius / 3.f, out, depth - 1, mat);
    }
}

void scene_changed(void) {
    plane_count = 0;
    for (int k = 0; k < object_count; k++) {
        if (scene[k].type == PLANE) {
            planes[plane_count++] = k;
        }
    }
    octree_free(scene_octree);
    scene_octree = options.octree ? octree_build(scene, object_count) : NULL;
}

/* ---- Glue ------------------------------------------------------------------------------------ */

bool intersect_object(ray *r, intersection *it, const object *obj) {
    switch (obj->type) {
    case SPHERE:
        return intersect_sphere(r, it, obj);
    case PLANE:
        return intersect_plane(r, it, obj);
    case CYLINDER:
        return intersect_cylinder(r, it, obj);
    case CONE:
        return intersect_cone(r, it, obj);
    default:
        return false;
    }
}

bool nearest_hit(ray *r, intersection *it) {
    bool hit;
    if (options.octree && scene_octree != NULL) {
        hit = octree_intersect(scene_octree, r, it);
        for (int k = 0; k < plane_count; k++) {
            hit = intersect_plane(r, it, &scene[planes[k]]) || hit;
        }
    } else {
        hit = intersect_scene(r, it);
    }
    if (hit && it->mat.pattern != PATTERN_NONE) {
        it->mat.kd = surface_color(it);
    }
    return hit;
}

color surface_color(const intersection *it) {
    switch (it->mat.pattern) {
    case PATTERN_CHECKER:
        return checker_color(&it->mat, it->position);
    case PATTERN_IMAGE:
        return texture_color(&it->mat, it->position);
    default:
        return it->mat.kd;
    }
}

color hit_color(ray *r, const intersection *it) {
    if (!options.shading) {
        return it->mat.kd;
    }
    vec3 v = vector_normalized(vector_float_mul(-1.f, r->dir));
    color direct = direct_light(it, v);
    if (options.refraction && it->mat.refraction_index > 0.f) {
        return vector_add(direct, glass_color(r, it));
    }
    if (options.reflections) {
        return vector_add(direct, mirror_color(r, it));
    }
    return direct;
}

color sky_color(void) {
    return vector_init(0.2f, 0.2f, 0.6f);
}

/* ---- Scenes of the handout ------------------------------------------------------------------- */

static material with_reflectance(material mat, float reflectance_at_normal) {
    mat.kr = grey(reflectance_at_normal);
    return mat;
}

static void look_from(point3 position, point3 at, float fov) {
    theCamera = init_camera(position, at, vector_init(0.f, 1.f, 0.f), fov, (float)WIDTH / (float)HEIGHT);
}

static void handout_camera(void) {
    look_from(vector_init(2.f, 1.f, 3.f), vector_init(0.f, 0.3f, 0.f), 60.f);
}

static void spheres_of_scene_0(void) {
    add_object(init_sphere(0.f, 0.f, 0.f, 0.3f, init_material(grey(0.5f), grey(0.5f), 200.f)));
    add_object(init_sphere(1.f, -0.05f, 0.f, 0.15f, init_material(vector_init(0.9f, 0.f, 0.f), grey(0.1f), 500.f)));
    add_object(init_sphere(0.f, 1.f, 0.f, 0.25f, init_material(vector_init(0.f, 1.f, 0.f), grey(0.f), 0.01f)));
    add_object(init_sphere(0.f, -0.05f, 1.f, 0.2f, init_material(vector_init(0.f, 0.f, 0.6f), grey(0.4f), 20.f)));
}

static void scene_0(void) {
    handout_camera();
    add_light(vector_init(-200.f, 170.f, 300.f), grey(2.f));
    spheres_of_scene_0();
    add_object(init_plane(0.f, 1.f, 0.f, 0.2f, init_material(vector_init(0.5f, 0.9f, 0.7f), grey(0.01f), 50.f)));
}

static void lights_of_scene_1(void) {
    add_light(vector_init(-2.f, 1.7f, 3.f), grey(1.f));
    add_light(vector_init(3.f, 2.f, 3.f), grey(0.4f));
    add_light(vector_init(4.f, 3.f, -10.f), grey(0.5f));
}

/* Scenes 1 and 2 differ in the diffuse grey of the first sphere. */
static void objects_of_scene_1(float first) {
    material mat = init_material(grey(first), grey(0.5f), 20.f);
    add_object(init_sphere(0.f, 0.f, 0.f, 0.3f, with_reflectance(mat, 0.8f)));
    mat = init_material(vector_init(0.f, 0.f, 1.f), grey(0.5f), 20.f);
    add_object(init_sphere(0.f, -0.05f, 1.f, 0.2f, with_reflectance(mat, 0.5f)));
    mat = init_material(vector_init(0.f, 1.f, 0.f), grey(0.1f), 20.f);
    add_object(init_sphere(0.f, 1.f, 0.f, 0.15f, with_reflectance(mat, 0.04f)));
    mat = init_material(vector_init(1.f, 0.f, 0.f), grey(0.1f), 500.f);
    add_object(init_sphere(1.f, -0.05f, 0.f, 0.15f, with_reflectance(mat, 0.04f)));
    mat = init_material(vector_init(0.5f, 1.f, 0.7f), grey(0.1f), 500.f);
    add_object(init_plane(0.f, 1.f, 0.f, 0.2f, with_reflectance(mat, 0.04f)));
}

static void scene_1(void) {
    handout_camera();
    lights_of_scene_1();
    objects_of_scene_1(0.5f);
}

static void scene_2(void) {
    const vec3 axes[3] = {{1.f, 0.f, 0.f}, {0.f, 1.f, 0.f}, {0.f, 0.f, 1.f}};
    handout_camera();
    lights_of_scene_1();
    objects_of_scene_1(1.f);
    material mat = with_reflectance(init_material(vector_init(1.f, 1.f, 0.f), grey(0.1f), 500.f), 0.f);
    for (int k = 0; k < 3; k++) {
        add_object(init_cylinder(grey(0.f), axes[k], 1.f, 0.05f, mat));
    }
}

/* true when a sphere's centre lies within a distance of p. */
static bool center_near(point3 p, float distance) {
    for (int k = 0; k < object_count; k++) {
        if (vector_sqnorm(vector_minus(scene[k].center, p)) < distance * distance) {
            return true;
        }
    }
    return false;
}

static void scene_3(void) {
    handout_camera();
    lights_of_scene_1();
    /* A ray's own generator: the same spheres on every machine. Coinciding ones would make the picture
     * depend on their order, so a centre too near another is drawn again. */
    ray dice;
    ray_init(&dice, grey(0.f), grey(0.f));
    for (int made = 0; made < 1024 && !refused;) {
        float x = 2.f * ray_random(&dice);
        float y = 2.f * ray_random(&dice);
        float z = 2.f * ray_random(&dice);
        if (center_near(vector_init(x, y, z), 1e-3f)) {
            continue;
        }
        float red = ray_random(&dice);
        float green = ray_random(&dice);
        float blue = ray_random(&dice);
        material mat = init_material(vector_init(red, green, blue), grey(0.5f), 20.f);
        add_object(init_sphere(x, y, z, 0.1f, with_reflectance(mat, 0.8f)));
        made++;
    }
}

static void scene_4(void) {
    handout_camera();
    add_light(vector_init(0.f, 1.7f, 1.f), grey(1.f));
    add_light(vector_init(3.f, 2.f, 3.f), grey(0.4f));
    add_light(vector_init(4.f, 3.f, -1.f), grey(0.5f));
    spheres_of_scene_0();
    add_object(init_plane(0.f, 1.f, 0.f, 0.2f, init_material(vector_init(0.5f, 0.9f, 0.7f), grey(0.01f), 50.f)));
    add_object(init_plane(1.f, 0.f, -1.f, 2.f,
                          init_material(vector_init(0.8f, 0.09f, 0.07f), vector_init(0.2f, 0.2f, 0.1f), 10.f)));
    add_object(init_plane(0.3f, -0.2f, 1.f, 3.f, init_material(vector_init(0.1f, 0.3f, 0.05f), grey(0.5f), 100.f)));
}

/* ---- Scenes for the extensions ---------------------------------------------------------------- */

/* Opaque plastic: a colour, under a thin clear layer that reflects 4 % of the light at normal incidence. */
static material plastic(float red, float green, float blue) {
    return with_reflectance(init_material(vector_init(red, green, blue), grey(0.3f), 80.f), 0.04f);
}

static material checkered(color kd, color kd2, point3 origin, float size) {
    material mat = with_reflectance(init_material(kd, grey(0.1f), 50.f), 0.02f);
    mat.pattern = PATTERN_CHECKER;
    mat.kd2 = kd2;
    mat.pattern_origin = origin;
    mat.pattern_size = size;
    return mat;
}

static material textured(point3 center) {
    material mat = with_reflectance(init_material(grey(0.8f), grey(0.1f), 60.f), 0.02f);
    mat.pattern = PATTERN_IMAGE;
    mat.pattern_origin = center;
    return mat;
}

/* A transparent material without colour of its own. */
static material transparent(float index) {
    float at_normal = (index - 1.f) / (index + 1.f);
    material mat = with_reflectance(init_material(grey(0.f), grey(0.4f), 400.f), at_normal * at_normal);
    mat.refraction_index = index;
    return mat;
}

/* Seen from the handout's camera: a strong light on the right, a warm one on the left, a cold one at the back. */
static void studio_lights(void) {
    add_light(vector_init(-1.5f, 4.f, 5.f), grey(2.4f));
    add_light(vector_init(6.f, 3.f, 2.5f), vector_init(1.3f, 1.1f, 0.85f));
    add_light(vector_init(-3.f, 3.f, -5.f), vector_init(0.5f, 0.6f, 0.95f));
}

/* The floor y = -0.2 lies in the middle of a layer of cubes, never on the border between two. */
static void checkered_floor(color kd, color kd2) {
    add_object(init_plane(0.f, 1.f, 0.f, 0.2f, checkered(kd, kd2, vector_init(0.f, -0.45f, 0.f), 0.5f)));
}

/* Cylinder and cone: standing, lying, leaning and upside down, so that sides, discs and apex are seen. */
static void scene_5(void) {
    const vec3 up = {0.f, 1.f, 0.f};
    handout_camera();
    studio_lights();
    add_object(init_cylinder(vector_init(-0.1f, -0.3f, -0.4f), up, 0.95f, 0.3f, plastic(0.9f, 0.4f, 0.1f)));
    add_object(init_cone(vector_init(-0.1f, 0.67f, -0.4f), up, 0.55f, 0.42f, plastic(0.8f, 0.12f, 0.1f)));
    add_object(init_cone(vector_init(1.15f, -0.15f, 0.35f), up, 0.8f, 0.3f, plastic(0.15f, 0.5f, 0.9f)));
    add_object(init_cylinder(vector_init(-0.75f, -0.03f, 1.1f), vector_init(1.f, 0.f, 0.55f), 0.7f, 0.16f,
                             plastic(0.3f, 0.8f, 0.35f)));
    add_object(init_cone(vector_init(-1.f, 0.8f, 0.3f), vector_init(-0.35f, -1.f, -0.5f), 0.8f, 0.3f,
                         plastic(0.7f, 0.35f, 0.85f)));
    add_object(init_cone(vector_init(0.8f, 0.f, 1.1f), vector_init(-0.95f, 0.04f, -0.3f), 0.5f, 0.19f,
                         plastic(0.95f, 0.8f, 0.15f)));
    add_object(init_plane(0.f, 1.f, 0.f, 0.2f, plastic(0.6f, 0.7f, 0.7f)));
}

/* Checkerboard and image: a floor, a ball and a drum cut from chequered blocks, and a globe. */
static void scene_6(void) {
    const point3 globe = {0.f, 0.36f, 0.f};
    const point3 ball = {1.15f, 0.11f, 0.4f};
    const point3 drum = {-0.25f, -0.19f, 1.25f};
    handout_camera();
    studio_lights();
    add_object(init_sphere(globe.x, globe.y, globe.z, 0.55f, textured(globe)));
    add_object(init_sphere(ball.x, ball.y, ball.z, 0.3f,
                           checkered(vector_init(0.95f, 0.9f, 0.75f), vector_init(0.6f, 0.1f, 0.1f), ball, 0.14f)));
    add_object(init_cylinder(drum, vector_init(0.f, 1.f, 0.f), 0.35f, 0.24f,
                             checkered(vector_init(0.95f, 0.8f, 0.15f), vector_init(0.1f, 0.25f, 0.6f),
                                       vector_init(-0.25f, -0.22f, 1.25f), 0.1f)));
    checkered_floor(grey(0.85f), grey(0.12f));
}

/* Refraction: a ball of glass and one of water before coloured spheres, on a chequered floor. */
static void scene_7(void) {
    handout_camera();
    studio_lights();
    add_object(init_sphere(0.8f, 0.25f, 1.f, 0.44f, transparent(1.5f)));
    add_object(init_sphere(-0.35f, 0.06f, 1.55f, 0.25f, transparent(1.33f)));
    add_object(init_sphere(-0.6f, 0.15f, -0.7f, 0.34f, plastic(0.9f, 0.12f, 0.08f)));
    add_object(init_sphere(-0.6f, 0.72f, -0.7f, 0.22f, plastic(0.95f, 0.9f, 0.85f)));
    add_object(init_sphere(-0.6f, 1.1f, -0.7f, 0.14f, plastic(0.3f, 0.8f, 0.35f)));
    add_object(init_sphere(1.3f, 0.2f, -1.1f, 0.38f, plastic(0.1f, 0.45f, 0.95f)));
    add_object(init_sphere(-1.9f, 0.25f, 0.3f, 0.44f, plastic(0.95f, 0.75f, 0.1f)));
    checkered_floor(grey(0.85f), grey(0.12f));
}

/* Direction of the k-th of count points spread evenly over a sphere, from top to bottom. */
static vec3 spiral_direction(int k, int count) {
    float y = 1.f - (2.f * (float)k + 1.f) / (float)count;
    float turn = 2.3999632f * (float)k; /* the golden angle */
    float across = sqrtf(1.f - y * y);
    return vector_init(across * cosf(turn), y, across * sinf(turn));
}

/* A small planet of procedural spheres: bushes of 1 + 3 + 9 + 27 + 81 of them stand all over it. */
static void add_planet(point3 center, float radius, int bushes) {
    add_object(init_sphere(center.x, center.y, center.z, radius, plastic(0.85f, 0.8f, 0.65f)));
    for (int k = 0; k < bushes; k++) {
        vec3 dir = spiral_direction(k, bushes);
        float trunk = radius * (k % 3 == 0 ? 0.17f : 0.1f);
        populate_spheres(vector_add(center, vector_float_mul(radius + trunk, dir)), trunk, dir, 4);
    }
}

/* Procedural spheres, as in figure 9, seen from near enough to tell their generations. */
static void scene_8(void) {
    look_from(vector_init(0.55f, 0.95f, 1.05f), vector_init(-0.02f, 0.17f, 0.f), 60.f);
    studio_lights();
    add_planet(vector_init(0.f, 0.f, 0.f), 0.5f, 100);
}

/* The sphere flake of 66,430 spheres, with a vertical field of view of 45 degrees at 16:9. */
static void scene_9(void) {
    const vec3 up = {0.f, 0.f, 1.f};
    material mat = init_material(vector_init(0.5f, 0.45f, 0.35f), grey(0.5f), 50.f);
    theCamera = init_camera(vector_init(2.1f, 1.3f, 1.7f), grey(0.f), up, 72.734f, (float)WIDTH / (float)HEIGHT);
    add_light(vector_init(4.f, 3.f, 2.f), grey(1.f));
    add_light(vector_init(1.f, -4.f, 4.f), grey(1.f));
    add_light(vector_init(-3.f, 1.f, 5.f), grey(1.f));
    add_flake(grey(0.f), 0.5f, up, 5, &mat);
    add_object(init_plane(0.f, 0.f, 1.f, 0.5f, init_material(vector_init(0.8f, 0.6f, 0.26f), grey(0.f), 50.f)));
}

/* A poster with everything. */
static void scene_10(void) {
    const vec3 up = {0.f, 1.f, 0.f};
    const point3 globe = {-0.85f, 0.49f, -0.9f};
    const point3 die = {0.5f, -0.02f, 1.15f};
    look_from(vector_init(1.6f, 1.25f, 3.6f), vector_init(-0.02f, 0.25f, 0.f), 50.f);
    studio_lights();
    add_object(init_sphere(globe.x, globe.y, globe.z, 0.68f, textured(globe)));
    add_planet(vector_init(0.75f, 0.5f, -0.45f), 0.36f, 60);
    add_object(init_cylinder(vector_init(-0.95f, -0.3f, 0.45f), up, 0.6f, 0.19f, plastic(0.9f, 0.45f, 0.12f)));
    add_object(init_cone(vector_init(-0.95f, 0.32f, 0.45f), up, 0.42f, 0.27f, plastic(0.1f, 0.5f, 0.75f)));
    add_object(init_sphere(-0.08f, 0.12f, 0.8f, 0.31f, transparent(1.5f)));
    add_object(
        init_sphere(1.15f, 0.03f, 0.65f, 0.22f, init_material(grey(0.05f), vector_init(0.9f, 0.72f, 0.35f), 300.f)));
    add_object(init_sphere(die.x, die.y, die.z, 0.17f,
                           checkered(vector_init(0.95f, 0.9f, 0.75f), vector_init(0.6f, 0.1f, 0.1f), die, 0.08f)));
    add_object(init_cylinder(vector_init(-0.95f, -0.07f, 1.15f), vector_init(1.f, 0.f, 0.55f), 0.4f, 0.12f,
                             plastic(0.3f, 0.8f, 0.35f)));
    checkered_floor(grey(0.85f), vector_init(0.12f, 0.17f, 0.3f));
}

bool setup_scene(int number) {
    static void (*const scenes[])(void) = {scene_0, scene_1, scene_2, scene_3, scene_4, scene_5,
                                           scene_6, scene_7, scene_8, scene_9, scene_10};
    const int known = (int)(sizeof scenes / sizeof scenes[0]);
    if (number < 0 || number >= known) {
        return false;
    }
    object_count = 0;
    num_lights = 0;
    refused = false;
    scenes[number]();
    scene_changed();
    return true;
}
