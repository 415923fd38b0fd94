/* A ray tracer that is right in other ways than the reference's: what the checks must accept.
 *
 * Direct quadratic form, directions of the camera that are not unit, >= for the depth, n.v in the lobe, bounced
 * rays moved along the normal, random samples. With WHOLE: the options and hit_color are ignored, everything is
 * always on but glass, in doubles, and rays start on the surface with a tmin that keeps them off it.
 */
#include "raytracer.h"

#include <stdlib.h>

#ifndef WHOLE
#define WHOLE 0
#endif

static const double PI = 3.14159265358979;

void camera_ray(ray *r, float x, float y) {
    vec3 right = vector_float_mul(2.f * x / WIDTH - 1.f, theCamera.xdir);
    vec3 up = vector_float_mul((2.f * y / HEIGHT - 1.f) / theCamera.aspect, theCamera.ydir);
    vec3 dir = vector_add(vector_add(theCamera.center, right), up);
    ray_init(r, theCamera.position, WHOLE ? vector_normalized(dir) : dir);
}

void raytrace(void) {
    for (int j = 0; j < HEIGHT; j++) {
        for (int i = 0; i < WIDTH; i++) {
            ray r;
            camera_ray(&r, (float)i + 0.5f, (float)j + 0.5f);
            r.seed = pixel_seed(i, j, 0);
            output_image[j * WIDTH + i] = options.samples > 1 ? pixel_color(i, j) : trace_ray(&r);
        }
    }
}

static bool keep(ray *r, intersection *it, double t, vec3 normal, const object *obj) {
    if (!(t >= r->tmin && t <= r->tmax)) {
        return false;
    }
    r->tmax = (float)t;
    it->position = ray_at(*r, (float)t);
    it->normal = normal;
    it->mat = obj->mat;
    return true;
}

bool intersect_plane(ray *r, intersection *it, const object *obj) {
    float slope = vector_dot(obj->normal, r->dir);
    if (fabsf(slope) < 1e-6f) {
        return false;
    }
    return keep(r, it, -(vector_dot(obj->normal, r->orig) + obj->dist) / slope, obj->normal, obj);
}

#if WHOLE
#define NUMBER double
#else
#define NUMBER float
#endif

bool intersect_sphere(ray *r, intersection *it, const object *obj) {
    vec3 o = vector_minus(r->orig, obj->center), d = r->dir;
    NUMBER x = o.x, y = o.y, z = o.z, radius = obj->radius;
    NUMBER a = vector_dot(d, d), b = 2 * (x * d.x + y * d.y + z * d.z);
    NUMBER c = x * x + y * y + z * z - radius * radius;
    NUMBER delta = b * b - 4 * a * c;
    if (delta < 0) {
        return false;
    }
    for (int side = -1; side <= 1; side += 2) {
        NUMBER t = (-b + side * (NUMBER)sqrt((double)delta)) / (2 * a);
        vec3 normal = vector_float_mul(1.f / obj->radius, vector_minus(ray_at(*r, (float)t), obj->center));
        if (keep(r, it, t, normal, obj)) {
            return true;
        }
    }
    return false;
}

bool intersect_scene(ray *r, intersection *it) {
    bool found = false;
    for (int k = object_count - 1; k >= 0; k--) {
        found = intersect_object(r, it, &scene[k]) || found;
    }
    return found;
}

bool intersect_cylinder(ray *r, intersection *it, const object *obj) {
    return false;
}

bool intersect_cone(ray *r, intersection *it, const object *obj) {
    return false;
}

#if WHOLE
color trace_ray(ray *r) {
    intersection it;
    if (r->depth >= options.max_depth) {
        return vector_init(0, 0, 0);
    }
    if (!nearest_hit(r, &it)) {
        return vector_init(0.2f, 0.2f, 0.6f);
    }
    vec3 v = vector_normalized(vector_float_mul(-1, r->dir));
    return vector_add(direct_light(&it, v), mirror_color(r, &it));
}
#else
color trace_ray(ray *r) {
    intersection it;
    if (r->depth >= options.max_depth) {
        return vector_init(0, 0, 0);
    }
    return nearest_hit(r, &it) ? hit_color(r, &it) : sky_color();
}
#endif

color shade(vec3 n, vec3 v, vec3 l, color light_color, const material *mat) {
    double n_l = vector_dot(n, l);
    if (!(n_l > 0)) {
        return vector_init(0, 0, 0);
    }
    vec3 h = vector_normalized(vector_add(l, v));
    double h_n = vector_dot(h, n) > 0 ? vector_dot(h, n) : 0;
    double lobe = pow(h_n, mat->shininess) * (mat->shininess + 8) / (8 * PI);
    color ks = mat->ks;
    if (WHOLE || options.fresnel) {
        ks = fresnel_schlick(mat->kr, WHOLE ? h : n, v);
    }
    return vector_init((float)(light_color.x * n_l * (mat->kd.x / PI + lobe * ks.x)),
                       (float)(light_color.y * n_l * (mat->kd.y / PI + lobe * ks.y)),
                       (float)(light_color.z * n_l * (mat->kd.z / PI + lobe * ks.z)));
}

color direct_light(const intersection *it, vec3 v) {
    color sum = vector_init(0, 0, 0);
    for (int k = 0; k < num_lights; k++) {
        vec3 l = vector_normalized(vector_minus(lights[k].position, it->position));
        if ((WHOLE || options.shadows) && in_shadow(it, &lights[k])) {
            continue;
        }
        sum = vector_add(sum, shade(it->normal, v, l, lights[k].col, &it->mat));
    }
    return sum;
}

