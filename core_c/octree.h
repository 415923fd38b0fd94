/* octree.h - Boxes, and the tree of boxes that saves most intersection tests (TP4, bonus).
 *
 * A node is a box aligned with the axes. An inner node has up to eight children, which are NULL where
 * nothing is; a leaf has none, and lists the objects that overlap its box as indices in the array
 * that octree_build received. An object may stand in several leaves. Planes stand in none.
 */
#ifndef OCTREE_H
#define OCTREE_H

#include "vector.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct box_s {
    point3 min;
    point3 max;
} box;

typedef struct octree_node_s {
    box bounds;
    struct octree_node_s *child[8]; /* all NULL: a leaf */
    int *objects;                   /* object_count indices; NULL when there are none */
    int object_count;
} octree_node;

/* The octree of the scene; NULL: none, and nearest_hit goes through the plain list. */
extern octree_node *scene_octree;

#ifdef __cplusplus
}
#endif

#endif
