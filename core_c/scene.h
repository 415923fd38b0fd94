/* scene.h - What a scene is made of, and the glue between your functions.
 *
 * The constructors and the scenes are in scene.c, where you can read them; change nothing there:
 * your work is always judged with the original files.
 */
#ifndef SCENE_H
#define SCENE_H

#include "ray.h"

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Materials ---------------------------------------------------------------------------- */

enum { PATTERN_NONE = 0, PATTERN_CHECKER = 1, PATTERN_IMAGE = 2 };

typedef struct material_s {
    color kd;               /* diffuse colour */
    color ks;               /* specular colour */
    float shininess;        /* s of the handout's equation (1), at least 0 */
    color kr;               /* reflectance at normal incidence (Fresnel) */
    float refraction_index; /* of the inside; the outside has 1. 0: the object is opaque */
    int pattern;            /* PATTERN_NONE, PATTERN_CHECKER or PATTERN_IMAGE */
    color kd2;              /* the checkerboard's second colour */
    point3 pattern_origin;  /* a corner of the checkerboard, or the centre of the image's sphere */
    float pattern_size;     /* side of one checkerboard cube, scene units */
    float user[4];          /* yours: the given code never reads or writes it, but for zeros at the start */
} material;

/* kr = ks, opaque, without pattern. */
material init_material(color kd, color ks, float shininess);

/* ---- Objects ------------------------------------------------------------------------------ */

enum { SPHERE = 1, PLANE = 2, CYLINDER = 3, CONE = 4 };

/* The members of the union share their memory: use only those of the object's own type.
 * radius stands outside because three types have one; obj.radius is written all the same. */
typedef struct object_s {
    int type;
    float radius; /* of a sphere, a cylinder, or the disc at a cone's base; scene units */
    union {
        struct { /* SPHERE */
            point3 center;
        };
        struct { /* PLANE: the points p with p.normal + dist = 0 */
            vec3 normal;
            float dist;
        };
        struct { /* CYLINDER: from base to base + length axis, axis unit. CONE: apex at that end */
            point3 base;
            vec3 axis;
            float length;
        };
    };
    material mat;
} object;

object init_sphere(float x, float y, float z, float radius, material mat);
/* Normalises (nx, ny, nz) and leaves d as it is. */
object init_plane(float nx, float ny, float nz, float d, material mat);
/* These two normalise the axis. */
object init_cylinder(point3 base, vec3 axis, float length, float radius, material mat);
object init_cone(point3 base, vec3 axis, float length, float radius, material mat);

/* ---- Light, camera, intersection ------------------------------------------------------------ */

typedef struct light_s {
    point3 position;
    color col; /* does not fade with distance; components may exceed 1 */
} light;

typedef struct camera_s {
    point3 position;
    vec3 zdir;    /* where it looks */
    vec3 xdir;    /* towards the right of the picture (of growing i) */
    vec3 ydir;    /* towards the top of the picture (of growing j) */
    vec3 center;  /* zdir / tan(fov / 2): from the eye to the middle of the image plane */
    float fov;    /* full opening angle along xdir, degrees */
    float aspect; /* width / height */
} camera;

/* zdir = normalize(at - position), xdir = normalize(up x zdir), ydir = normalize(zdir x xdir):
 * the axes of the printed figures, where the red sphere of scene 0 (x = 1) stands on the left. */
camera init_camera(point3 position, point3 at, vec3 up, float fov, float aspect);

typedef struct intersection_s {
    vec3 normal;     /* unit */
    point3 position; /* the point hit */
    material mat;    /* a copy of the object's material */
} intersection;

/* ---- Options ------------------------------------------------------------------------------ */

typedef struct render_options_s {
    bool shading;     /* false: the colour of a hit is kd, and nothing else (figure 4) */
    bool shadows;     /* TP4.1 */
    bool reflections; /* TP4.3 */
    bool fresnel;     /* TP5.2; false: ks stands in Fresnel's place */
    bool refraction;  /* TP5.B1 */
    bool octree;      /* TP4.B1 */
    int samples;      /* per side of a pixel: 3 means 3 x 3 samples */
    int max_depth;    /* a ray whose depth exceeds it is black */
    float epsilon;    /* by which the origin of a bounced or shadow ray is moved, scene units */
} render_options;

extern render_options options; /* all true, samples 1, max_depth 10, epsilon EPSILON */

typedef struct texture_s {
    int width;
    int height;
    color *texels; /* width * height colours, row 0 at the top; NULL: no texture */
} texture;

extern texture scene_texture; /* the image of PATTERN_IMAGE */

/* ---- Building a scene ----------------------------------------------------------------------- */

/* Appends to scene[]. false, and nothing written, when the scene is full (SCENE_SIZE objects). */
bool add_object(object obj);

/* Appends to lights[]. false, and nothing written, when there are MAX_LIGHTS already. */
bool add_light(point3 position, color col);

/* true when add_object or add_light has refused something since the scene was begun. */
bool scene_is_full(void);

/* Adds a sphere and, depth times, nine spheres of a third of the radius on each of the last ones
 * (the "balls" of the Standard Procedural Databases, Haines 1987): 1 + 9 + ... + 9^depth in all.
 * direction: unit, away from the sphere's parent. */
void add_flake(point3 center, float radius, vec3 direction, int depth, const material *mat);

/* Replaces the scene, lights and camera by those of a number; false when there is no such scene. */
bool setup_scene(int number);

/* To be called after scene[], object_count or options.octree were changed by hand:
 * finds the planes again and rebuilds the octree. */
void scene_changed(void);

/* ---- The glue between your functions: the only place that switches stages -------------------- */

/* Calls the intersect_* function of the object's type. */
bool intersect_object(ray *r, intersection *it, const object *obj);

/* Nearest hit of the whole scene, by the octree (and the planes, which are not in it) where there is
 * one, by intersect_scene otherwise; then it->mat.kd is the pattern's colour. Contract as intersect_scene. */
bool nearest_hit(ray *r, intersection *it);

/* Diffuse colour of the point hit: kd, or what checker_color or texture_color says. */
color surface_color(const intersection *it);

/* Colour that the point hit sends back along the ray: kd without options.shading, otherwise
 * direct_light plus glass_color (transparent objects) or mirror_color (all others). */
color hit_color(ray *r, const intersection *it);

/* Colour of a ray that meets nothing: (0.2, 0.2, 0.6). */
color sky_color(void);

#ifdef __cplusplus
}
#endif

#endif