color checker_color(const material *mat, point3 p) {
    int x = (int)floor((p.x - mat->pattern_origin.x) / mat->pattern_size);
    int y = (int)floor((p.y - mat->pattern_origin.y) / mat->pattern_size);
    int z = (int)floor((p.z - mat->pattern_origin.z) / mat->pattern_size);
    return ((x + y + z) & 1) == 0 ? mat->kd : mat->kd2;
}

color texture_color(const material *mat, point3 p) {
    if (scene_texture.texels == NULL) {
        return mat->kd;
    }
    vec3 d = vector_normalized(vector_minus(p, mat->pattern_origin));
    int column = (int)((0.5 + atan2(d.x, d.z) / (2 * PI)) * scene_texture.width) % scene_texture.width;
    int row = (int)(acos(fmax(-1, fmin(1, d.y))) / PI * scene_texture.height);
    row = row < scene_texture.height ? row : scene_texture.height - 1;
    return scene_texture.texels[row * scene_texture.width + column];
}

static void start(ray *out, const intersection *it, vec3 dir) {
    float side = vector_dot(dir, it->normal) > 0 ? 1.f : -1.f;
    vec3 off = vector_float_mul(WHOLE ? 0.f : side * 1e-3f, it->normal);
    ray_init(out, vector_add(it->position, off), dir);
    out->tmin = WHOLE ? 1e-4f : 0.f;
}

bool in_shadow(const intersection *it, const light *from) {
    vec3 way = vector_minus(from->position, it->position);
    intersection unused;
    ray r;
    start(&r, it, way);
    r.tmax = 0.999f;
    return vector_sqnorm(way) > 0.f && intersect_scene(&r, &unused);
}

void reflected_ray(ray *out, const ray *in, const intersection *it) {
    int depth = in->depth;
    uint32_t seed = in->seed;
    start(out, it, vector_normalized(vector_reflect(in->dir, it->normal)));
    out->depth = depth + 1;
    out->seed = seed;
}

color mirror_color(const ray *in, const intersection *it) {
    ray r;
    reflected_ray(&r, in, it);
    color k = it->mat.ks;
    if (WHOLE || options.fresnel) {
        k = fresnel_schlick(it->mat.kr, it->normal, vector_normalized(vector_float_mul(-1, in->dir)));
    }
    return vector_vec_mul(k, trace_ray(&r));
}

float reflectance(float n1, float n2) {
    return (float)pow(((double)n1 - n2) / ((double)n1 + n2), 2);
}

color fresnel_schlick(color kr, vec3 n, vec3 v) {
    double f = pow(1 - fmax(0, vector_dot(n, v)), 5);
    return vector_init((float)(kr.x + (1 - kr.x) * f), (float)(kr.y + (1 - kr.y) * f), (float)(kr.z + (1 - kr.z) * f));
}

color pixel_color(int i, int j) {
    color sum = vector_init(0, 0, 0);
    for (int a = 0; a < options.samples; a++) {
        for (int b = 0; b < options.samples; b++) {
            float x = 0.1f + 0.8f * (float)rand() / (float)RAND_MAX, y = 0.1f + 0.8f * (float)rand() / (float)RAND_MAX;
            ray r;
            camera_ray(&r, (float)i + ((float)a + x) / (float)options.samples, (float)j + ((float)b + y) / (float)options.samples);
            r.seed = pixel_seed(i, j, a * options.samples + b);
            sum = vector_add(sum, vector_clamp(trace_ray(&r), 0, 1));
        }
    }
    return vector_float_mul(1.f / (float)(options.samples * options.samples), sum);
}

bool refracted_ray(ray *out, const ray *in, const intersection *it) {
    vec3 d = vector_normalized(in->dir), n = it->normal;
    double ratio = 1 / it->mat.refraction_index, cosine = -vector_dot(d, n);
    if (cosine < 0) {
        n = vector_float_mul(-1, n);
        cosine = -cosine;
        ratio = it->mat.refraction_index;
    }
    double rest = 1 - ratio * ratio * (1 - cosine * cosine);
    if (rest < 0) {
        return false;
    }
    vec3 dir = vector_add(vector_float_mul((float)ratio, d), vector_float_mul((float)(ratio * cosine - sqrt(rest)), n));
    int depth = in->depth;
    start(out, it, dir);
    out->depth = depth + 1;
    out->seed = in->seed;
    return true;
}

color glass_color(ray *in, const intersection *it) {
    ray r;
    double kr = reflectance(it->mat.refraction_index, 1);
    double p = kr + (1 - kr) * pow(1 - fabs(vector_dot(vector_normalized(in->dir), it->normal)), 5);
    if (ray_random(in) < p || !refracted_ray(&r, in, it)) {
        reflected_ray(&r, in, it);
    }
    return trace_ray(&r);
}

void populate_spheres(point3 center, float radius, vec3 up, int depth) {
    material mat = init_material(vector_init(1, 0, 0), vector_init(0, 0, 0), 1);
    if (!add_object(init_sphere(center.x, center.y, center.z, radius, mat)) || depth == 0) {
        return;
    }
    vec3 side = vector_cross(up, vector_init(0.3f, 0.5f, 0.8f));
    vec3 dirs[3] = {up, vector_normalized(vector_add(up, side)), vector_normalized(vector_minus(up, side))};
    for (int k = 0; k < 3; k++) {
        populate_spheres(vector_add(center, vector_float_mul(1.25f * radius, dirs[k])), radius / 4, dirs[k], depth - 1);
    }
}
