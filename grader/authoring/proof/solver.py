"""A solver without an idea: it tries constants, and copies of what each function is given."""

from __future__ import annotations

from pathlib import Path

from grader.course import exercises
from grader.course.exercises import CORE, Exercise

PROTOTYPES = {
    "camera_ray": "void camera_ray(ray *r, float x, float y)",
    "raytrace": "void raytrace(void)",
    "intersect_plane": "bool intersect_plane(ray *r, intersection *it, const object *obj)",
    "intersect_sphere": "bool intersect_sphere(ray *r, intersection *it, const object *obj)",
    "intersect_cylinder": "bool intersect_cylinder(ray *r, intersection *it, const object *obj)",
    "intersect_cone": "bool intersect_cone(ray *r, intersection *it, const object *obj)",
    "intersect_scene": "bool intersect_scene(ray *r, intersection *it)",
    "trace_ray": "color trace_ray(ray *r)",
    "shade": "color shade(vec3 n, vec3 v, vec3 l, color light_color, const material *mat)",
    "direct_light": "color direct_light(const intersection *it, vec3 v)",
    "checker_color": "color checker_color(const material *mat, point3 p)",
    "texture_color": "color texture_color(const material *mat, point3 p)",
    "in_shadow": "bool in_shadow(const intersection *it, const light *from)",
    "reflected_ray": "void reflected_ray(ray *out, const ray *in, const intersection *it)",
    "mirror_color": "color mirror_color(const ray *in, const intersection *it)",
    "reflectance": "float reflectance(float n1, float n2)",
    "fresnel_schlick": "color fresnel_schlick(color kr, vec3 n, vec3 v)",
    "pixel_color": "color pixel_color(int i, int j)",
    "refracted_ray": "bool refracted_ray(ray *out, const ray *in, const intersection *it)",
    "glass_color": "color glass_color(ray *in, const intersection *it)",
    "populate_spheres": "void populate_spheres(point3 c, float radius, vec3 up, int depth)",
    "box_overlaps_object": "bool box_overlaps_object(const box *b, const object *obj)",
    "octree_build": "octree_node *octree_build(const object *objects, int count)",
    "octree_intersect": "bool octree_intersect(const octree_node *node, ray *r, intersection *it)",
    "octree_free": "void octree_free(octree_node *root)",
}

PIXELS = "for (int k = 0; k < WIDTH * HEIGHT; k++)"
COPY_HIT = """it->mat = obj->mat; it->normal = obj->type == PLANE ? obj->normal : r->dir;
    it->position = obj->type == PLANE ? r->orig : obj->center; """
BLACK, WHITE = "return vector_init(0, 0, 0);", "return vector_init(1, 1, 1);"
SKY = "return sky_color();"
ONE_NODE = """static octree_node node; for (int k = 0; k < 8; k++) node.child[k] = NULL;
    return count > 0 ? &node : NULL;"""
