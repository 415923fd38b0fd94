/* A right program written from the contracts alone: component by component, in double. */
#include "raytracer.h"

void camera_ray(ray *r, float x, float y) {
    double u = 2.0 * x / WIDTH - 1.0, w = 2.0 * y / HEIGHT - 1.0;
    double px = u * theCamera.xdir.x, py = u * theCamera.xdir.y, pz = u * theCamera.xdir.z;
    w = w / theCamera.aspect;
    px += w * theCamera.ydir.x;
    py += w * theCamera.ydir.y;
    pz += w * theCamera.ydir.z;
    px += theCamera.center.x, py += theCamera.center.y, pz += theCamera.center.z;
    double length = sqrt(px * px + py * py + pz * pz);
    vec3 d;
    d.x = (float)(px / length);
    d.y = (float)(py / length);
    d.z = (float)(pz / length);
    ray_init(r, theCamera.position, d);
}

void raytrace(void) {
    color *out = output_image;
    for (int line = 0; line != HEIGHT; ++line)
        for (int col = 0; col != WIDTH; ++col, ++out) {
            if (options.samples == 1) {
                ray first;
                camera_ray(&first, col + 0.5f, line + 0.5f);
                first.seed = pixel_seed(col, line, 0);
                *out = trace_ray(&first);
            } else
                *out = pixel_color(col, line);
        }
}

bool intersect_plane(ray *r, intersection *it, const object *obj) {
    double below = (double)r->dir.x * obj->normal.x + (double)r->dir.y * obj->normal.y + (double)r->dir.z * obj->normal.z;
    double above = (double)r->orig.x * obj->normal.x + (double)r->orig.y * obj->normal.y + (double)r->orig.z * obj->normal.z;
    if (below != 0.0) {
        double t = -(above + obj->dist) / below;
        if (r->tmin <= t && t <= r->tmax) {
            r->tmax = (float)t;
            it->mat = obj->mat;
            it->normal = obj->normal;
            it->position.x = r->orig.x + r->tmax * r->dir.x;
            it->position.y = r->orig.y + r->tmax * r->dir.y;
            it->position.z = r->orig.z + r->tmax * r->dir.z;
            return true;
        }
    }
    return false;
}

bool intersect_sphere(ray *r, intersection *it, const object *obj) {
    double ox = (double)r->orig.x - obj->center.x, oy = (double)r->orig.y - obj->center.y, oz = (double)r->orig.z - obj->center.z;
    double dx = r->dir.x, dy = r->dir.y, dz = r->dir.z;
    double a = dx * dx + dy * dy + dz * dz;
    double b = 2.0 * (ox * dx + oy * dy + oz * dz);
    double c = ox * ox + oy * oy + oz * oz - (double)obj->radius * obj->radius;
    double delta = b * b - 4.0 * a * c;
    if (!(delta >= 0.0) || a == 0.0)
        return false;
    double roots[2] = {(-b - sqrt(delta)) / (2.0 * a), (-b + sqrt(delta)) / (2.0 * a)};
    for (int which = 0; which < 2; which++) {
        double t = roots[which];
        if (t < r->tmin)
            continue;
        if (t > r->tmax)
            break;
        r->tmax = (float)t;
        it->position = vector_init((float)(r->orig.x + t * dx), (float)(r->orig.y + t * dy), (float)(r->orig.z + t * dz));
        it->normal = vector_normalized(vector_init((float)(ox + t * dx), (float)(oy + t * dy), (float)(oz + t * dz)));
        it->mat = obj->mat;
        return true;
    }
    return false;
}

bool intersect_scene(ray *r, intersection *it) {
    int found = 0;
    for (const object *o = scene; o < scene + object_count; o++)
        found += intersect_object(r, it, o) ? 1 : 0;
    return found > 0;
}

color trace_ray(ray *r) {
    color black = {0.f, 0.f, 0.f};
    intersection where;
    if (r->depth > options.max_depth)
        return black;
    return nearest_hit(r, &where) ? hit_color(r, &where) : sky_color();
}

color shade(vec3 n, vec3 v, vec3 l, color light_color, const material *mat) {
    double nl = (double)n.x * l.x + (double)n.y * l.y + (double)n.z * l.z;
    color c = {0.f, 0.f, 0.f};
    if (nl > 0.0) {
        vec3 half = vector_normalized(vector_init(l.x + v.x, l.y + v.y, l.z + v.z));
        double nh = (double)n.x * half.x + (double)n.y * half.y + (double)n.z * half.z;
        double power = pow(nh > 0.0 ? nh : 0.0, mat->shininess) * (mat->shininess + 8.0) / (8.0 * M_PI);
        color k = options.fresnel ? fresnel_schlick(mat->kr, half, v) : mat->ks;
        c.x = (float)(nl * light_color.x * (mat->kd.x / M_PI + power * k.x));
        c.y = (float)(nl * light_color.y * (mat->kd.y / M_PI + power * k.y));
        c.z = (float)(nl * light_color.z * (mat->kd.z / M_PI + power * k.z));
    }
    return c;
}

