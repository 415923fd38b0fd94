/* octree.c - The tree of boxes that saves most intersection tests (TP4, bonus).
 *
 * The contracts are in exercises.h, the types in octree.h.
 */
#include "raytracer.h"

/* BEGIN SOLUTION TP4.B1 */
#include <stdlib.h>

/* Cutting a box stops here. More objects in a leaf: more tests; fewer: more boxes to cross, and more memory. */
enum { LEAF_OBJECTS = 10 };

/* Cutting a box pays when the lists of the eight parts together are at most this many times as long as its own. */
enum { WORTH_CUTTING = 3 };

/* A box is never cut more often than this, however many objects meet in one point. */
enum { DEPTH_LIMIT = 16 };

/* By how much a box is widened when objects are chosen for it, as a share of the root's longest side: more than the
 * rounding of a ray's position, so that no ray slips between two boxes. */
static const float MARGIN = 1e-5f;

/* Memory for nodes and lists, taken in large blocks: neighbours in the tree are neighbours in memory, and the
 * whole tree is given back at once. */
static const size_t BLOCK_BYTES = 1 << 16;

typedef struct block_s {
    struct block_s *next;
    size_t used;
    size_t size; /* of the bytes that follow the block's own */
} block;

/* What octree_build makes. The root comes first: its address is the tree's. */
typedef struct tree_s {
    octree_node root;
    block *blocks;
    const object *objects;
    float margin;
    bool out_of_memory;
} tree;

/* size bytes out of the tree's blocks; NULL when there is no memory. */
static void *take(tree *t, size_t size) {
    size = (size + 7) / 8 * 8; /* so that whatever comes next is aligned */
    if (t->blocks == NULL || t->blocks->used + size > t->blocks->size) {
        size_t room = size > BLOCK_BYTES ? size : BLOCK_BYTES;
        block *fresh = (block *)malloc(sizeof(block) + room);
        if (fresh == NULL) {
            t->out_of_memory = true;
            return NULL;
        }
        fresh->next = t->blocks;
        fresh->used = 0;
        fresh->size = room;
        t->blocks = fresh;
    }
    void *memory = (char *)(t->blocks + 1) + t->blocks->used;
    t->blocks->used += size;
    return memory;
}

/* ---- Boxes ------------------------------------------------------------------------------------ */

static vec3 vector_of(float f) {
    return vector_init(f, f, f);
}

static point3 middle(const box *b) {
    return vector_float_mul(0.5f, vector_add(b->min, b->max));
}

static box grown(const box *b, float by) {
    box out;
    out.min = vector_minus(b->min, vector_of(by));
    out.max = vector_add(b->max, vector_of(by));
    return out;
}

/* Box around two others. */
static box both(box a, box b) {
    a.min = vector_min(a.min, b.min);
    a.max = vector_max(a.max, b.max);
    return a;
}

/* Box around a disc: along x it extends by radius sqrt(1 - axis.x^2), and so on. */
static box box_of_disc(point3 center, vec3 axis, float radius) {
    vec3 extent = vector_minus(vector_of(1.f), vector_vec_mul(axis, axis));
    extent = vector_max(extent, vector_of(0.f));
    extent = vector_float_mul(radius, vector_init(sqrtf(extent.x), sqrtf(extent.y), sqrtf(extent.z)));
    box b;
    b.min = vector_minus(center, extent);
    b.max = vector_add(center, extent);
    return b;
}

/* Box around an object that is not a plane. */
static box box_of_object(const object *obj) {
    if (obj->type == SPHERE) {
        box point = {obj->center, obj->center};
        return grown(&point, obj->radius);
    }
    point3 end = vector_add(obj->base, vector_float_mul(obj->length, obj->axis));
    box ends = box_of_disc(obj->base, obj->axis, obj->radius);
    return both(ends, box_of_disc(end, obj->axis, obj->type == CONE ? 0.f : obj->radius));
}

static bool boxes_overlap(const box *a, const box *b) {
    return a->min.x <= b->max.x && b->min.x <= a->max.x && a->min.y <= b->max.y && b->min.y <= a->max.y &&
           a->min.z <= b->max.z && b->min.z <= a->max.z;
}

/* The k-th of the eight boxes that a box is cut into: bits 0, 1, 2 of k choose the upper half along x, y, z. */
static box eighth(const box *b, int k) {
    point3 m = middle(b);
    box out = *b;
    if ((k & 1) != 0) {
        out.min.x = m.x;
    } else {
        out.max.x = m.x;
    }
    if ((k & 2) != 0) {
        out.min.y = m.y;
    } else {
        out.max.y = m.y;
    }
    if ((k & 4) != 0) {
        out.min.z = m.z;
    } else {
        out.max.z = m.z;
    }
    return out;
}
/* END SOLUTION */

