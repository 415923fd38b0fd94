#include "helpers.h"

bool in_range(const ray *r, float t) {
    return r->tmin <= t && t <= r->tmax;
}
