/* A right program written from the contracts alone: one way out of each function, in nested ifs. */
#include "raytracer.h"

void camera_ray(ray *r, float x, float y) {
    float half_w = 0.5f * WIDTH;
    float half_h = 0.5f * HEIGHT;
    vec3 d = theCamera.center;
    d = vector_add(d, vector_float_mul((x - half_w) / half_w, theCamera.xdir));
    d = vector_add(d, vector_float_mul((y - half_h) / (half_h * theCamera.aspect), theCamera.ydir));
    d = vector_normalized(d);
    ray_init(r, theCamera.position, d);
}

void raytrace(void) {
    for (int i = 0; i < WIDTH; i++) {
        for (int j = 0; j < HEIGHT; j++) {
            color result;
            if (options.samples > 1) {
                result = pixel_color(i, j);
            } else {
                ray eye;
                camera_ray(&eye, i + .5f, j + .5f);
                eye.seed = pixel_seed(i, j, 0);
                result = trace_ray(&eye);
            }
            output_image[i + j * WIDTH] = result;
        }
    }
}

bool intersect_plane(ray *r, intersection *it, const object *obj) {
    bool answer = false;
    float denominator = vector_dot(r->dir, obj->normal);
    if (denominator < 0.f || denominator > 0.f) {
        float t = vector_dot(r->orig, obj->normal);
        t = t + obj->dist;
        t = -t / denominator;
        if (t >= r->tmin) {
            if (t <= r->tmax) {
                answer = true;
                r->tmax = t;
                it->position = ray_at(*r, t);
                it->normal = obj->normal;
                it->mat = obj->mat;
            }
        }
    }
    return answer;
}

bool intersect_sphere(ray *r, intersection *it, const object *obj) {
    bool answer = false;
    vec3 co = vector_minus(r->orig, obj->center);
    double a = vector_sqnorm(r->dir);
    double half_b = (double)co.x * r->dir.x + (double)co.y * r->dir.y + (double)co.z * r->dir.z;
    double c = (double)co.x * co.x + (double)co.y * co.y + (double)co.z * co.z;
    c = c - (double)obj->radius * obj->radius;
    double reduced = half_b * half_b - a * c;
    if (reduced >= 0 && a > 0) {
        double s = sqrt(reduced);
        float t = (float)((-half_b - s) / a);
        if (t < r->tmin) {
            t = (float)((s - half_b) / a);
        }
        if (t >= r->tmin && t <= r->tmax) {
            answer = true;
            r->tmax = t;
            it->mat = obj->mat;
            it->position = ray_at(*r, t);
            it->normal = vector_minus(it->position, obj->center);
            it->normal = vector_float_mul(1.f / obj->radius, it->normal);
        }
    }
    return answer;
}

bool intersect_scene(ray *r, intersection *it) {
    bool answer = false;
    int k = 0;
    while (k < object_count) {
        bool this_one = intersect_object(r, it, scene + k);
        answer = answer || this_one;
        k = k + 1;
    }
    return answer;
}

color trace_ray(ray *r) {
    color seen = vector_init(0.f, 0.f, 0.f);
    if (!(r->depth > options.max_depth)) {
        intersection point;
        bool touched = nearest_hit(r, &point);
        if (touched) {
            seen = hit_color(r, &point);
        } else {
            seen = sky_color();
        }
    }
    return seen;
}

color shade(vec3 n, vec3 v, vec3 l, color light_color, const material *mat) {
    color total = vector_init(0.f, 0.f, 0.f);
    float cos_light = vector_dot(n, l);
    if (cos_light > 0.f) {
        color diffuse = vector_float_mul(1.f / 3.14159265f, mat->kd);
        color glossy = mat->ks;
        vec3 middle = vector_add(l, v);
        middle = vector_normalized(middle);
        float cos_middle = vector_dot(n, middle);
        if (cos_middle < 0.f) {
            cos_middle = 0.f;
        }
        if (options.fresnel) {
            glossy = fresnel_schlick(mat->kr, middle, v);
        }
        float norm = mat->shininess + 8.f;
        norm = norm / (8.f * 3.14159265f);
        glossy = vector_float_mul(norm * powf(cos_middle, mat->shininess), glossy);
        total = vector_add(diffuse, glossy);
        total = vector_vec_mul(total, light_color);
        total = vector_float_mul(cos_light, total);
    }
    return total;
}

