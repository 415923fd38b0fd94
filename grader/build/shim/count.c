/* count.c - How often the functions that intersect an object are entered.
 *
 * Part of the shim in the libraries that count: there the compiler calls the first function below at the entry of every
 * other. A tree of boxes may call intersect_sphere without going through intersect_object: entries miss nothing.
 */
#include <stdint.h>

#define MRT_UNSEEN __attribute__((no_instrument_function))

/* A submission may lack one: its address is then NULL. */
extern __typeof__(intersect_plane) intersect_plane __attribute__((weak));
extern __typeof__(intersect_sphere) intersect_sphere __attribute__((weak));
extern __typeof__(intersect_cylinder) intersect_cylinder __attribute__((weak));
extern __typeof__(intersect_cone) intersect_cone __attribute__((weak));

void __cyg_profile_func_enter(void *function, void *caller) MRT_UNSEEN;
void __cyg_profile_func_exit(void *function, void *caller) MRT_UNSEEN;
uint64_t mrt_object_tests(void) MRT_UNSEEN;

static uint64_t mrt_entries;

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

/* Returns the number of entries since it was last asked. */
uint64_t mrt_object_tests(void) {
    return __atomic_exchange_n(&mrt_entries, 0, __ATOMIC_RELAXED);
}
