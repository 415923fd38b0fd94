/* acts.c - part of the shim: threads, processes, files and the network, which isolation refuses, are noted.
 *
 * Each function here stands before the C library's, calls it, and notes whether it worked, and from where it was
 * called. They are hidden from other libraries, and weak: a submission's own function of that name is its own.
 */
#include <fcntl.h>
#include <pthread.h>
#include <spawn.h>
#include <stdarg.h>
#include <stdbool.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* The same order as in worker/frames.py. */
enum { MRT_THREAD = 1, MRT_PROCESS, MRT_FILE, MRT_NETWORK };

#define MRT_ACT __attribute__((weak, visibility("hidden"), noinline))
#define MRT_NOTED(kind, worked) note_act(kind, worked, __builtin_return_address(0))
/* The C library's function, or a sanitizer's, as the loader would have found it. */
#define MRT_REAL(name) (*(__typeof__(&name) *)real_one(#name))

static void **real_one(const char *name) {
    static void *found;
    found = dlsym(RTLD_DEFAULT, name);
    return &found;
}

static void note_act(uint32_t kind, bool worked, void *from) {
    if (trace == NULL)
        return;
    mrt_act *act = worked ? &trace->worked : &trace->refused;
    if (act->kind == 0) { /* the first one says enough */
        act->from = (uint64_t)(uintptr_t)from;
        act->kind = kind;
    }
}

MRT_ACT int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*start)(void *), void *data) {
    int error = MRT_REAL(pthread_create)(thread, attributes, start, data);
    MRT_NOTED(MRT_THREAD, error == 0);
    return error;
}

#if __has_include(<threads.h>)
#include <threads.h>
MRT_ACT int thrd_create(thrd_t *thread, thrd_start_t start, void *data) {
    int error = MRT_REAL(thrd_create)(thread, start, data);
    MRT_NOTED(MRT_THREAD, error == thrd_success);
    return error;
}
#endif

MRT_ACT pid_t fork(void) {
    pid_t child = MRT_REAL(fork)();
    MRT_NOTED(MRT_PROCESS, child >= 0);
    return child;
}

MRT_ACT int system(const char *command) {
    int status = MRT_REAL(system)(command);
    MRT_NOTED(MRT_PROCESS, status != -1 && status != 127 << 8);
    return status;
}

MRT_ACT FILE *popen(const char *command, const char *mode) {
    FILE *pipe = MRT_REAL(popen)(command, mode);
    MRT_NOTED(MRT_PROCESS, pipe != NULL);
    return pipe;
}

MRT_ACT int posix_spawn(pid_t *child, const char *path, const posix_spawn_file_actions_t *actions,
                        const posix_spawnattr_t *attributes, char *const argv[], char *const environment[]) {
    int error = MRT_REAL(posix_spawn)(child, path, actions, attributes, argv, environment);
    MRT_NOTED(MRT_PROCESS, error == 0);
    return error;
}

MRT_ACT int execve(const char *path, char *const argv[], char *const environment[]) {
    int answer = MRT_REAL(execve)(path, argv, environment);
    MRT_NOTED(MRT_PROCESS, false); /* or it would not have come back */
    return answer;
}

MRT_ACT FILE *fopen(const char *path, const char *mode) {
    FILE *file = MRT_REAL(fopen)(path, mode);
    MRT_NOTED(MRT_FILE, file != NULL);
    return file;
}

MRT_ACT int open(const char *path, int flags, ...) {
    va_list rest;
    va_start(rest, flags);
    int mode = (flags & O_CREAT) != 0 ? va_arg(rest, int) : 0;
    va_end(rest);
    int file = MRT_REAL(open)(path, flags, mode);
    MRT_NOTED(MRT_FILE, file >= 0);
    return file;
}

MRT_ACT int socket(int domain, int type, int protocol) {
    int end = MRT_REAL(socket)(domain, type, protocol);
    MRT_NOTED(MRT_NETWORK, end >= 0);
    return end;
}
