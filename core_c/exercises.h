/* exercises.h - The map: every function that you write, with its contract.
 *
 * First the images of TP1 (in main.c):
 *
 *   fill_red                   TP1.1    every pixel red
 *   fill                       TP1.2    every pixel of one colour
 *   horizontal_gradient        TP1.3    from one colour to another
 *   fill_rect                  TP1.4    a rectangle
 *   fill_circle                TP1.5    a disc
 *   draw                       TP1.6    a drawing of your own
 *
 * Then the ray tracer, in the order of a ray's path (in raytracer.c; the octree in octree.c):
 *
 *   raytrace                   TP2.2    for each pixel ...
 *     pixel_color              TP5.3      (several samples for one pixel)
 *     camera_ray               TP2.1      a ray from the eye
 *     trace_ray                TP2.6      its colour:
 *       nearest_hit            given        what does it meet first?
 *         octree_intersect     TP4.B1         (the same, faster)
 *         intersect_scene      TP2.5          every object in turn:
 *           intersect_plane    TP2.3
 *           intersect_sphere   TP2.4
 *           intersect_cylinder TP2.B1
 *           intersect_cone     TP2.B2
 *         checker_color        TP3.B1         the pattern's colour there
 *         texture_color        TP3.B2
 *       hit_color              given        what colour is sent back from there?
 *         direct_light         TP3.2          the light that comes from the lights:
 *           in_shadow          TP4.1            is something in between?
 *           shade              TP3.1            Blinn-Phong
 *         mirror_color         TP4.3          the light that comes by reflection:
 *           reflected_ray      TP4.2
 *           fresnel_schlick    TP5.1            (used by shade and mirror_color: TP5.2)
 *         glass_color          TP5.B1         the light that comes through:
 *           refracted_ray      TP5.B1
 *           reflectance        TP5.1
 *   populate_spheres           TP5.B2   builds a scene
 *
 * Conventions: lengths in scene units; colours in [0, 1] but for lights, whose sum may exceed 1;
 * "unit" is a vector of norm 1. Pointers are never NULL unless it is said. No function may give a NaN
 * (a "not a number", as 0.f / 0.f) for the arguments allowed here.
 * Your functions compute, and may print with printf. Where they are judged they can start no thread and no other
 * program, open no file, reach no network, and wait for nothing: such a call fails.
 * "Check" is the command that judges the function; K= takes an exercise (K=TP2.3) or a function.
 */
#ifndef EXERCISES_H
#define EXERCISES_H

#include "globals.h"
#include "octree.h"
#include "todo.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ============================== TP1 - Images (main.c) =========================================
 * img is a table of WIDTH * HEIGHT colours: column i, row j is img[j * WIDTH + i], row 0 at the bottom.
 * Nothing outside the table may be written; what lies outside the picture is not drawn. */

/* TP1.1 - A picture all red.
 *
 *   img  every pixel becomes (1, 0, 0)
 *
 * Handout 4. Check: make grade TP=1 K=fill_red
 */
void fill_red(color *img);

/* TP1.2 - A picture all of one colour.
 *
 *   img  every pixel becomes c
 *   c    colour, copied as it is
 *
 * Handout 4. Check: make grade TP=1 K=fill_color
 */
void fill(color *img, color c);

/* TP1.3 - A gradient from c1, at the top, to c2, at the bottom.
 *
 * Each row has one colour: c1 * j / HEIGHT + c2 * (1 - j / HEIGHT) in row j.
 *
 *   img     every pixel is written
 *   c1, c2  colours
 *
 * Dividing by HEIGHT - 1, or taking the row's middle (j + 0.5) / HEIGHT, is as good.
 * Handout 4. Check: make grade TP=1 K=horizontal_gradient
 */
void horizontal_gradient(color *img, color c1, color c2);

/* TP1.4 - A filled rectangle.
 *
 * Writes c in the pixels whose column lies between (int)p1.x and (int)p2.x and whose row lies between
 * (int)p1.y and (int)p2.y, both included, whichever of the two is larger.
 *
 *   img     pixels outside the rectangle keep their colour
 *   c       colour
 *   p1, p2  two opposite corners, pixels; they may lie outside the picture; z is ignored
 *
 * Handout 4. Check: make grade TP=1 K=fill_rect
 */
void fill_rect(color *img, color c, point3 p1, point3 p2);

/* TP1.5 - A filled disc.
 *
 * Writes c in the pixels (i, j) whose distance to the centre is strictly smaller than the radius.
 *
 *   img     pixels outside the disc keep their colour
 *   radius  pixels, never negative; nothing is drawn when it is zero
 *   center  pixels; it may lie outside the picture; z is ignored
 *   c       colour
 *
 * Handout 4. Check: make grade TP=1 K=fill_circle
 */
