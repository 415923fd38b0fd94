/* raytracer.c - Rays, objects, light and mirrors (TP2 to TP5).
 *
 * The functions stand in the order of the exercises. exercises.h has their contracts, and how they call one another.
 */
#include "raytracer.h"

/* BEGIN SOLUTION TP3.1 */
static const float PI = 3.14159265f;
/* END SOLUTION */

/* ============================== TP2 - Rays and objects ========================================= */

/* TP2.1 - The ray of the camera through a position of the image. */
void camera_ray(ray *r, float x, float y) {
    /* BEGIN SOLUTION TP2.1: ray_init(r, vector_init(0.f, 0.f, 0.f), vector_init(0.f, 0.f, 1.f)); */
    const float half_width = (float)WIDTH / 2.f;
    const float half_height = (float)HEIGHT / 2.f;
    vec3 right = vector_float_mul((x - half_width) / half_width, theCamera.xdir);
    vec3 up = vector_float_mul((y - half_height) / half_height / theCamera.aspect, theCamera.ydir);
    vec3 dir = vector_add(theCamera.center, vector_add(right, up));
    ray_init(r, theCamera.position, vector_normalized(dir));
    /* END SOLUTION */
}

/* TP2.2 - The picture of the scene. */
void raytrace(void) {
    /* BEGIN SOLUTION TP2.2 */
#ifdef _OPENMP /* all the cores; rows differ in cost, so each core takes the next ones when it is done */
#pragma omp parallel for schedule(dynamic, 4)
#endif
    for (int j = 0; j < HEIGHT; j++) {
        for (int i = 0; i < WIDTH; i++) {
            if (options.samples > 1) {
                output_image[j * WIDTH + i] = pixel_color(i, j);
                continue;
            }
            ray r;
            camera_ray(&r, (float)i + 0.5f, (float)j + 0.5f);
            r.seed = pixel_seed(i, j, 0);
            output_image[j * WIDTH + i] = trace_ray(&r);
        }
    }
    /* END SOLUTION */
}

/* BEGIN SOLUTION TP2.3 */
/* Is t one that the ray looks at? (Never true of a NaN.) */
static bool in_range(const ray *r, float t) {
    return t >= r->tmin && t <= r->tmax;
}

/* Writes down a hit at t. */
static void record_hit(ray *r, intersection *it, float t, vec3 normal, const material *mat) {
    r->tmax = t;
    it->position = ray_at(*r, t);
    it->normal = normal;
    it->mat = *mat;
}
/* END SOLUTION */

/* TP2.3 - Intersection of a ray and a plane. */
bool intersect_plane(ray *r, intersection *it, const object *obj) {
    /* BEGIN SOLUTION TP2.3: return false; */
    float slope = vector_dot(r->dir, obj->normal);
    if (slope == 0.f) {
        return false; /* parallel */
    }
    float t = -(vector_dot(r->orig, obj->normal) + obj->dist) / slope;
    if (!in_range(r, t)) {
        return false;
    }
    record_hit(r, it, t, obj->normal, &obj->mat);
    return true;
    /* END SOLUTION */
}

/* BEGIN SOLUTION TP2.4 */
/* The two t at which o + t d is at a distance from the zero point (a circle's when o and d lie in a plane).
 *
 * Solves |o + t d|^2 = distance^2 around the t of the point nearest to zero: there the equation has no
 * linear term, and no digits are lost when the sphere is small and far (b^2 - 4ac would lose them).
 */
static bool solve_distance(vec3 o, vec3 d, float distance, float *first, float *second) {
    float d_d = vector_sqnorm(d);
    if (!(d_d > 0.f)) {
        return false;
    }
    float t_nearest = -vector_dot(o, d) / d_d;
    vec3 nearest = vector_add(o, vector_float_mul(t_nearest, d));
    float rest = distance * distance - vector_sqnorm(nearest);
    if (!(rest >= 0.f)) {
        return false; /* passes by */
    }
    float half_chord = sqrtf(rest / d_d);
    *first = t_nearest - half_chord;
    *second = t_nearest + half_chord;
    return true;
}
/* END SOLUTION */

