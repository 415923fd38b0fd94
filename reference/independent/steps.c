/* A right program written from the contracts alone: one step on each line, as the handout's formulas read. */
#include "raytracer.h"

void camera_ray(ray *r, float x, float y) {
    float imax = (float)WIDTH;
    float jmax = (float)HEIGHT;
    float alpha = (x - imax / 2.f) / (imax / 2.f);
    float beta = (y - jmax / 2.f) / (jmax / 2.f);
    vec3 a = theCamera.xdir;
    vec3 b = theCamera.ydir;
    a = vector_float_mul(alpha, a);
    b = vector_float_mul(beta, b);
    b = vector_float_mul(1.f / theCamera.aspect, b);
    vec3 sum = vector_add(a, b);
    vec3 direction = vector_add(sum, theCamera.center);
    vec3 d = vector_normalized(direction);
    ray_init(r, theCamera.position, d);
}

void raytrace(void) {
    int i;
    int j;
    for (j = 0; j <= HEIGHT - 1; j += 1) {
        for (i = 0; i <= WIDTH - 1; i += 1) {
            int index = j * WIDTH + i;
            if (options.samples >= 2) {
                color mean = pixel_color(i, j);
                output_image[index] = mean;
            }
            if (options.samples < 2) {
                float x = i + 0.5f;
                float y = j + 0.5f;
                ray r;
                camera_ray(&r, x, y);
                r.seed = pixel_seed(i, j, 0);
                color c = trace_ray(&r);
                output_image[index] = c;
            }
        }
    }
}

bool intersect_plane(ray *r, intersection *it, const object *obj) {
    vec3 o = r->orig;
    vec3 d = r->dir;
    vec3 n = obj->normal;
    float on = vector_dot(o, n);
    float dn = vector_dot(d, n);
    if (dn == 0.f) {
        return false;
    }
    float t = (on + obj->dist) / dn;
    t = -t;
    bool too_near = t < r->tmin;
    bool too_far = t > r->tmax;
    if (too_near || too_far) {
        return false;
    }
    r->tmax = t;
    point3 p = ray_at(*r, t);
    it->position = p;
    it->normal = n;
    it->mat = obj->mat;
    return true;
}

bool intersect_sphere(ray *r, intersection *it, const object *obj) {
    vec3 d = r->dir;
    vec3 o_minus_c = vector_minus(r->orig, obj->center);
    float radius = obj->radius;
    float a = vector_dot(d, d);
    float b = vector_dot(d, o_minus_c);
    b = 2.f * b;
    float c = vector_dot(o_minus_c, o_minus_c);
    c = c - radius * radius;
    float delta = b * b;
    delta = delta - 4.f * a * c;
    if (a == 0.f) {
        return false;
    }
    if (delta < 0.f) {
        return false;
    }
    float root = sqrtf(delta);
    float t1 = (-b - root) / (2.f * a);
    float t2 = (-b + root) / (2.f * a);
    float t;
    if (t1 >= r->tmin) {
        t = t1;
    } else if (t2 >= r->tmin) {
        t = t2;
    } else {
        return false;
    }
    if (t > r->tmax) {
        return false;
    }
    point3 p = ray_at(*r, t);
    vec3 n = vector_minus(p, obj->center);
    n = vector_normalized(n);
    r->tmax = t;
    it->normal = n;
    it->position = p;
    it->mat = obj->mat;
    return true;
}

bool intersect_scene(ray *r, intersection *it) {
    int number_of_hits = 0;
    for (int i = 0; i < object_count; ++i) {
        object *current = &scene[i];
        bool hit = intersect_object(r, it, current);
        if (hit == true) {
            number_of_hits = number_of_hits + 1;
        }
    }
    if (number_of_hits == 0) {
        return false;
    }
    return true;
}

color trace_ray(ray *r) {
    color c = vector_init(0.f, 0.f, 0.f);
    int depth = r->depth;
    if (depth > options.max_depth) {
        return c;
    }
    intersection it;
    bool hit = nearest_hit(r, &it);
    if (hit == false) {
        c = sky_color();
        return c;
    }
    c = hit_color(r, &it);
    return c;
}

color shade(vec3 n, vec3 v, vec3 l, color light_color, const material *mat) {
    float pi = 3.14159265f;
    float s = mat->shininess;
    vec3 h = vector_normalized(vector_add(l, v));
    float n_l = vector_dot(n, l);
    if (n_l < 0.f) {
        n_l = 0.f;
    }
    float h_n = vector_dot(h, n);
    if (h_n < 0.f) {
        h_n = 0.f;
    }
    color kd = mat->kd;
    color ks = mat->ks;
    if (options.fresnel) {
        color f = fresnel_schlick(mat->kr, h, v);
        ks = f;
    }
    color first = vector_float_mul(1.f / pi, kd);
    float coefficient = (s + 8.f) / (8.f * pi);
    coefficient = coefficient * powf(h_n, s);
    color second = vector_float_mul(coefficient, ks);
    color both = vector_add(first, second);
    color result = vector_vec_mul(both, light_color);
    result = vector_float_mul(n_l, result);
    return result;
}

