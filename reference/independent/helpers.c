/* A right program written from the contracts alone: many small functions. */
#include "raytracer.h"

#define BLACK vector_init(0.f, 0.f, 0.f)
#define WITHIN(r, t) ((t) >= (r)->tmin && (t) <= (r)->tmax)

static vec3 minus(vec3 v) {
    return vector_float_mul(-1.f, v);
}

static float positive(float x) {
    return fmaxf(x, 0.f);
}

static float unit_range(float n, float size) {
    return n / size * 2.f - 1.f;
}

static vec3 towards(point3 from, point3 to) {
    return vector_normalized(vector_minus(to, from));
}

static bool accept(ray *r, intersection *it, float t, const object *obj) {
    if (!WITHIN(r, t))
        return false;
    it->position = ray_at(*r, t);
    it->mat = obj->mat;
    r->tmax = t;
    return true;
}

static ray leave(const intersection *it, vec3 way) {
    ray r;
    ray_init(&r, vector_add(it->position, vector_float_mul(options.epsilon, way)), way);
    return r;
}

static ray through(int i, int j, float dx, float dy, int number) {
    ray r;
    camera_ray(&r, (float)i + dx, (float)j + dy);
    r.seed = pixel_seed(i, j, number);
    return r;
}

void camera_ray(ray *r, float x, float y) {
    vec3 across = vector_float_mul(unit_range(x, (float)WIDTH), theCamera.xdir);
    vec3 upwards = vector_float_mul(unit_range(y, (float)HEIGHT) / theCamera.aspect, theCamera.ydir);
    ray_init(r, theCamera.position, vector_normalized(vector_add(vector_add(across, upwards), theCamera.center)));
}

static color one_pixel(int i, int j) {
    if (options.samples > 1)
        return pixel_color(i, j);
    ray r = through(i, j, 0.5f, 0.5f, 0);
    return trace_ray(&r);
}

void raytrace(void) {
    for (int k = 0; k < WIDTH * HEIGHT; k++)
        output_image[k] = one_pixel(k % WIDTH, k / WIDTH);
}

bool intersect_plane(ray *r, intersection *it, const object *obj) {
    float speed = vector_dot(obj->normal, r->dir);
    float height = vector_dot(obj->normal, r->orig) + obj->dist;
    if (speed == 0.f || !accept(r, it, -height / speed, obj))
        return false;
    it->normal = obj->normal;
    return true;
}

bool intersect_sphere(ray *r, intersection *it, const object *obj) {
    float length = vector_norm(r->dir);
    if (!(length > 0.f))
        return false;
    vec3 unit = vector_float_mul(1.f / length, r->dir);
    vec3 to_center = vector_minus(obj->center, r->orig);
    float along = vector_dot(to_center, unit);
    vec3 apart = vector_minus(to_center, vector_float_mul(along, unit));
    float under = obj->radius * obj->radius - vector_sqnorm(apart);
    if (!(under >= 0.f))
        return false;
    float chord = sqrtf(under);
    bool hit = accept(r, it, (along - chord) / length, obj);
    if (!hit && (along - chord) / length < r->tmin)
        hit = accept(r, it, (along + chord) / length, obj);
    if (hit)
        it->normal = towards(obj->center, it->position);
    return hit;
}

bool intersect_scene(ray *r, intersection *it) {
    bool any = false;
    int left = object_count;
    while (left-- > 0)
        any |= intersect_object(r, it, &scene[object_count - 1 - left]);
    return any;
}

color trace_ray(ray *r) {
    intersection it;
    if (r->depth <= options.max_depth) {
        if (!nearest_hit(r, &it))
            return sky_color();
        return hit_color(r, &it);
    }
    return BLACK;
}

static vec3 brdf(const material *m, vec3 n, vec3 v, vec3 h) {
    vec3 shine = m->ks;
    if (options.fresnel)
        shine = fresnel_schlick(m->kr, h, v);
    float s = m->shininess;
    float factor = (s + 8.f) / 8.f * powf(positive(vector_dot(n, h)), s);
    return vector_float_mul((float)M_1_PI, vector_add(m->kd, vector_float_mul(factor, shine)));
}

color shade(vec3 n, vec3 v, vec3 l, color light_color, const material *mat) {
    vec3 h = vector_normalized(vector_add(v, l));
    color lit = vector_float_mul(positive(vector_dot(l, n)), light_color);
    return vector_vec_mul(lit, brdf(mat, n, v, h));
}

static bool reaches(const light *one, const intersection *it) {
    return vector_dot(vector_minus(one->position, it->position), it->normal) > 0.f && !(options.shadows && in_shadow(it, one));
}

color direct_light(const intersection *it, vec3 v) {
    color all = BLACK;
    for (int k = num_lights; k > 0; k--) {
        const light *one = &lights[k - 1];
        if (reaches(one, it))
            all = vector_add(shade(it->normal, v, towards(it->position, one->position), one->col, &it->mat), all);
    }
    return all;
}

static int cell(float x, float origin, float size) {
    return (int)floorf((x - origin) / size);
}

static bool is_odd(int n) {
    return n % 2 != 0;
}

color checker_color(const material *mat, point3 p) {
    bool odd = is_odd(cell(p.x, mat->pattern_origin.x, mat->pattern_size));
    odd = odd != is_odd(cell(p.y, mat->pattern_origin.y, mat->pattern_size));
    odd = odd != is_odd(cell(p.z, mat->pattern_origin.z, mat->pattern_size));
    return odd ? mat->kd2 : mat->kd;
}

bool in_shadow(const intersection *it, const light *from) {
    intersection nothing;
    ray r = leave(it, towards(it->position, from->position));
    r.tmax = vector_norm(vector_minus(it->position, from->position)) - options.epsilon;
    return nearest_hit(&r, &nothing);
}

void reflected_ray(ray *out, const ray *in, const intersection *it) {
    *out = leave(it, vector_normalized(vector_reflect(in->dir, it->normal)));
    out->depth = in->depth + 1;
    out->seed = in->seed;
}

static color share(const ray *in, const intersection *it) {
    return options.fresnel ? fresnel_schlick(it->mat.kr, it->normal, vector_normalized(minus(in->dir))) : it->mat.ks;
}

color mirror_color(const ray *in, const intersection *it) {
    ray r;
    reflected_ray(&r, in, it);
    return vector_vec_mul(trace_ray(&r), share(in, it));
}

static float square(float x) {
    return x * x;
}

float reflectance(float n1, float n2) {
    return square((n1 - n2) / (n1 + n2));
}

color fresnel_schlick(color kr, vec3 n, vec3 v) {
    float grazing = positive(1.f - positive(vector_dot(v, n)));
    float fifth = square(square(grazing)) * grazing;
    color white = vector_init(1.f, 1.f, 1.f);
    return vector_add(kr, vector_float_mul(fifth, vector_minus(white, kr)));
}

color pixel_color(int i, int j) {
    float step = 1.f / (float)options.samples;
    color mean = BLACK;
    for (int k = 0; k < options.samples * options.samples; k++) {
        int row = k / options.samples, column = k % options.samples;
        ray r = through(i, j, ((float)column + 0.5f) * step, ((float)row + 0.5f) * step, k);
        mean = vector_add(mean, vector_float_mul(step * step, vector_clamp(trace_ray(&r), 0.f, 1.f)));
    }
    return mean;
}