/* TP2.4 - Nearest intersection of a ray and a sphere. */
bool intersect_sphere(ray *r, intersection *it, const object *obj) {
    /* BEGIN SOLUTION TP2.4: return false; */
    float t, second;
    vec3 from_center = vector_minus(r->orig, obj->center);
    if (!solve_distance(from_center, r->dir, obj->radius, &t, &second)) {
        return false;
    }
    if (t < r->tmin) {
        t = second; /* the first is behind: we are inside, or past it */
    }
    if (!in_range(r, t)) {
        return false;
    }
    vec3 outwards = vector_minus(ray_at(*r, t), obj->center);
    record_hit(r, it, t, vector_normalized(outwards), &obj->mat);
    return true;
    /* END SOLUTION */
}

/* TP2.5 - Nearest intersection of a ray and all the objects. */
bool intersect_scene(ray *r, intersection *it) {
    /* BEGIN SOLUTION TP2.5: return false; */
    bool hit = false;
    for (int k = 0; k < object_count; k++) {
        /* Each hit lowers tmax, so the last one found is the nearest. */
        if (intersect_object(r, it, &scene[k])) {
            hit = true;
        }
    }
    return hit;
    /* END SOLUTION */
}

/* TP2.6 - The colour seen along a ray. */
color trace_ray(ray *r) {
    /* BEGIN SOLUTION TP2.6: return sky_color(); */
    if (r->depth > options.max_depth) {
        return vector_init(0.f, 0.f, 0.f);
    }
    intersection it;
    if (nearest_hit(r, &it)) {
        return hit_color(r, &it);
    }
    return sky_color();
    /* END SOLUTION */
}

/* BEGIN SOLUTION TP2.B1 */
/* v without its part along a unit axis. */
static vec3 across(vec3 v, vec3 axis) {
    return vector_minus(v, vector_float_mul(vector_dot(v, axis), axis));
}

/* Hit on a disc; its normal is unit. */
static bool intersect_disc(ray *r, intersection *it, point3 center, vec3 normal, const object *obj) {
    float slope = vector_dot(r->dir, normal);
    if (slope == 0.f) {
        return false;
    }
    float t = vector_dot(vector_minus(center, r->orig), normal) / slope;
    vec3 from_center = vector_minus(ray_at(*r, t), center);
    if (!in_range(r, t) || vector_sqnorm(from_center) > obj->radius * obj->radius) {
        return false;
    }
    record_hit(r, it, t, normal, &obj->mat);
    return true;
}

/* Hit on the side of a cylinder at t, if there the height along the axis lies between the two ends. */
static bool hit_cylinder_side(ray *r, intersection *it, const object *obj, float t) {
    vec3 from_base = vector_minus(ray_at(*r, t), obj->base);
    float height = vector_dot(from_base, obj->axis);
    if (!in_range(r, t) || height < 0.f || height > obj->length) {
        return false;
    }
    record_hit(r, it, t, vector_normalized(across(from_base, obj->axis)), &obj->mat);
    return true;
}
/* END SOLUTION */

/* TP2.B1 - Nearest intersection of a ray and a finite cylinder with its two discs. */
bool intersect_cylinder(ray *r, intersection *it, const object *obj) {
    /* BEGIN SOLUTION TP2.B1: return false; */
    bool hit = false;
    float first, second;
    vec3 from_base = vector_minus(r->orig, obj->base);
    /* Seen along the axis the side is a circle. Each hit lowers tmax: the nearest remains. */
    if (solve_distance(across(from_base, obj->axis), across(r->dir, obj->axis), obj->radius, &first, &second)) {
        hit = hit_cylinder_side(r, it, obj, first) || hit_cylinder_side(r, it, obj, second);
    }
    vec3 end = vector_add(obj->base, vector_float_mul(obj->length, obj->axis));
    hit = intersect_disc(r, it, obj->base, vector_float_mul(-1.f, obj->axis), obj) || hit;
    hit = intersect_disc(r, it, end, obj->axis, obj) || hit;
    return hit;
    /* END SOLUTION */
}

