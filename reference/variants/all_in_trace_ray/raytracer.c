/* raytracer.c - Rays, objects, light and mirrors (TP2 to TP5).
 *
 * The functions stand in the order of the exercises. exercises.h has their contracts, and how they call one another.
 */
#include "raytracer.h"

static const float PI = 3.14159265f;

/* Is t in the ray's range? Then the hit is written down. */
static bool record_hit(ray *r, intersection *it, float t, vec3 normal, const material *mat) {
    if (!(t >= r->tmin && t <= r->tmax)) {
        return false;
    }
    r->tmax = t;
    it->position = ray_at(*r, t);
    it->normal = normal;
    it->mat = *mat;
    return true;
}

/* ============================== TP2 - Rays and objects ========================================= */

/* TP2.1 - The ray of the camera through a position of the image. */
void camera_ray(ray *r, float x, float y) {
    const float half_width = (float)WIDTH / 2.f;
    const float half_height = (float)HEIGHT / 2.f;
    vec3 right = vector_float_mul((x - half_width) / half_width, theCamera.xdir);
    vec3 up = vector_float_mul((y - half_height) / half_height / theCamera.aspect, theCamera.ydir);
    vec3 dir = vector_add(theCamera.center, vector_add(right, up));
    ray_init(r, theCamera.position, vector_normalized(dir));
}

/* TP2.2 - The picture of the scene. */
void raytrace(void) {
    const int side = options.samples;
    for (int k = 0; k < WIDTH * HEIGHT; k++) {
        color sum = vector_init(0.f, 0.f, 0.f);
        for (int s = 0; s < side * side; s++) {
            ray r;
            float x = ((float)(s % side) + 0.5f) / (float)side;
            float y = ((float)(s / side) + 0.5f) / (float)side;
            camera_ray(&r, (float)(k % WIDTH) + x, (float)(k / WIDTH) + y);
            r.seed = pixel_seed(k % WIDTH, k / WIDTH, s);
            color seen = trace_ray(&r);
            sum = vector_add(sum, side > 1 ? vector_clamp(seen, 0.f, 1.f) : seen);
        }
        output_image[k] = vector_float_mul(1.f / (float)(side * side), sum);
    }
}

/* TP2.3 - Intersection of a ray and a plane. */
bool intersect_plane(ray *r, intersection *it, const object *obj) {
    float slope = vector_dot(r->dir, obj->normal);
    if (slope == 0.f) {
        return false;
    }
    return record_hit(r, it, -(vector_dot(r->orig, obj->normal) + obj->dist) / slope, obj->normal, &obj->mat);
}

/* TP2.4 - Nearest intersection of a ray and a sphere. */
bool intersect_sphere(ray *r, intersection *it, const object *obj) {
    vec3 o = vector_minus(r->orig, obj->center);
    float a = vector_sqnorm(r->dir);
    float b = vector_dot(o, r->dir);
    float delta = b * b - a * (vector_sqnorm(o) - obj->radius * obj->radius);
    if (!(delta >= 0.f)) {
        return false;
    }
    float near = (-b - sqrtf(delta)) / a;
    float t = near < r->tmin ? (-b + sqrtf(delta)) / a : near;
    vec3 outwards = vector_minus(ray_at(*r, t), obj->center);
    return record_hit(r, it, t, vector_normalized(outwards), &obj->mat);
}

/* TP2.5 - Nearest intersection of a ray and all the objects. */
bool intersect_scene(ray *r, intersection *it) {
    bool hit = false;
    for (int k = 0; k < object_count; k++) {
        /* Each hit lowers tmax, so the last one found is the nearest. */
        if (intersect_object(r, it, &scene[k])) {
            hit = true;
        }
    }
    return hit;
}

