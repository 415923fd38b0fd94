/* An ifunc's resolver runs while the library is being relocated, before any constructor. */
#include <unistd.h>
typedef void action(void);
static action *choose(void) { _exit(0); }
void chosen(void) __attribute__((ifunc("choose")));
void (*keep)(void) = chosen;