/* BEGIN SOLUTION TP2.B2 */
/* Hit on the side of a cone at t, if there the depth below the apex lies between 0 and the length. */
static bool hit_cone_side(ray *r, intersection *it, const object *obj, point3 apex, float t) {
    vec3 from_apex = vector_minus(ray_at(*r, t), apex);
    float depth = -vector_dot(from_apex, obj->axis);
    if (!in_range(r, t) || depth < 0.f || depth > obj->length) {
        return false;
    }
    /* The slope of the side: radius up along the axis for length outwards. */
    vec3 outwards = vector_normalized(across(from_apex, obj->axis));
    vec3 normal = vector_add(vector_float_mul(obj->length, outwards), vector_float_mul(obj->radius, obj->axis));
    record_hit(r, it, t, vector_normalized(normal), &obj->mat);
    return true;
}

/* The two t at which the ray meets the endless double cone: a t^2 + 2 b t + c = 0, in growing order. */
static bool solve_cone(const ray *r, const object *obj, point3 apex, float *first, float *second) {
    float d_d = vector_sqnorm(r->dir);
    if (!(d_d > 0.f)) {
        return false;
    }
    /* From the ray's point nearest to the apex, where the numbers are smallest. */
    float t_nearest = vector_dot(vector_minus(apex, r->orig), r->dir) / d_d;
    vec3 o = vector_minus(ray_at(*r, t_nearest), apex);
    float tangent = obj->radius / obj->length;
    float o_axis = tangent * vector_dot(o, obj->axis);
    float d_axis = tangent * vector_dot(r->dir, obj->axis);
    vec3 o_across = across(o, obj->axis);
    vec3 d_across = across(r->dir, obj->axis);
    float a = vector_sqnorm(d_across) - d_axis * d_axis;
    float b = vector_dot(o_across, d_across) - o_axis * d_axis;
    float c = vector_sqnorm(o_across) - o_axis * o_axis;
    float discriminant = b * b - a * c;
    if (!(discriminant >= 0.f)) {
        return false;
    }
    /* q adds two numbers of the same sign; the roots are q / a and c / q. A ray along the side (a = 0) has one. */
    float q = -(b + copysignf(sqrtf(discriminant), b));
    float t1 = 0.f; /* both are, of a ray through the apex that touches the cone there (q = 0) */
    float t2 = 0.f;
    if (q != 0.f) {
        t2 = c / q;
        t1 = a != 0.f ? q / a : t2;
    }
    *first = t_nearest + (t1 < t2 ? t1 : t2);
    *second = t_nearest + (t1 < t2 ? t2 : t1);
    return true;
}
/* END SOLUTION */

/* TP2.B2 - Nearest intersection of a ray and a cone with its disc. */
bool intersect_cone(ray *r, intersection *it, const object *obj) {
    /* BEGIN SOLUTION TP2.B2: return false; */
    bool hit = false;
    float first, second;
    point3 apex = vector_add(obj->base, vector_float_mul(obj->length, obj->axis));
    if (solve_cone(r, obj, apex, &first, &second)) {
        hit = hit_cone_side(r, it, obj, apex, first) || hit_cone_side(r, it, obj, apex, second);
    }
    hit = intersect_disc(r, it, obj->base, vector_float_mul(-1.f, obj->axis), obj) || hit;
    return hit;
    /* END SOLUTION */
}

/* ============================== TP3 - Light and matter ========================================= */

