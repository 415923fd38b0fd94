/* hostile.h - what the hostile programs share. Each attack sets img[0].x to 1 when it could do what it should not.
 *
 * Written for the tests of the grader; never run them anywhere else.
 */
#ifndef HOSTILE_H
#define HOSTILE_H

#define _GNU_SOURCE
#include "raytracer.h"
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

/* SECRET, MARK and PARENT come from the test: a file to steal, a name to leave behind, the grader's process. */
#include "target.h"

#define ATTACK(name) void attack_##name(color *img)
#define COULD(condition) (img[0].x = (condition) ? 1.f : 0.f)

#endif