void fill_circle(color *img, float radius, point3 center, color c);

/* TP1.6 - Your own drawing: whatever you like, with the functions above. ./mrt 4 mondessin
 *
 *   img  not cleared before the call
 *
 * Handout 4. Not judged by the machine.
 */
void draw(color *img);

/* ============================== TP2 - Rays and objects (raytracer.c) =========================== */

/* TP2.1 - The ray of the camera through a position of the image.
 *
 * Direction: theCamera.center + (x - WIDTH / 2) / (WIDTH / 2) xdir
 *            + (y - HEIGHT / 2) / (HEIGHT / 2) ydir / aspect, made unit.
 *
 *   r     written whole, as ray_init does: origin at the camera's position
 *   x, y  position, pixels from the bottom left corner; the centre of pixel (i, j) is (i + 0.5, j + 0.5)
 *
 * A direction that is not unit is accepted.
 * Handout 5.3. Check: make grade TP=2 K=camera_ray
 */
void camera_ray(ray *r, float x, float y);

/* TP2.2 - The picture of the scene.
 *
 * Writes every pixel of output_image: trace_ray of the camera's ray through the pixel's centre or,
 * when options.samples exceeds 1, pixel_color.
 *
 * Handout 5.3. Check: make grade TP=2 K=raytrace
 */
void raytrace(void);

/* TP2.3 - Intersection of a ray and a plane.
 *
 *   r    ray; dir need not be unit (t counts in units of dir); tmax becomes t on a hit, and nothing else of it changes
 *   it   filled on a hit only: position, normal (the plane's, as stored), material
 *   obj  object of type PLANE
 *
 * Returns true when the ray meets the plane at a t of [r->tmin, r->tmax]; on a miss returns false and
 * changes nothing. A ray parallel to the plane misses it.
 * Handout 5.7. Check: make grade TP=2 K=intersect_plane
 */
bool intersect_plane(ray *r, intersection *it, const object *obj);

/* TP2.4 - Nearest intersection of a ray and a sphere.
 *
 * Looks for the smallest t in [r->tmin, r->tmax] with r->orig + t * r->dir on the sphere.
 *
 *   r    ray; dir need not be unit (t counts in units of dir); tmax becomes t on a hit, and nothing else of it changes
 *   it   filled on a hit only: position, unit normal pointing outwards, material
 *   obj  object of type SPHERE; radius > 0
 *
 * Returns true on a hit; on a miss returns false and changes nothing.
 * From inside the sphere the second root counts; the normal still points outwards.
 * Handout 5.8. Check: make grade TP=2 K=intersect_sphere
 */
bool intersect_sphere(ray *r, intersection *it, const object *obj);

/* TP2.5 - Nearest intersection of a ray and all the objects, by intersect_object on each.
 *
 *   r    ray; tmax becomes the t of the nearest hit, and nothing else of it changes
 *   it   filled on a hit only, with the nearest hit
 *
 * Returns true when something was hit; false, and nothing changed, otherwise (an empty scene too).
 * Handout 5.10. Check: make grade TP=2 K=intersect_scene
 */
bool intersect_scene(ray *r, intersection *it);

/* TP2.6 - The colour seen along a ray.
 *
 *   r    ray; tmax may be lowered
 *
 * Returns black when r->depth exceeds options.max_depth; otherwise hit_color of the nearest_hit, or
 * sky_color() when the ray meets nothing.
 * Handout 5.4, 5.10, 7.2. Check: make grade TP=2 K=trace_ray
 */
color trace_ray(ray *r);

/* TP2.B1 - Nearest intersection of a ray and a finite cylinder, closed by a disc at each end.
 *
 *   r    as for the sphere
 *   it   as for the sphere; the normal points outwards: away from the axis on the side, along it on a disc
 *   obj  object of type CYLINDER; axis unit, length > 0, radius > 0
 *
 * Returns true on a hit; on a miss returns false and changes nothing.
 * Handout 9.1. Check: make grade TP=2 K=intersect_cylinder
 */
bool intersect_cylinder(ray *r, intersection *it, const object *obj);

/* TP2.B2 - Nearest intersection of a ray and a cone, closed by a disc at its base.
 *
 *   r    as for the sphere
 *   it   as for the sphere; the normal points outwards
 *   obj  object of type CONE: disc of the given radius at base, apex at base + length * axis
 *
 * Returns true on a hit; on a miss returns false and changes nothing.
 * Handout 2. Check: make grade TP=2 K=intersect_cone
 */
bool intersect_cone(ray *r, intersection *it, const object *obj);

/* ============================== TP3 - Light and matter (raytracer.c) =========================== */

