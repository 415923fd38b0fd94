/* A binary tree of boxes (a BVH) in the octree's nodes: two children, and each object in one leaf only. */
#include "raytracer.h"

#include <stdlib.h>

enum { FEW = 4 };

static box around(const object *obj) {
    vec3 r = vector_init(obj->radius, obj->radius, obj->radius);
    point3 a = obj->type == SPHERE ? obj->center : obj->base;
    point3 b = obj->type == SPHERE ? a : vector_add(a, vector_float_mul(obj->length, obj->axis));
    box out = {vector_minus(vector_min(a, b), r), vector_add(vector_max(a, b), r)};
    return out;
}

static box both(box a, box b) {
    box out = {vector_min(a.min, b.min), vector_max(a.max, b.max)};
    return out;
}

static bool apart(float a_min, float a_max, float b_min, float b_max) {
    return a_max < b_min || b_max < a_min;
}

bool box_overlaps_object(const box *b, const object *obj) {
    if (obj->type == PLANE) {
        return false;
    }
    box o = around(obj);
    return !(apart(b->min.x, b->max.x, o.min.x, o.max.x) || apart(b->min.y, b->max.y, o.min.y, o.max.y) ||
             apart(b->min.z, b->max.z, o.min.z, o.max.z));
}

static float along(vec3 v, int axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

static int longest(vec3 v) {
    return v.x >= v.y && v.x >= v.z ? 0 : v.y >= v.z ? 1 : 2;
}

/* Puts the objects whose box has its middle below the cut first; returns how many there are. */
static int split(const object *objects, int *list, int count, int axis, float cut) {
    int low = 0;
    for (int k = 0; k < count; k++) {
        box b = around(&objects[list[k]]);
        if (along(b.min, axis) + along(b.max, axis) < 2.f * cut) {
            int swapped = list[k];
            list[k] = list[low];
            list[low++] = swapped;
        }
    }
    return low == 0 || low == count ? count / 2 : low;
}

static octree_node *build(const object *objects, int *list, int count) {
    octree_node *node = (octree_node *)calloc(1, sizeof(octree_node));
    if (node == NULL) {
        return NULL;
    }
    node->bounds = around(&objects[list[0]]);
    for (int k = 1; k < count; k++) {
        node->bounds = both(node->bounds, around(&objects[list[k]]));
    }
    if (count > FEW) {
        int axis = longest(vector_minus(node->bounds.max, node->bounds.min));
        float cut = 0.5f * (along(node->bounds.min, axis) + along(node->bounds.max, axis));
        int low = split(objects, list, count, axis, cut);
        node->child[0] = build(objects, list, low);
        node->child[1] = build(objects, list + low, count - low);
        if (node->child[0] == NULL || node->child[1] == NULL) {
            octree_free(node);
            return NULL;
        }
        return node;
    }
    node->objects = (int *)malloc((size_t)count * sizeof(int));
    if (node->objects == NULL) {
        free(node);
        return NULL;
    }
    for (int k = 0; k < count; k++) {
        node->objects[k] = list[k];
    }
    node->object_count = count;
    return node;
}

octree_node *octree_build(const object *objects, int count) {
    int *list = (int *)malloc((size_t)(count > 0 ? count : 1) * sizeof(int));
    int listed = 0;
    for (int k = 0; k < count && list != NULL; k++) {
        if (objects[k].type != PLANE) {
            list[listed++] = k;
        }
    }
    octree_node *root = listed > 0 ? build(objects, list, listed) : NULL;
    free(list);
    return root;
}

/* Does the ray cross the box, a little widened, between tmin and tmax? */
static bool crosses(const ray *r, const box *b) {
    float enter = r->tmin;
    float leave = r->tmax;
    for (int axis = 0; axis < 3; axis++) {
        float from = along(r->orig, axis);
        float way = along(r->dir, axis);
        float low = along(b->min, axis) - 1e-4f - from;
        float high = along(b->max, axis) + 1e-4f - from;
        if (way == 0.f) {
            if (low > 0.f || high < 0.f) {
                return false;
            }
            continue;
        }
        enter = fmaxf(enter, fminf(low / way, high / way));
        leave = fminf(leave, fmaxf(low / way, high / way));
    }
    return enter <= leave;
}

bool octree_intersect(const octree_node *node, ray *r, intersection *it) {
    bool hit = false;
    if (!crosses(r, &node->bounds)) {
        return false;
    }
    for (int k = 0; k < node->object_count; k++) {
        hit = intersect_object(r, it, &scene[node->objects[k]]) || hit;
    }
    for (int k = 0; k < 2; k++) {
        if (node->child[k] != NULL) {
            hit = octree_intersect(node->child[k], r, it) || hit;
        }
    }
    return hit;
}

void octree_free(octree_node *root) {
    if (root == NULL) {
        return;
    }
    octree_free(root->child[0]);
    octree_free(root->child[1]);
    free(root->objects);
    free(root);
}
