/* count.c - How often the functions that intersect an object are entered, and how many steps all the code takes.
 *
 * Part of the shim in the libraries that count: there the compiler calls the first function below at the entry of every
 * other of the submission's, and the third wherever its way may part, a step. A tree of boxes may call intersect_sphere
 * without going through intersect_object: entries miss nothing. A test that is written out again under another name, or
 * none, is no entry, but it has its steps. Counts only grow: asking changes none.
 */
#include <stdint.h>

/* A submission may lack one: its address is then NULL. */
extern __typeof__(intersect_plane) intersect_plane __attribute__((weak));
extern __typeof__(intersect_sphere) intersect_sphere __attribute__((weak));
extern __typeof__(intersect_cylinder) intersect_cylinder __attribute__((weak));
extern __typeof__(intersect_cone) intersect_cone __attribute__((weak));
#ifdef __ELF__
/* clang does not go back over the calls above. */
__asm__(".weak intersect_plane, intersect_sphere, intersect_cylinder, intersect_cone");
#endif

void __cyg_profile_func_enter(void *function, void *caller);
void __cyg_profile_func_exit(void *function, void *caller);
void __sanitizer_cov_trace_pc(void);
uint64_t mrt_object_tests(void);
uint64_t mrt_steps(void);

static uint64_t mrt_entries, mrt_passed;

void __cyg_profile_func_enter(void *function, void *caller) {
    (void)caller;
    if (function == (void *)intersect_plane || function == (void *)intersect_sphere ||
        function == (void *)intersect_cylinder || function == (void *)intersect_cone) {
        __atomic_fetch_add(&mrt_entries, 1, __ATOMIC_RELAXED);
    }
}

void __cyg_profile_func_exit(void *function, void *caller) {
    (void)function;
    (void)caller;
}

void __sanitizer_cov_trace_pc(void) {
    __atomic_fetch_add(&mrt_passed, 1, __ATOMIC_RELAXED);
}

/* Returns the number of entries since the library was loaded. */
uint64_t mrt_object_tests(void) {
    return __atomic_load_n(&mrt_entries, __ATOMIC_RELAXED);
}

/* Returns the number of steps since the library was loaded. */
uint64_t mrt_steps(void) {
    return __atomic_load_n(&mrt_passed, __ATOMIC_RELAXED);
}