/* TP3.1 - What one light sends to the eye from a point of a surface: Blinn-Phong, equation (1).
 *
 *     light_color (n.l) (kd / pi + (h.n)^s (s + 8) / (8 pi) ks),    h = (l + v) / |l + v|
 *
 *   n            unit normal
 *   v            unit, from the point to the eye
 *   l            unit, from the point to the light
 *   light_color  colour of the light
 *   mat          kd, ks, shininess; with options.fresnel, kr as well (TP5.2)
 *
 * Returns the colour; black when n.l <= 0: the light is behind the surface. h.n counts as 0 when negative.
 * TP5.2: with options.fresnel, fresnel_schlick(kr, h, v) stands in the place of ks (n for h is accepted).
 * Handout 6, 8.1. Check: make grade TP=3 K=shade
 */
color shade(vec3 n, vec3 v, vec3 l, color light_color, const material *mat);

/* TP3.2 - What all the lights send to the eye from a point hit: the sum of shade over lights[].
 *
 *   it  the point, its normal and material
 *   v   unit, from the point to the eye
 *
 * Returns the sum, not limited to 1. From TP4.1 on and with options.shadows, lights for which
 * in_shadow is true add nothing.
 * Handout 6, 7.1. Check: make grade TP=3 K=direct_light
 */
color direct_light(const intersection *it, vec3 v);

/* TP3.B1 - The colour of a checkerboard in space: cubes that are kd and kd2 in turn.
 *
 *   mat  kd, kd2; pattern_origin is a corner of a cube, pattern_size > 0 its side
 *   p    a point
 *
 * Returns kd when the numbers of the cube along x, y and z (floor((p - pattern_origin) / pattern_size)) have an
 * even sum, kd2 otherwise: the cube that starts at pattern_origin is kd, also on the negative side of it.
 * Handout 2. Check: make grade TP=3 K=checker_color
 */
color checker_color(const material *mat, point3 p);

/* TP3.B2 - The colour of scene_texture wrapped on a sphere, as a map of the world is.
 *
 * With d = p - pattern_origin made unit: u = 0.5 + atan2(d.x, d.z) / (2 pi) goes from left to right of the image
 * and v = acos(d.y) / pi from top to bottom; the texel is the one in which (u, v) falls, without blending.
 *
 *   mat  pattern_origin: the sphere's centre; kd where there is no texture (texels NULL)
 *   p    a point; any distance from the centre
 *
 * Returns the texel's colour.
 * Handout 2. Check: make grade TP=3 K=texture_color
 */
color texture_color(const material *mat, point3 p);

/* ============================== TP4 - Shadows and mirrors (raytracer.c, octree.c) ============== */

/* TP4.1 - Is the way from a point to a light barred?
 *
 *   it    the point
 *   from  the light
 *
 * Returns true when an object lies between the point, moved by options.epsilon towards the light, and the light;
 * what lies beyond the light bars nothing. False for a light that stands at the point itself.
 * Handout 7.1. Check: make grade TP=4 K=in_shadow
 */
bool in_shadow(const intersection *it, const light *from);

/* TP4.2 - The ray that bounces off a mirror.
 *
 *   out  written whole, as ray_init does: origin at it->position moved by options.epsilon along the new
 *        direction, direction in->dir reflected about it->normal and made unit, depth in->depth + 1, in's seed
 *   in   the ray that arrives; dir need not be unit
 *   it   the point hit; normal unit
 *
 * Handout 7.2. Check: make grade TP=4 K=reflected_ray
 */
void reflected_ray(ray *out, const ray *in, const intersection *it);

/* TP4.3 - What a surface adds by mirroring: k times trace_ray of the reflected ray.
 *
 *   in  the ray that arrives
 *   it  the point hit
 *
 * k is ks, or from TP5.2 on and with options.fresnel, fresnel_schlick(kr, n, v) with v from the point
 * back along the ray.
 * Handout 7.2, 8.1. Check: make grade TP=4 K=mirror_color
 */
color mirror_color(const ray *in, const intersection *it);

/* TP4.B1 - Does an object overlap a box? What puts an object into a node of the octree.
 *
 *   b    box; its faces belong to it
 *   obj  SPHERE, CYLINDER or CONE, taken as solid; a PLANE never goes into the tree
 *
 * Returns false only when nothing of the object is in the box; true for an object that is merely near it
 * is allowed (the tree is a little slower, the picture the same). False for a plane.
 * Handout 9.3. Check: make grade TP=4 K=octree
 */
bool box_overlaps_object(const box *b, const object *obj);

/* TP4.B1 - Builds the tree of an array of objects.
 *
 *   objects  the array; the tree keeps indices in it, so it must stay as it is
 *   count    how many; planes among them are left out
 *
 * Returns the root, whose box holds every object of the tree, or NULL when there is nothing to put into
 * a tree (or no memory): the plain list then serves. The tree's shape is free.
 * Handout 9.3. Check: make grade TP=4 K=octree
 */