# What a solver may try without an idea: constants, and copies of what a function is given.
ATTEMPTS: dict[str, list[str]] = {
    "horizontal_gradient": [
        f"{PIXELS} img[k] = c1;",
        f"{PIXELS} img[k] = c2;",
        f"{PIXELS} img[k] = vector_float_mul(0.5f, vector_add(c1, c2));",
        "",
    ],
    "fill_rect": [f"{PIXELS} img[k] = c;", "", "img[0] = c;", f"{PIXELS} img[k] = p1;"],
    "fill_circle": [f"{PIXELS} img[k] = c;", "", "img[0] = c;", f"{PIXELS} img[k] = center;"],
    "camera_ray": [
        "ray_init(r, theCamera.position, theCamera.zdir);",
        "ray_init(r, theCamera.position, theCamera.center);",
        "ray_init(r, theCamera.position, vector_init(x, y, 1)); r->depth = 1;",
        "r->orig = theCamera.position;",
    ],
    "raytrace": [
        "",
        "for (int k = 0; k < WIDTH * HEIGHT; k++) output_image[k] = sky_color();",
        "for (int k = 0; k < WIDTH * HEIGHT; k++) output_image[k] = scene[0].mat.kd;",
    ],
    **{
        f"intersect_{shape}": [
            "return false;",
            "return true;",
            f"{COPY_HIT} return true;",
            f"{COPY_HIT} return false;",
            f"{COPY_HIT} r->tmax = r->tmin; return true;",
            f"{COPY_HIT} r->tmax = 1; return true;",
        ]
        for shape in ("plane", "sphere", "cylinder", "cone")
    },
    "intersect_scene": [
        "return false;",
        "return true;",
        "return object_count > 0;",
        "it->mat = scene[0].mat; it->position = scene[0].center; return object_count > 0;",
    ],
    "trace_ray": [SKY, BLACK, WHITE, "return scene[0].mat.kd;", "return r->dir;"],
    "shade": [
        BLACK,
        WHITE,
        "return mat->kd;",
        "return mat->ks;",
        "return light_color;",
        "return n;",
        "return mat->kr;",
    ],
    "direct_light": [BLACK, WHITE, "return it->mat.kd;", "return lights[0].col;", "return v;"],
    "checker_color": ["return mat->kd;", "return mat->kd2;", BLACK, WHITE, "return p;"],
    "texture_color": [
        "return mat->kd;",
        "return scene_texture.texels != NULL ? scene_texture.texels[0] : mat->kd;",
        BLACK,
        "return p;",
    ],
    "in_shadow": ["return false;", "return true;"],
    "reflected_ray": [
        "*out = *in;",
        "*out = *in; out->depth++; out->orig = it->position;",
        """ray_init(out, it->position, it->normal);
        out->depth = in->depth + 1; out->seed = in->seed;""",
        "",
    ],
    "mirror_color": [BLACK, WHITE, SKY, "return it->mat.ks;", "return it->mat.kr;"],
    "reflectance": ["return 0;", "return 1;", "return n1;", "return n2;"],
    "fresnel_schlick": [BLACK, WHITE, "return kr;", "return n;", "return v;"],
    "pixel_color": [BLACK, WHITE, SKY, "return scene[0].mat.kd;"],
    "refracted_ray": [
        "return false;",
        "return true;",
        "*out = *in; out->depth++; out->orig = it->position; return true;",
    ],
    "glass_color": [BLACK, WHITE, SKY, "return it->mat.kd;", "return scene[0].mat.kd;"],
    "populate_spheres": ["", "add_object(init_sphere(c.x, c.y, c.z, radius, scene[0].mat));"],
    "box_overlaps_object": ["return false;", "return true;"],
    "octree_build": ["return NULL;", ONE_NODE, ONE_NODE],
    "octree_intersect": ["return false;", "return true;", "it->mat = scene[0].mat; return true;"],
    "octree_free": [""],
}


TURNS = max(map(len, ATTEMPTS.values()))


def files(turn: int) -> dict[str, str]:
    """Return a submission in which each function tries one of its attempts.

    But fill_red and fill, whose answer is a constant: they are left to do.
    """
    include = '#include "raytracer.h"\n'
    text = {"raytracer.h": '#include "exercises.h"\n', "raytracer.c": include, "octree.c": include}
    text["main.c"] = (CORE / "main.c").read_text(encoding="utf-8")
    written = set()  # two exercises may be in one function
    for exercise in exercises.load().exercises:
        for name in exercise.functions:
            if name not in written and (bodies := ATTEMPTS.get(name)):
                _write(text, exercise, name, bodies[turn % len(bodies)])
                written.add(name)
    return text


def _write(text: dict[str, str], exercise: Exercise, name: str, body: str) -> None:
    """Write a function; TP1's are in the skeleton's file already."""
    if name in PROTOTYPES:
        text[exercise.file] += f"{PROTOTYPES[name]} {{ {body} }}\n"
    else:
        marker = f'MRT_TODO("{exercise.id}");'
        text[exercise.file] = text[exercise.file].replace(marker, body)


def stub(folder: Path, turn: int) -> None:
    """Write a submission in which each function tries one of its attempts."""
    for file, content in files(turn).items():
        (folder / file).write_text(content, encoding="utf-8")