/* TP3.1 - What one light sends to the eye from a point of a surface (Blinn-Phong). */
color shade(vec3 n, vec3 v, vec3 l, color light_color, const material *mat) {
    /* BEGIN SOLUTION TP3.1 */
    float n_l = vector_dot(n, l);
    if (n_l <= 0.f) {
        return vector_init(0.f, 0.f, 0.f);
    }
    vec3 h = vector_normalized(vector_add(l, v));
    float cosine = vector_dot(h, n);
    float h_n = cosine > 0.f ? cosine : 0.f;
    color specular = mat->ks;
    /* END SOLUTION */
    if (options.fresnel) {
        /* BEGIN SOLUTION TP5.2 */
        specular = fresnel_schlick(mat->kr, h, v);
        /* END SOLUTION */
    }
    /* BEGIN SOLUTION TP3.1: return vector_init(0.f, 0.f, 0.f); */
    float lobe = powf(h_n, mat->shininess) * (mat->shininess + 8.f) / (8.f * PI);
    color brdf = vector_add(vector_float_mul(1.f / PI, mat->kd), vector_float_mul(lobe, specular));
    return vector_float_mul(n_l, vector_vec_mul(light_color, brdf));
    /* END SOLUTION */
}

/* TP3.2 - What all the lights send to the eye from a point hit. */
color direct_light(const intersection *it, vec3 v) {
    /* BEGIN SOLUTION TP3.2: color sum = it->mat.kd; */
    color sum = vector_init(0.f, 0.f, 0.f);
    /* END SOLUTION */
    for (int k = 0; k < num_lights; k++) {
        /* BEGIN SOLUTION TP3.2 */
        vec3 l = vector_normalized(vector_minus(lights[k].position, it->position));
        if (vector_dot(it->normal, l) <= 0.f) {
            continue; /* behind the surface: no need to look for a shadow */
        }
        /* END SOLUTION */
        if (options.shadows && in_shadow(it, &lights[k])) {
            continue;
        }
        /* What this light adds. */
        /* BEGIN SOLUTION TP3.2 */
        sum = vector_add(sum, shade(it->normal, v, l, lights[k].col, &it->mat));
        /* END SOLUTION */
    }
    return sum;
}

/* TP3.B1 - The colour of a checkerboard in space. */
color checker_color(const material *mat, point3 p) {
    /* BEGIN SOLUTION TP3.B1: return mat->kd; */
    vec3 cube = vector_float_mul(1.f / mat->pattern_size, vector_minus(p, mat->pattern_origin));
    float sum = floorf(cube.x) + floorf(cube.y) + floorf(cube.z);
    return fmodf(fabsf(sum), 2.f) < 0.5f ? mat->kd : mat->kd2;
    /* END SOLUTION */
}

/* TP3.B2 - The colour of scene_texture wrapped on a sphere. */
color texture_color(const material *mat, point3 p) {
    /* BEGIN SOLUTION TP3.B2: return mat->kd; */
    if (scene_texture.texels == NULL) {
        return mat->kd;
    }
    vec3 d = vector_normalized(vector_minus(p, mat->pattern_origin));
    float u = 0.5f + atan2f(d.x, d.z) / (2.f * PI);
    float v = acosf(vector_clamp(d, -1.f, 1.f).y) / PI;
    int column = (int)(u * (float)scene_texture.width);
    int row = (int)(v * (float)scene_texture.height);
    if (column >= scene_texture.width) {
        column = scene_texture.width - 1; /* u = 1, the seam */
    }
    if (row >= scene_texture.height) {
        row = scene_texture.height - 1; /* v = 1, the south pole */
    }
    return scene_texture.texels[row * scene_texture.width + column];
    /* END SOLUTION */
}

/* ============================== TP4 - Shadows and mirrors ====================================== */

/* TP4.1 - Is the way from a point to a light barred? */
bool in_shadow(const intersection *it, const light *from) {
    /* BEGIN SOLUTION TP4.1: return false; */
    vec3 to_light = vector_minus(from->position, it->position);
    vec3 l = vector_normalized(to_light);
    ray r;
    ray_init(&r, vector_add(it->position, vector_float_mul(options.epsilon, l)), l);
    r.tmax = vector_norm(to_light) - options.epsilon;
    intersection unused;
    return nearest_hit(&r, &unused);
    /* END SOLUTION */
}