/* TP4.B1 - Does an object overlap a box? */
bool box_overlaps_object(const box *b, const object *obj) {
    /* BEGIN SOLUTION TP4.B1: return false; */
    if (obj->type == PLANE) {
        return false;
    }
    if (obj->type == SPHERE) {
        point3 nearest = vector_min(vector_max(obj->center, b->min), b->max);
        return vector_sqnorm(vector_minus(nearest, obj->center)) <= obj->radius * obj->radius;
    }
    box around = box_of_object(obj);
    return boxes_overlap(b, &around);
    /* END SOLUTION */
}

/* BEGIN SOLUTION TP4.B1 */
/* ---- Building --------------------------------------------------------------------------------- */

static void start_node(octree_node *node, box bounds) {
    node->bounds = bounds;
    for (int k = 0; k < 8; k++) {
        node->child[k] = NULL;
    }
    node->objects = NULL;
    node->object_count = 0;
}

static void fill_leaf(tree *t, octree_node *leaf, const int *list, int count) {
    leaf->objects = (int *)take(t, (size_t)count * sizeof(int));
    if (leaf->objects == NULL) {
        return;
    }
    for (int k = 0; k < count; k++) {
        leaf->objects[k] = list[k];
    }
    leaf->object_count = count;
}

/* Copies from list those that overlap a box; returns how many. */
static int select_overlapping(const tree *t, const box *bounds, const int *list, int count, int *selected) {
    box wide = grown(bounds, t->margin);
    int n = 0;
    for (int k = 0; k < count; k++) {
        if (box_overlaps_object(&wide, &t->objects[list[k]])) {
            selected[n++] = list[k];
        }
    }
    return n;
}

/* Puts the objects of a list into a node: cuts it into eight as long as there are too many for a leaf, and cutting
 * helps: when objects overlap so much that the eight lists together are far longer, it would only cost memory. */
static void subdivide(tree *t, octree_node *node, const int *list, int count, int cuts_left) {
    int *selected = count > LEAF_OBJECTS && cuts_left > 0 ? (int *)malloc(8 * (size_t)count * sizeof(int)) : NULL;
    int chosen[8];
    int total = 0;
    for (int k = 0; k < 8 && selected != NULL; k++) {
        box bounds = eighth(&node->bounds, k);
        chosen[k] = select_overlapping(t, &bounds, list, count, selected + (size_t)k * (size_t)count);
        total += chosen[k];
    }
    if (selected == NULL || total > WORTH_CUTTING * count) {
        fill_leaf(t, node, list, count);
        free(selected);
        return;
    }
    for (int k = 0; k < 8 && !t->out_of_memory; k++) {
        octree_node *child = chosen[k] > 0 ? (octree_node *)take(t, sizeof(octree_node)) : NULL;
        if (child != NULL) {
            start_node(child, eighth(&node->bounds, k));
            node->child[k] = child;
            subdivide(t, child, selected + (size_t)k * (size_t)count, chosen[k], cuts_left - 1);
        }
    }
    free(selected);
}

/* Lists the objects that are not planes, and the box around them; returns how many. */
static int list_objects(const object *objects, int count, int *list, box *bounds) {
    int n = 0;
    for (int k = 0; k < count; k++) {
        if (objects[k].type != PLANE) {
            box around = box_of_object(&objects[k]);
            *bounds = n == 0 ? around : both(*bounds, around);
            list[n++] = k;
        }
    }
    return n;
}

/* How often the root may be cut: enough for one object in a leaf if they were spread over a surface, and two more. */
static int cuts_for(int count) {
    int cuts = 2;
    for (long room = 1; room < count && cuts < DEPTH_LIMIT; room *= 4) {
        cuts++;
    }
    return cuts;
}
/* END SOLUTION */

/* TP4.B1 - Builds the tree of an array of objects. */
octree_node *octree_build(const object *objects, int count) {
    /* BEGIN SOLUTION TP4.B1: return NULL; */
    tree *t = (tree *)malloc(sizeof(tree));
    int *list = (int *)malloc((size_t)(count > 0 ? count : 1) * sizeof(int));
    box bounds = {vector_of(0.f), vector_of(0.f)};
    int listed = t != NULL && list != NULL ? list_objects(objects, count, list, &bounds) : 0;
    if (listed == 0) {
        free(t);
        free(list);
        return NULL;
    }
    vec3 sides = vector_minus(bounds.max, bounds.min);
    t->blocks = NULL;
    t->objects = objects;
    t->margin = MARGIN * fmaxf(sides.x, fmaxf(sides.y, sides.z));
    t->out_of_memory = false;
    start_node(&t->root, grown(&bounds, t->margin));
    subdivide(t, &t->root, list, listed, cuts_for(listed));
    free(list);
    if (t->out_of_memory) {
        octree_free(&t->root);
        return NULL;
    }
    return &t->root;
    /* END SOLUTION */
}