color direct_light(const intersection *it, vec3 v) {
    double red = 0, green = 0, blue = 0;
    for (const light *lamp = lights; lamp != lights + num_lights; lamp++) {
        vec3 l = vector_normalized(vector_minus(lamp->position, it->position));
        if (vector_dot(l, it->normal) > 0.f && !(options.shadows && in_shadow(it, lamp))) {
            color c = shade(it->normal, v, l, lamp->col, &it->mat);
            red += c.x;
            green += c.y;
            blue += c.z;
        }
    }
    return vector_init((float)red, (float)green, (float)blue);
}

color checker_color(const material *mat, point3 p) {
    long a = (long)floor((p.x - mat->pattern_origin.x) / mat->pattern_size);
    long b = (long)floor((p.y - mat->pattern_origin.y) / mat->pattern_size);
    long c = (long)floor((p.z - mat->pattern_origin.z) / mat->pattern_size);
    if (((a ^ b ^ c) & 1) == 0)
        return mat->kd;
    return mat->kd2;
}

bool in_shadow(const intersection *it, const light *from) {
    double dx = from->position.x - it->position.x, dy = from->position.y - it->position.y, dz = from->position.z - it->position.z;
    double far = sqrt(dx * dx + dy * dy + dz * dz);
    vec3 way = {(float)(dx / far), (float)(dy / far), (float)(dz / far)};
    ray feeler;
    intersection obstacle;
    ray_init(&feeler, it->position, way);
    feeler.orig.x += options.epsilon * way.x;
    feeler.orig.y += options.epsilon * way.y;
    feeler.orig.z += options.epsilon * way.z;
    feeler.tmax = (float)far - options.epsilon;
    return nearest_hit(&feeler, &obstacle);
}

void reflected_ray(ray *out, const ray *in, const intersection *it) {
    double twice = 2.0 * ((double)in->dir.x * it->normal.x + (double)in->dir.y * it->normal.y + (double)in->dir.z * it->normal.z);
    vec3 d = {(float)(in->dir.x - twice * it->normal.x), (float)(in->dir.y - twice * it->normal.y), (float)(in->dir.z - twice * it->normal.z)};
    d = vector_normalized(d);
    point3 start = {it->position.x + options.epsilon * d.x, it->position.y + options.epsilon * d.y, it->position.z + options.epsilon * d.z};
    ray_init(out, start, d);
    out->seed = in->seed;
    out->depth = 1 + in->depth;
}

color mirror_color(const ray *in, const intersection *it) {
    ray next;
    reflected_ray(&next, in, it);
    color seen = trace_ray(&next), k = it->mat.ks;
    if (options.fresnel)
        k = fresnel_schlick(it->mat.kr, it->normal, vector_normalized(vector_init(-in->dir.x, -in->dir.y, -in->dir.z)));
    seen.x *= k.x;
    seen.y *= k.y;
    seen.z *= k.z;
    return seen;
}

float reflectance(float n1, float n2) {
    return (float)pow((double)(n1 - n2) / (n1 + n2), 2.0);
}

color fresnel_schlick(color kr, vec3 n, vec3 v) {
    double c = (double)n.x * v.x + (double)n.y * v.y + (double)n.z * v.z;
    if (c < 0.0)
        c = 0.0;
    if (c > 1.0)
        c = 1.0;
    double p = pow(1.0 - c, 5.0);
    color out = {(float)(kr.x + (1 - kr.x) * p), (float)(kr.y + (1 - kr.y) * p), (float)(kr.z + (1 - kr.z) * p)};
    return out;
}

color pixel_color(int i, int j) {
    int n = options.samples, number = 0;
    double red = 0, green = 0, blue = 0;
    for (int b = 0; b < n; b++)
        for (int a = 0; a < n; a++) {
            ray r;
            camera_ray(&r, (float)(i + (a + 0.5) / n), (float)(j + (b + 0.5) / n));
            r.seed = pixel_seed(i, j, number++);
            color c = trace_ray(&r);
            red += c.x < 0 ? 0 : c.x > 1 ? 1 : c.x;
            green += c.y < 0 ? 0 : c.y > 1 ? 1 : c.y;
            blue += c.z < 0 ? 0 : c.z > 1 ? 1 : c.z;
        }
    return vector_init((float)(red / number), (float)(green / number), (float)(blue / number));
}
