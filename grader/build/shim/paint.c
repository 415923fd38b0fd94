/* paint.c - part of the shim: a local variable that gets no first value has no chance of a right one.
 *
 * What a function finds in its variables is what the calls before it have left on the stack: often zeros, which hide
 * the mistake. Every call goes through a wrapper, which fills the stack below it first, as gcc's
 * -ftrivial-auto-var-init=pattern would: a float is then -1.7e38, an int -16843010, a bool neither true nor false, and
 * a pointer leads nowhere. (The option itself makes a bool false.)
 */
#include <string.h>

#define MRT_PAINTED_BYTES 8192
#define MRT_PAINT 0xFE

#ifdef __clang__
#define MRT_UNTOUCHED __attribute__((noinline, no_sanitize("address")))
#else
#define MRT_UNTOUCHED __attribute__((noinline, noclone, no_sanitize_address))
#endif

static void mrt_paint(void) MRT_UNTOUCHED;

static void mrt_paint(void) {
    unsigned char below[MRT_PAINTED_BYTES];
    memset(below, MRT_PAINT, sizeof below);
    __asm__ volatile("" : : "r"(below) : "memory"); /* it is read: the optimiser keeps the writes */
}