color direct_light(const intersection *it, vec3 v) {
    color result = vector_init(0.f, 0.f, 0.f);
    int i;
    for (i = 0; i < num_lights; i++) {
        point3 p = lights[i].position;
        vec3 l = vector_normalized(vector_minus(p, it->position));
        float cosine = vector_dot(l, it->normal);
        bool shadow = cosine <= 0.f;
        if (shadow == false && options.shadows == true) {
            shadow = in_shadow(it, &lights[i]);
        }
        if (shadow == false) {
            color c = lights[i].col;
            color s = shade(it->normal, v, l, c, &it->mat);
            result = vector_add(result, s);
        }
    }
    return result;
}

color checker_color(const material *mat, point3 p) {
    float size = mat->pattern_size;
    float x = (p.x - mat->pattern_origin.x) / size;
    float y = (p.y - mat->pattern_origin.y) / size;
    float z = (p.z - mat->pattern_origin.z) / size;
    x = floorf(x);
    y = floorf(y);
    z = floorf(z);
    float total = x + y + z;
    float half = total / 2.f;
    if (half == floorf(half)) {
        return mat->kd;
    } else {
        return mat->kd2;
    }
}

bool in_shadow(const intersection *it, const light *from) {
    point3 a = it->position;
    point3 b = from->position;
    vec3 ab = vector_minus(b, a);
    float length = vector_norm(ab);
    vec3 l = vector_normalized(ab);
    float e = options.epsilon;
    vec3 step = vector_float_mul(e, l);
    point3 o = vector_add(a, step);
    ray s;
    ray_init(&s, o, l);
    s.tmax = length - e;
    intersection other;
    bool hit = nearest_hit(&s, &other);
    if (hit == true) {
        return true;
    }
    return false;
}

void reflected_ray(ray *out, const ray *in, const intersection *it) {
    vec3 d = in->dir;
    vec3 n = it->normal;
    float d_n = vector_dot(d, n);
    vec3 correction = vector_float_mul(2.f * d_n, n);
    vec3 r = vector_minus(d, correction);
    r = vector_normalized(r);
    float e = options.epsilon;
    vec3 step = vector_float_mul(e, r);
    point3 o = vector_add(it->position, step);
    ray_init(out, o, r);
    int depth = in->depth;
    depth = depth + 1;
    out->depth = depth;
    out->seed = in->seed;
}

color mirror_color(const ray *in, const intersection *it) {
    color k = it->mat.ks;
    if (options.fresnel == true) {
        vec3 d = vector_normalized(in->dir);
        vec3 v = vector_init(-d.x, -d.y, -d.z);
        k = fresnel_schlick(it->mat.kr, it->normal, v);
    }
    ray r;
    reflected_ray(&r, in, it);
    color c = trace_ray(&r);
    c = vector_vec_mul(c, k);
    return c;
}

float reflectance(float n1, float n2) {
    float difference = n1 - n2;
    float sum = n1 + n2;
    float quotient = difference / sum;
    float result = quotient * quotient;
    return result;
}

color fresnel_schlick(color kr, vec3 n, vec3 v) {
    float c = vector_dot(n, v);
    if (c < 0.f) {
        c = 0.f;
    }
    float one_minus_c = 1.f - c;
    if (one_minus_c < 0.f) {
        one_minus_c = 0.f;
    }
    float power = powf(one_minus_c, 5.f);
    color ones = vector_init(1.f, 1.f, 1.f);
    color rest = vector_minus(ones, kr);
    rest = vector_float_mul(power, rest);
    color result = vector_add(kr, rest);
    return result;
}

color pixel_color(int i, int j) {
    int n = options.samples;
    int sample = 0;
    color sum = vector_init(0.f, 0.f, 0.f);
    for (int q = 0; q < n; q++) {
        float y = (float)q + 0.5f;
        y = y / (float)n;
        y = y + (float)j;
        for (int p = 0; p < n; p++) {
            float x = (float)p + 0.5f;
            x = x / (float)n;
            x = x + (float)i;
            ray r;
            camera_ray(&r, x, y);
            r.seed = pixel_seed(i, j, sample);
            sample++;
            color c = trace_ray(&r);
            c = vector_clamp(c, 0.f, 1.f);
            sum = vector_add(sum, c);
        }
    }
    float number = (float)(n * n);
    sum = vector_float_mul(1.f / number, sum);
    return sum;
}
