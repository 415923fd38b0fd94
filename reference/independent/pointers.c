/* A right program written from the contracts alone: structures filled through pointers, early exits. */
#include "raytracer.h"

typedef struct {
    float lo, hi;
    int count;
} roots;

static roots quadratic(float a, float b, float c) {
    roots found = {0.f, 0.f, 0};
    double disc = (double)b * b - 4. * (double)a * c;
    if (a == 0.f || !(disc >= 0.))
        return found;
    double q = b < 0.f ? (-b + sqrt(disc)) / 2. : (-b - sqrt(disc)) / 2.;
    double first = q / a, second = q != 0. ? c / q : first;
    found.count = 2;
    found.lo = (float)fmin(first, second);
    found.hi = (float)fmax(first, second);
    return found;
}

void camera_ray(ray *r, float x, float y) {
    const camera *cam = &theCamera;
    vec3 terms[3];
    terms[0] = cam->center;
    terms[1] = vector_float_mul(x / (WIDTH / 2.f) - 1.f, cam->xdir);
    terms[2] = vector_float_mul((y / (HEIGHT / 2.f) - 1.f) / cam->aspect, cam->ydir);
    vec3 total = terms[0];
    for (int k = 1; k < 3; k++)
        total = vector_add(total, terms[k]);
    ray_init(r, cam->position, vector_normalized(total));
}

void raytrace(void) {
    int row = HEIGHT;
    while (row-- > 0) {
        color *pixels = &output_image[row * WIDTH];
        for (int col = 0; col < WIDTH; col++) {
            ray r;
            if (options.samples > 1) {
                pixels[col] = pixel_color(col, row);
                continue;
            }
            camera_ray(&r, .5f + (float)col, .5f + (float)row);
            r.seed = pixel_seed(col, row, 0);
            pixels[col] = trace_ray(&r);
        }
    }
}

static void fill_hit(intersection *it, const ray *r, const material *m, const vec3 *normal) {
    it->mat = *m;
    it->position = ray_at(*r, r->tmax);
    if (normal)
        it->normal = *normal;
}

bool intersect_plane(ray *r, intersection *it, const object *obj) {
    const vec3 *n = &obj->normal;
    float nd = vector_dot(*n, r->dir);
    if (nd == 0.f)
        return false;
    float no = vector_dot(*n, r->orig), t = (-obj->dist - no) / nd;
    if (t < r->tmin || t > r->tmax || t != t)
        return false;
    r->tmax = t;
    fill_hit(it, r, &obj->mat, n);
    return true;
}

bool intersect_sphere(ray *r, intersection *it, const object *obj) {
    vec3 oc = vector_minus(r->orig, obj->center);
    roots t = quadratic(vector_sqnorm(r->dir), 2.f * vector_dot(oc, r->dir), vector_sqnorm(oc) - obj->radius * obj->radius);
    if (t.count == 0 || t.hi < r->tmin || t.lo > r->tmax)
        return false;
    if (t.lo >= r->tmin)
        r->tmax = t.lo;
    else if (t.hi <= r->tmax)
        r->tmax = t.hi;
    else
        return false;
    fill_hit(it, r, &obj->mat, NULL);
    vec3 spoke = vector_minus(it->position, obj->center);
    it->normal = vector_normalized(spoke);
    return true;
}

bool intersect_scene(ray *r, intersection *it) {
    const object *end = &scene[object_count], *nearest = NULL;
    for (const object *o = &scene[0]; o != end; ++o)
        if (intersect_object(r, it, o))
            nearest = o;
    return nearest != NULL;
}

color trace_ray(ray *r) {
    intersection found;
    if (r->depth > options.max_depth)
        return (color){0.f, 0.f, 0.f};
    if (!nearest_hit(r, &found))
        return sky_color();
    return hit_color(r, &found);
}

static const float INV_PI = 0.318309886f;