/* BEGIN SOLUTION TP4.B1 */
/* ---- Walking a ray through the tree ------------------------------------------------------------ */

/* What stays the same from node to node. */
typedef struct walk_s {
    ray *r;
    intersection *it;
    vec3 inverse;  /* 1 / dir */
    int backwards; /* bit 0: the ray goes down along x; bit 1: y; bit 2: z */
} walk;

/* The objects of a leaf. A hit lowers the ray's tmax; one that lies beyond this leaf's box ends nothing: the walk goes
 * on through the boxes before it, where something nearer may be. */
static bool hit_leaf(const walk *w, const octree_node *leaf) {
    bool hit = false;
    for (int k = 0; k < leaf->object_count; k++) {
        hit = intersect_object(w->r, w->it, &scene[leaf->objects[k]]) || hit;
    }
    return hit;
}

/* Walks through a node that the ray crosses from t = enter to t = leave, in the order in which the ray meets the children.
 *
 * The ray leaves one child for the next where it crosses one of the three planes that cut the node: at most four
 * children are met. A plane that has been crossed is put at infinity. Comparisons are written so that the NaN of
 * a ray that runs in such a plane (0 times infinity) counts as never crossed.
 */
static bool walk_node(const walk *w, const octree_node *node, float enter, float leave) {
    if (node->objects != NULL) { /* a leaf */
        return hit_leaf(w, node);
    }
    vec3 t = vector_vec_mul(vector_minus(middle(&node->bounds), w->r->orig), w->inverse);
    float crossing[3] = {t.x, t.y, t.z};
    int crossed = 0;
    for (int axis = 0; axis < 3; axis++) {
        if (crossing[axis] <= enter) {
            crossed |= 1 << axis;
            crossing[axis] = INFINITY;
        }
    }
    bool hit = false;
    while (enter <= w->r->tmax) {
        int next = -1;
        float until = leave;
        for (int axis = 0; axis < 3; axis++) {
            if (crossing[axis] < until) {
                next = axis;
                until = crossing[axis];
            }
        }
        /* Going up, the upper half comes after the plane; going down, before. */
        const octree_node *child = node->child[crossed ^ w->backwards];
        if (child != NULL) {
            hit = walk_node(w, child, enter, until) || hit;
        }
        if (next < 0) {
            break;
        }
        crossed |= 1 << next;
        crossing[next] = INFINITY;
        enter = until;
    }
    return hit;
}

static float larger(float a, float b) {
    return a > b ? a : b;
}

static float smaller(float a, float b) {
    return a < b ? a : b;
}
/* END SOLUTION */

/* TP4.B1 - Nearest intersection of a ray and the objects of the tree. */
bool octree_intersect(const octree_node *node, ray *r, intersection *it) {
    /* BEGIN SOLUTION TP4.B1: return false; */
    walk w;
    w.r = r;
    w.it = it;
    w.inverse = vector_init(1.f / r->dir.x, 1.f / r->dir.y, 1.f / r->dir.z);
    /* The sign of 1 / dir, so that -0 goes down as its -infinity does. */
    w.backwards = (w.inverse.x < 0.f ? 1 : 0) | (w.inverse.y < 0.f ? 2 : 0) | (w.inverse.z < 0.f ? 4 : 0);
    /* Where the ray is inside the root. A NaN, of a ray along a face, means a miss: the root is wider than its objects. */
    vec3 t1 = vector_vec_mul(vector_minus(node->bounds.min, r->orig), w.inverse);
    vec3 t2 = vector_vec_mul(vector_minus(node->bounds.max, r->orig), w.inverse);
    vec3 in = vector_min(t1, t2);
    vec3 out = vector_max(t1, t2);
    float enter = larger(r->tmin, larger(in.x, larger(in.y, in.z)));
    float leave = smaller(r->tmax, smaller(out.x, smaller(out.y, out.z)));
    return enter <= leave && walk_node(&w, node, enter, leave);
    /* END SOLUTION */
}

/* TP4.B1 - Gives back all the memory of a tree. */
void octree_free(octree_node *root) {
    /* BEGIN SOLUTION TP4.B1 */
    if (root == NULL) {
        return;
    }
    tree *t = (tree *)root;
    while (t->blocks != NULL) {
        block *first = t->blocks;
        t->blocks = first->next;
        free(first);
    }
    free(t);
    /* END SOLUTION */
}