/* TP2.6 - The colour seen along a ray: all of it, whatever the options. */
color trace_ray(ray *r) {
    if (r->depth > 10) {
        return vector_init(0.f, 0.f, 0.f);
    }
    intersection it;
    if (!intersect_scene(r, &it)) {
        return sky_color();
    }
    vec3 white = vector_init(1.f, 1.f, 1.f);
    /* The colour of the place. */
    vec3 place = vector_minus(it.position, it.mat.pattern_origin);
    if (it.mat.pattern == PATTERN_CHECKER) {
        vec3 cube = vector_float_mul(1.f / it.mat.pattern_size, place);
        int sum = (int)floorf(cube.x) + (int)floorf(cube.y) + (int)floorf(cube.z);
        it.mat.kd = sum % 2 == 0 ? it.mat.kd : it.mat.kd2;
    }
    if (it.mat.pattern == PATTERN_IMAGE && scene_texture.texels != NULL) {
        vec3 d = vector_normalized(place);
        int column = (int)((0.5f + atan2f(d.x, d.z) / (2.f * PI)) * (float)scene_texture.width);
        int row = (int)(acosf(vector_clamp(d, -1.f, 1.f).y) / PI * (float)scene_texture.height);
        column = column < scene_texture.width ? column : scene_texture.width - 1;
        row = row < scene_texture.height ? row : scene_texture.height - 1;
        it.mat.kd = scene_texture.texels[row * scene_texture.width + column];
    }
    /* The lights. */
    vec3 v = vector_normalized(vector_float_mul(-1.f, r->dir));
    color sum = vector_init(0.f, 0.f, 0.f);
    for (int k = 0; k < num_lights; k++) {
        vec3 to_light = vector_minus(lights[k].position, it.position);
        vec3 l = vector_normalized(to_light);
        float n_l = vector_dot(it.normal, l);
        if (n_l <= 0.f) {
            continue;
        }
        ray shadow;
        ray_init(&shadow, vector_add(it.position, vector_float_mul(EPSILON, l)), l);
        shadow.tmax = vector_norm(to_light) - EPSILON;
        intersection unused;
        if (intersect_scene(&shadow, &unused)) {
            continue;
        }
        vec3 h = vector_normalized(vector_add(l, v));
        float h_v = fmaxf(vector_dot(h, v), 0.f);
        float s = it.mat.shininess;
        float lobe = powf(fmaxf(vector_dot(h, it.normal), 0.f), s) * (s + 8.f) / (8.f * PI);
        color f = vector_add(it.mat.kr, vector_float_mul(powf(1.f - h_v, 5.f), vector_minus(white, it.mat.kr)));
        color brdf = vector_add(vector_float_mul(1.f / PI, it.mat.kd), vector_float_mul(lobe, f));
        sum = vector_add(sum, vector_float_mul(n_l, vector_vec_mul(lights[k].col, brdf)));
    }
    /* The ray that goes on, and its part. */
    float n_v = vector_dot(it.normal, v);
    float x = powf(1.f - fmaxf(n_v, 0.f), 5.f);
    color part = vector_add(it.mat.kr, vector_float_mul(x, vector_minus(white, it.mat.kr)));
    vec3 dir = vector_reflect(r->dir, it.normal);
    if (options.refraction && it.mat.refraction_index > 0.f) {
        part = white;
        float ratio = n_v < 0.f ? it.mat.refraction_index : 1.f / it.mat.refraction_index;
        float zero = (1.f - it.mat.refraction_index) / (1.f + it.mat.refraction_index);
        float odds = zero * zero + (1.f - zero * zero) * powf(1.f - fabsf(n_v), 5.f);
        float cos2 = 1.f - ratio * ratio * (1.f - n_v * n_v);
        if (ray_random(r) >= odds && cos2 >= 0.f) {
            vec3 n = n_v < 0.f ? vector_float_mul(-1.f, it.normal) : it.normal;
            vec3 along = vector_add(vector_float_mul(fabsf(n_v), n), vector_normalized(r->dir));
            dir = vector_minus(vector_float_mul(ratio, along), vector_float_mul(sqrtf(cos2), n));
        }
    }
    dir = vector_normalized(dir);
    ray next;
    ray_init(&next, vector_add(it.position, vector_float_mul(EPSILON, dir)), dir);
    next.depth = r->depth + 1;
    next.seed = r->seed;
    return vector_add(sum, vector_vec_mul(part, trace_ray(&next)));
}

/* TP2.B1 and TP2.B2 - What meets the endless double cone or cylinder whose circle, at a height along the axis, has
 * the radius at_base + widening * height; and the discs. */
