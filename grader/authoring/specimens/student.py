"""A student's TP1, written the handout's naive way; a test can replace its functions."""

from __future__ import annotations

from collections.abc import Mapping

PROTOTYPES = {
    "fill_red": "void fill_red(color *img)",
    "fill": "void fill(color *img, color c)",
    "horizontal_gradient": "void horizontal_gradient(color *img, color c1, color c2)",
    "fill_rect": "void fill_rect(color *img, color c, point3 p1, point3 p2)",
    "fill_circle": "void fill_circle(color *img, float radius, point3 center, color c)",
}

GLOBALS = """\
#include "raytracer.h"
#include "utils.h"
color output_image[WIDTH * HEIGHT];
object scene[SCENE_SIZE];
int object_count;
light lights[MAX_LIGHTS];
int num_lights;
camera theCamera;
void draw(color *img) { (void)img; }
int main(int argc, char **argv) { return mrt_main(argc, argv); }
"""

EVERY_PIXEL = "for (int j = 0; j < HEIGHT; j++) for (int i = 0; i < WIDTH; i++)"

STUDENT_MAIN = {
    "fill_red": "for (int k = 0; k < WIDTH * HEIGHT; k++) img[k] = vector_init(1, 0, 0);",
    "fill": "for (int k = 0; k < WIDTH * HEIGHT; k++) img[k] = c;",
    "horizontal_gradient": f"""{EVERY_PIXEL} {{
        float t = j / (HEIGHT - 1.f);
        img[j * WIDTH + i] =
            vector_add(vector_float_mul(t, c1), vector_float_mul(1 - t, c2)); }}""",
    "fill_rect": f"""
        int x1 = (int)fminf(p1.x, p2.x), x2 = (int)fmaxf(p1.x, p2.x);
        int y1 = (int)fminf(p1.y, p2.y), y2 = (int)fmaxf(p1.y, p2.y);
        {EVERY_PIXEL} if (i >= x1 && i <= x2 && j >= y1 && j <= y2) img[j * WIDTH + i] = c;""",
    # The listing of the handout: distances truncated to integers.
    "fill_circle": f"""{EVERY_PIXEL} {{
        int dx = i - center.x, dy = j - center.y;
        if (dx * dx + dy * dy < radius * radius) img[j * WIDTH + i] = c; }}""",
}


def main_c(bodies: Mapping[str, str]) -> str:
    """Return a main.c with these bodies; a function on a line of its own, which messages name."""
    functions = [f"{PROTOTYPES[name]} {{ {body} }}\n" for name, body in bodies.items()]
    return GLOBALS + "".join(functions)