/* BEGIN SOLUTION TP4.2 */
/* A ray that goes on from a point hit in a unit direction. */
static void bounce(ray *out, const ray *in, const intersection *it, vec3 dir) {
    ray_init(out, vector_add(it->position, vector_float_mul(options.epsilon, dir)), dir);
    out->depth = in->depth + 1;
    out->seed = in->seed;
}
/* END SOLUTION */

/* TP4.2 - The ray that bounces off a mirror. */
void reflected_ray(ray *out, const ray *in, const intersection *it) {
    /* BEGIN SOLUTION TP4.2: *out = *in; */
    /* Made unit again each time: rounding would otherwise add up from bounce to bounce. */
    bounce(out, in, it, vector_normalized(vector_reflect(in->dir, it->normal)));
    /* END SOLUTION */
}

/* TP4.3 - What a surface adds by mirroring. */
color mirror_color(const ray *in, const intersection *it) {
    /* BEGIN SOLUTION TP4.3 */
    color k = it->mat.ks;
    /* END SOLUTION */
    if (options.fresnel) {
        /* BEGIN SOLUTION TP5.2 */
        vec3 v = vector_normalized(vector_float_mul(-1.f, in->dir));
        k = fresnel_schlick(it->mat.kr, it->normal, v);
        /* END SOLUTION */
    }
    /* BEGIN SOLUTION TP4.3: return vector_init(0.f, 0.f, 0.f); */
    ray reflected;
    reflected_ray(&reflected, in, it);
    return vector_vec_mul(k, trace_ray(&reflected));
    /* END SOLUTION */
}

/* ============================== TP5 - Fresnel and samples ====================================== */

/* TP5.1 - Share of the light that is reflected at normal incidence. */
float reflectance(float n1, float n2) {
    /* BEGIN SOLUTION TP5.1: return 0.f; */
    float ratio = (n1 - n2) / (n1 + n2);
    return ratio * ratio;
    /* END SOLUTION */
}

/* TP5.1 - Fresnel's reflection by Schlick's approximation. */
color fresnel_schlick(color kr, vec3 n, vec3 v) {
    /* BEGIN SOLUTION TP5.1: return kr; */
    float cosine = vector_dot(n, v);
    float x = 1.f - (cosine > 0.f ? cosine : 0.f);
    x = x > 0.f ? x : 0.f; /* rounding may bring the cosine above 1 */
    float x5 = x * x * x * x * x;
    return vector_init(kr.x + (1.f - kr.x) * x5, kr.y + (1.f - kr.y) * x5, kr.z + (1.f - kr.z) * x5);
    /* END SOLUTION */
}

/* TP5.3 - The mean colour of a pixel. */
color pixel_color(int i, int j) {
    /* BEGIN SOLUTION TP5.3: return vector_init(0.f, 0.f, 0.f); */
    const int side = options.samples;
    color sum = vector_init(0.f, 0.f, 0.f);
    for (int s = 0; s < side * side; s++) {
        float x = ((float)(s % side) + 0.5f) / (float)side;
        float y = ((float)(s / side) + 0.5f) / (float)side;
        ray r;
        camera_ray(&r, (float)i + x, (float)j + y);
        r.seed = pixel_seed(i, j, s);
        /* Clamped before the mean: one very bright sample must not outshine all the others. */
        sum = vector_add(sum, vector_clamp(trace_ray(&r), 0.f, 1.f));
    }
    return vector_float_mul(1.f / (float)(side * side), sum);
    /* END SOLUTION */
}

/* BEGIN SOLUTION TP5.B1 */
/* The normal on the side that the ray comes from. */
static vec3 facing_normal(const ray *in, const intersection *it) {
    bool from_inside = vector_dot(in->dir, it->normal) > 0.f;
    return from_inside ? vector_float_mul(-1.f, it->normal) : it->normal;
}
/* END SOLUTION */