static bool intersect_round(ray *r, intersection *it, const object *obj, float at_base, float widening) {
    vec3 o = vector_minus(r->orig, obj->base);
    float o_up = vector_dot(o, obj->axis);
    float d_up = vector_dot(r->dir, obj->axis);
    vec3 o_across = vector_minus(o, vector_float_mul(o_up, obj->axis));
    vec3 d_across = vector_minus(r->dir, vector_float_mul(d_up, obj->axis));
    double width = at_base + widening * o_up;
    double grows = widening * d_up;
    double a = vector_sqnorm(d_across) - grows * grows;
    double b = vector_dot(o_across, d_across) - width * grows;
    double c = vector_sqnorm(o_across) - width * width;
    double delta = b * b - a * c;
    bool hit = false;
    for (int side = -1; side <= 1 && delta >= 0. && a != 0.; side += 2) {
        float t = (float)((-b + side * sqrt(delta)) / a);
        float up = o_up + t * d_up;
        if (up < 0.f || up > obj->length) {
            continue;
        }
        vec3 out = vector_normalized(vector_add(o_across, vector_float_mul(t, d_across)));
        vec3 normal = vector_normalized(vector_minus(out, vector_float_mul(widening, obj->axis)));
        hit = record_hit(r, it, t, normal, &obj->mat) || hit;
    }
    for (int end = 0; end < 2; end++) {
        float up = end == 0 ? 0.f : obj->length;
        float reach = at_base + widening * up;
        float t = (up - o_up) / d_up;
        vec3 from_axis = vector_add(o_across, vector_float_mul(t, d_across));
        if (reach > 0.f && d_up != 0.f && vector_sqnorm(from_axis) <= reach * reach) {
            vec3 normal = vector_float_mul(end == 0 ? -1.f : 1.f, obj->axis);
            hit = record_hit(r, it, t, normal, &obj->mat) || hit;
        }
    }
    return hit;
}

/* TP2.B1 - Nearest intersection of a ray and a finite cylinder with its two discs. */
bool intersect_cylinder(ray *r, intersection *it, const object *obj) {
    return intersect_round(r, it, obj, obj->radius, 0.f);
}

/* TP2.B2 - Nearest intersection of a ray and a cone with its disc. */
bool intersect_cone(ray *r, intersection *it, const object *obj) {
    return intersect_round(r, it, obj, obj->radius, -obj->radius / obj->length);
}

/* ============================== TP3 - Light and matter ========================================= */

/* TP3.1 - What one light sends to the eye from a point of a surface (Blinn-Phong). */
color shade(vec3 n, vec3 v, vec3 l, color light_color, const material *mat) {
    MRT_TODO("TP3.1");
    if (options.fresnel) {
        MRT_TODO("TP5.2");
    }
    return vector_init(0.f, 0.f, 0.f);
}

/* TP3.2 - What all the lights send to the eye from a point hit. */
color direct_light(const intersection *it, vec3 v) {
    MRT_TODO("TP3.2");
    color sum = it->mat.kd;
    for (int k = 0; k < num_lights; k++) {
        if (options.shadows && in_shadow(it, &lights[k])) {
            continue;
        }
        /* What this light adds. */
    }
    return sum;
}

/* TP3.B1 - The colour of a checkerboard in space. */
color checker_color(const material *mat, point3 p) {
    MRT_TODO("TP3.B1");
    return mat->kd;
}

/* TP3.B2 - The colour of scene_texture wrapped on a sphere. */
color texture_color(const material *mat, point3 p) {
    MRT_TODO("TP3.B2");
    return mat->kd;
}

/* ============================== TP4 - Shadows and mirrors ====================================== */

/* TP4.1 - Is the way from a point to a light barred? */
bool in_shadow(const intersection *it, const light *from) {
    MRT_TODO("TP4.1");
    return false;
}

/* TP4.2 - The ray that bounces off a mirror. */
void reflected_ray(ray *out, const ray *in, const intersection *it) {
    MRT_TODO("TP4.2");
    *out = *in;
}

/* TP4.3 - What a surface adds by mirroring. */
color mirror_color(const ray *in, const intersection *it) {
    MRT_TODO("TP4.3");
    if (options.fresnel) {
        MRT_TODO("TP5.2");
    }
    return vector_init(0.f, 0.f, 0.f);
}

/* ============================== TP5 - Fresnel and samples ====================================== */

/* TP5.1 - Share of the light that is reflected at normal incidence. */
float reflectance(float n1, float n2) {
    MRT_TODO("TP5.1");
    return 0.f;
}

/* TP5.1 - Fresnel's reflection by Schlick's approximation. */
color fresnel_schlick(color kr, vec3 n, vec3 v) {
    MRT_TODO("TP5.1");
    return kr;
}

/* TP5.3 - The mean colour of a pixel. */
color pixel_color(int i, int j) {
    MRT_TODO("TP5.3");
    return vector_init(0.f, 0.f, 0.f);
}

/* TP5.B1 - The ray that enters or leaves a transparent object. */
bool refracted_ray(ray *out, const ray *in, const intersection *it) {
    MRT_TODO("TP5.B1");
    return false;
}

/* TP5.B1 - What comes through, or off, a transparent object. */
color glass_color(ray *in, const intersection *it) {
    MRT_TODO("TP5.B1");
    return vector_init(0.f, 0.f, 0.f);
}

/* TP5.B2 - Fills the scene with spheres that carry spheres. */
void populate_spheres(point3 center, float radius, vec3 up, int depth) {
    MRT_TODO("TP5.B2");
}
