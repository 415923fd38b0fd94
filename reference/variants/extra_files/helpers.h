/* Helpers in files of their own. */
#ifndef HELPERS_H
#define HELPERS_H

#include "exercises.h"

bool in_range(const ray *r, float t);

#endif