octree_node *octree_build(const object *objects, int count);

/* TP4.B1 - Nearest intersection of a ray and the objects of the tree: those of scene[].
 *
 *   node  the root that octree_build made of scene[]
 *   r     ray; tmax becomes the t of the nearest hit, and nothing else of it changes
 *   it    filled on a hit only, with the nearest hit
 *
 * Returns true when something was hit; false, and nothing changed, otherwise. Same hit as going through the whole list.
 * Handout 9.3. Check: make grade TP=4 K=octree
 */
bool octree_intersect(const octree_node *node, ray *r, intersection *it);

/* TP4.B1 - Gives back all the memory of a tree.
 *
 *   root  what octree_build returned; NULL: nothing to do
 *
 * Called before each new scene. Handout 9.3. Not judged.
 */
void octree_free(octree_node *root);

/* ============================== TP5 - Fresnel and samples (raytracer.c) ======================== */

/* TP5.1 - Share of the light that is reflected at normal incidence: ((n1 - n2) / (n1 + n2))^2.
 *
 *   n1, n2  refraction indices on both sides, > 0
 *
 * Returns a number in [0, 1). Handout 8.1. Check: make grade TP=5 K=reflectance
 */
float reflectance(float n1, float n2);

/* TP5.1 - Fresnel's reflection by Schlick's approximation: kr + (1 - kr)(1 - n.v)^5, for each channel.
 *
 *   kr    reflectance at normal incidence, in [0, 1]
 *   n, v  unit; n.v counts as 0 when negative
 *
 * Returns kr at n.v = 1, white at n.v = 0. Handout 8.1. Check: make grade TP=5 K=fresnel_schlick
 */
color fresnel_schlick(color kr, vec3 n, vec3 v);

/* TP5.2 - Fresnel's two uses, in shade and in mirror_color: see there.
 * Check: make grade TP=5 K=fresnel_use */

/* TP5.3 - The mean colour of a pixel.
 *
 * Cuts pixel (i, j) into options.samples x options.samples equal squares, traces a ray through the middle of each,
 * clamps each colour to [0, 1], and averages. Other positions inside the squares are accepted.
 *
 *   i, j  column and row; the sample number s of a pixel gives its ray the seed pixel_seed(i, j, s)
 *
 * Returns the mean, in [0, 1]. Handout 8.2. Check: make grade TP=5 K=pixel_color
 */
color pixel_color(int i, int j);

/* TP5.B1 - The ray that enters or leaves a transparent object.
 *
 * With d the unit direction of in, n the normal on the side that d comes from, l = -d and r = n1 / n2:
 * r d + (r n.l - sqrt(1 - r^2 (1 - (n.l)^2))) n.
 *
 *   out  written as for reflected_ray, on refraction only
 *   in   the ray that arrives; it comes from inside when in->dir and it->normal point to the same side
 *   it   the point hit; mat.refraction_index > 0 is the inside's index, the outside's is 1
 *
 * Returns false, and writes nothing, when all the light is reflected (the root's argument is negative).
 * Handout 9.2. Check: make grade TP=5 K=refracted_ray
 */
bool refracted_ray(ray *out, const ray *in, const intersection *it);

/* TP5.B1 - What comes through, or off, a transparent object: one ray only, drawn at random.
 *
 *   in  the ray that arrives; ray_random(in) is called, so its seed moves on, and the bounced ray goes on with it
 *   it  the point hit; mat.refraction_index > 0
 *
 * Returns trace_ray of the reflected ray with the probability given by Fresnel (reflectance of the two indices,
 * then fresnel_schlick with the normal on the ray's side), always on total reflection; of the refracted ray otherwise.
 * Without options.fresnel the probability is the mean of ks.
 * Handout 9.2. Check: make grade TP=5 K=glass_color
 */
color glass_color(ray *in, const intersection *it);

/* TP5.B2 - Fills the scene with a sphere that carries spheres that carry spheres ...
 *
 * Adds (add_object) the sphere, then, when depth > 0, three others in the half-space above it, each in the same
 * way with depth - 1: radius / 4, centre at 5/4 of the radius from this one, "above" being the direction they stand in.
 *
 *   center, radius  of the sphere
 *   up              unit: the direction that is above
 *   depth           0: this sphere alone; n: (3^(n+1) - 1) / 2 spheres in all
 *
 * The three directions and the materials are yours. Stop when add_object returns false: the scene is full.
 * Handout 9.4. Check: make grade TP=5 K=populate_spheres
 */
void populate_spheres(point3 center, float radius, vec3 up, int depth);

#ifdef __cplusplus
}
#endif

#endif