color shade(vec3 n, vec3 v, vec3 l, color light_color, const material *mat) {
    float facing = vector_dot(l, n);
    if (!(facing > 0.f))
        return (color){0.f, 0.f, 0.f};
    vec3 h = vector_normalized(vector_add(v, l));
    const color f = options.fresnel ? fresnel_schlick(mat->kr, h, v) : mat->ks;
    float lobe = INV_PI / 8.f * (8.f + mat->shininess) * powf(fmaxf(0.f, vector_dot(h, n)), mat->shininess);
    color out = vector_float_mul(INV_PI, mat->kd);
    out.x += lobe * f.x;
    out.y += lobe * f.y;
    out.z += lobe * f.z;
    return vector_vec_mul(out, vector_float_mul(facing, light_color));
}

color direct_light(const intersection *it, vec3 v) {
    color sum = {0.f, 0.f, 0.f};
    const light *lamp = lights;
    for (int rest = num_lights; rest; rest--, lamp++) {
        vec3 to = vector_minus(lamp->position, it->position);
        if (vector_dot(to, it->normal) <= 0.f)
            continue;
        if (options.shadows)
            if (in_shadow(it, lamp))
                continue;
        color part = shade(it->normal, v, vector_normalized(to), lamp->col, &it->mat);
        sum.x += part.x, sum.y += part.y, sum.z += part.z;
    }
    return sum;
}

color checker_color(const material *mat, point3 p) {
    const float at[3] = {p.x - mat->pattern_origin.x, p.y - mat->pattern_origin.y, p.z - mat->pattern_origin.z};
    int swaps = 0;
    for (int axis = 0; axis < 3; axis++) {
        float turns = floorf(at[axis] / mat->pattern_size) / 2.f;
        swaps += turns != floorf(turns);
    }
    const color *both[2] = {&mat->kd, &mat->kd2};
    return *both[swaps % 2];
}

bool in_shadow(const intersection *it, const light *from) {
    ray probe;
    intersection dummy;
    vec3 path = vector_minus(from->position, it->position);
    ray_init(&probe, it->position, vector_normalized(path));
    probe.tmin = options.epsilon;
    probe.tmax = sqrtf(vector_dot(path, path)) - options.epsilon;
    return nearest_hit(&probe, &dummy);
}

void reflected_ray(ray *out, const ray *in, const intersection *it) {
    const vec3 *n = &it->normal;
    float k = -2.f * vector_dot(in->dir, *n);
    vec3 way = vector_normalized(vector_add(in->dir, vector_float_mul(k, *n)));
    ray_init(out, vector_add(it->position, vector_float_mul(options.epsilon, way)), way);
    out->depth += in->depth + 1;
    out->seed = in->seed;
}

color mirror_color(const ray *in, const intersection *it) {
    ray mirrored;
    color k = it->mat.ks;
    reflected_ray(&mirrored, in, it);
    if (options.fresnel) {
        float l = vector_norm(in->dir);
        k = fresnel_schlick(it->mat.kr, it->normal, vector_float_mul(-1.f / l, in->dir));
    }
    const color seen = trace_ray(&mirrored);
    return (color){k.x * seen.x, k.y * seen.y, k.z * seen.z};
}

float reflectance(float n1, float n2) {
    float f = (n2 - n1) / (n2 + n1);
    return f * f;
}

color fresnel_schlick(color kr, vec3 n, vec3 v) {
    float m = 1.f - fminf(fmaxf(vector_dot(n, v), 0.f), 1.f), m2 = m * m;
    m = m2 * m2 * m;
    float *channels[3] = {&kr.x, &kr.y, &kr.z};
    for (int k = 0; k < 3; k++)
        *channels[k] += (1.f - *channels[k]) * m;
    return kr;
}

color pixel_color(int i, int j) {
    color sum = {0.f, 0.f, 0.f};
    const int n = options.samples;
    for (int a = 0; a < n; a++) {
        for (int b = 0; b < n; b++) {
            ray r;
            camera_ray(&r, i + (2 * a + 1) / (2.f * n), j + (2 * b + 1) / (2.f * n));
            r.seed = pixel_seed(i, j, a * n + b);
            color c = vector_clamp(trace_ray(&r), 0.f, 1.f);
            sum.x += c.x, sum.y += c.y, sum.z += c.z;
        }
    }
    const float share = 1.f / (float)(n * n);
    return vector_float_mul(share, sum);
}