/* TP5.B1 - The ray that enters or leaves a transparent object. */
bool refracted_ray(ray *out, const ray *in, const intersection *it) {
    /* BEGIN SOLUTION TP5.B1: return false; */
    bool from_inside = vector_dot(in->dir, it->normal) > 0.f;
    float ratio = from_inside ? it->mat.refraction_index : 1.f / it->mat.refraction_index;
    vec3 n = facing_normal(in, it);
    vec3 d = vector_normalized(in->dir);
    float n_l = -vector_dot(n, d);
    float cos2 = 1.f - ratio * ratio * (1.f - n_l * n_l);
    if (!(cos2 >= 0.f)) {
        return false; /* total reflection */
    }
    vec3 dir = vector_add(vector_float_mul(ratio, d), vector_float_mul(ratio * n_l - sqrtf(cos2), n));
    bounce(out, in, it, vector_normalized(dir));
    return true;
    /* END SOLUTION */
}

/* BEGIN SOLUTION TP5.B1 */
/* Probability of the reflected ray. */
static float reflection_probability(const ray *in, const intersection *it) {
    if (!options.fresnel) {
        return (it->mat.ks.x + it->mat.ks.y + it->mat.ks.z) / 3.f;
    }
    float kr = reflectance(1.f, it->mat.refraction_index);
    vec3 v = vector_normalized(vector_float_mul(-1.f, in->dir));
    return fresnel_schlick(vector_init(kr, kr, kr), facing_normal(in, it), v).x;
}
/* END SOLUTION */

/* TP5.B1 - What comes through, or off, a transparent object. */
color glass_color(ray *in, const intersection *it) {
    /* BEGIN SOLUTION TP5.B1: return vector_init(0.f, 0.f, 0.f); */
    ray out;
    bool mirrored = ray_random(in) < reflection_probability(in, it);
    if (mirrored || !refracted_ray(&out, in, it)) {
        reflected_ray(&out, in, it);
    }
    return trace_ray(&out);
    /* END SOLUTION */
}

/* BEGIN SOLUTION TP5.B2 */
/* A material by generation, counted from the tips: each has its own colour. */
static material fractal_material(int depth) {
    const color palette[6] = {{1.f, 0.9f, 0.35f},  {0.55f, 0.85f, 0.25f}, {0.1f, 0.7f, 0.6f},
                              {0.15f, 0.4f, 0.9f}, {0.95f, 0.6f, 0.1f},   {0.85f, 0.15f, 0.15f}};
    color kd = palette[depth > 0 ? depth % 6 : 0];
    material mat = init_material(kd, vector_init(0.3f, 0.3f, 0.3f), 60.f);
    mat.kr = vector_init(0.06f, 0.06f, 0.06f);
    return mat;
}

/* The k-th of three directions 50 degrees away from up, a third of a turn apart. */
static vec3 child_direction(vec3 up, int k) {
    /* Two directions across up; the first from whichever axis is far enough from it. */
    vec3 axis = fabsf(up.x) < 0.7f ? vector_init(1.f, 0.f, 0.f) : vector_init(0.f, 1.f, 0.f);
    vec3 side = vector_normalized(vector_cross(up, axis));
    vec3 other = vector_cross(side, up);
    float angle = 2.f * PI * (float)k / 3.f;
    vec3 around = vector_add(vector_float_mul(cosf(angle), side), vector_float_mul(sinf(angle), other));
    return vector_normalized(vector_add(vector_float_mul(0.64f, up), vector_float_mul(0.77f, around)));
}
/* END SOLUTION */

/* TP5.B2 - Fills the scene with spheres that carry spheres. */
void populate_spheres(point3 center, float radius, vec3 up, int depth) {
    /* BEGIN SOLUTION TP5.B2 */
    if (!add_object(init_sphere(center.x, center.y, center.z, radius, fractal_material(depth))) || depth <= 0) {
        return;
    }
    for (int k = 0; k < 3; k++) {
        vec3 dir = child_direction(up, k);
        point3 child = vector_add(center, vector_float_mul(1.25f * radius, dir));
        populate_spheres(child, radius / 4.f, dir, depth - 1);
    }
    /* END SOLUTION */
}
