/* raytracer.c - Rays, objects, light and mirrors (TP2 to TP5).
 *
 * The functions stand in the order of the exercises. exercises.h has their contracts, and how they call one another.
 */
#include "raytracer.h"

/* ============================== TP2 - Rays and objects ========================================= */

/* TP2.1 - The ray of the camera through a position of the image. */
void camera_ray(ray *r, float x, float y) {
    MRT_TODO("TP2.1");
    ray_init(r, vector_init(0.f, 0.f, 0.f), vector_init(0.f, 0.f, 1.f));
}

/* TP2.2 - The picture of the scene. */
void raytrace(void) {
    MRT_TODO("TP2.2");
}

/* TP2.3 - Intersection of a ray and a plane. */
bool intersect_plane(ray *r, intersection *it, const object *obj) {
    MRT_TODO("TP2.3");
    return false;
}

/* TP2.4 - Nearest intersection of a ray and a sphere. */
bool intersect_sphere(ray *r, intersection *it, const object *obj) {
    MRT_TODO("TP2.4");
    return false;
}

/* TP2.5 - Nearest intersection of a ray and all the objects. */
bool intersect_scene(ray *r, intersection *it) {
    MRT_TODO("TP2.5");
    return false;
}

/* TP2.6 - The colour seen along a ray. */
color trace_ray(ray *r) {
    MRT_TODO("TP2.6");
    return sky_color();
}

/* TP2.B1 - Nearest intersection of a ray and a finite cylinder with its two discs. */
bool intersect_cylinder(ray *r, intersection *it, const object *obj) {
    MRT_TODO("TP2.B1");
    return false;
}

/* TP2.B2 - Nearest intersection of a ray and a cone with its disc. */
bool intersect_cone(ray *r, intersection *it, const object *obj) {
    MRT_TODO("TP2.B2");
    return false;
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