color direct_light(const intersection *it, vec3 v) {
    color total = vector_init(0.f, 0.f, 0.f);
    for (int i = 0; i < num_lights; i++) {
        light lamp = lights[i];
        vec3 l = vector_minus(lamp.position, it->position);
        l = vector_normalized(l);
        bool dark = vector_dot(it->normal, l) <= 0.f;
        if (!dark) {
            if (options.shadows) {
                dark = in_shadow(it, &lights[i]);
            }
            if (!dark) {
                color more = shade(it->normal, v, l, lamp.col, &it->mat);
                total = vector_add(total, more);
            }
        }
    }
    return total;
}

color checker_color(const material *mat, point3 p) {
    color answer = mat->kd;
    vec3 q = vector_minus(p, mat->pattern_origin);
    int i = (int)floorf(q.x / mat->pattern_size);
    int j = (int)floorf(q.y / mat->pattern_size);
    int k = (int)floorf(q.z / mat->pattern_size);
    int parity = abs(i + j + k) % 2;
    if (parity == 1) {
        answer = mat->kd2;
    }
    return answer;
}

bool in_shadow(const intersection *it, const light *from) {
    ray test;
    intersection useless;
    vec3 d = vector_minus(from->position, it->position);
    float distance = vector_norm(d);
    d = vector_float_mul(1.f / distance, d);
    point3 start = vector_add(it->position, vector_float_mul(options.epsilon, d));
    ray_init(&test, start, d);
    test.tmax = distance - 2.f * options.epsilon;
    bool answer = nearest_hit(&test, &useless);
    return answer;
}

void reflected_ray(ray *out, const ray *in, const intersection *it) {
    vec3 r = vector_reflect(in->dir, it->normal);
    r = vector_normalized(r);
    vec3 little = vector_float_mul(options.epsilon, r);
    out->orig = vector_add(it->position, little);
    out->dir = r;
    out->tmin = 0.f;
    out->tmax = RAY_TMAX;
    out->depth = in->depth + 1;
    out->seed = in->seed;
}

color mirror_color(const ray *in, const intersection *it) {
    color factor;
    if (options.fresnel) {
        vec3 back = vector_float_mul(-1.f, in->dir);
        back = vector_normalized(back);
        factor = fresnel_schlick(it->mat.kr, it->normal, back);
    } else {
        factor = it->mat.ks;
    }
    ray bounced;
    reflected_ray(&bounced, in, it);
    color seen = trace_ray(&bounced);
    color answer = vector_vec_mul(factor, seen);
    return answer;
}

float reflectance(float n1, float n2) {
    float top = n1 - n2;
    float bottom = n1 + n2;
    return (top * top) / (bottom * bottom);
}

color fresnel_schlick(color kr, vec3 n, vec3 v) {
    color answer;
    float cosine = vector_dot(n, v);
    if (cosine < 0.f) {
        cosine = 0.f;
    } else if (cosine > 1.f) {
        cosine = 1.f;
    }
    float m = 1.f;
    for (int k = 0; k < 5; k++) {
        m = m * (1.f - cosine);
    }
    answer.x = kr.x + m * (1.f - kr.x);
    answer.y = kr.y + m * (1.f - kr.y);
    answer.z = kr.z + m * (1.f - kr.z);
    return answer;
}

color pixel_color(int i, int j) {
    color total = vector_init(0.f, 0.f, 0.f);
    int count = 0;
    float width = 1.f / options.samples;
    for (float y = width / 2.f; y < 1.f; y += width) {
        for (float x = width / 2.f; x < 1.f; x += width) {
            ray eye;
            camera_ray(&eye, i + x, j + y);
            eye.seed = pixel_seed(i, j, count);
            color seen = trace_ray(&eye);
            seen = vector_clamp(seen, 0.f, 1.f);
            total = vector_add(total, seen);
            count = count + 1;
        }
    }
    total = vector_float_mul(1.f / count, total);
    return total;
}
