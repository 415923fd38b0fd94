/* renew.c - part of the shim: one process serves several checks, each of which finds the library as the first did.
 *
 * A process of its own for each check costs more than most checks. What the submission may have left in its variables,
 * static ones among them, is put back before the next: the bytes of the library's writable memory, as they were when it
 * had just been loaded. So code that counts its calls, or keeps something, gives what it gives in a new process. What
 * malloc has given is not taken back; that a check which fails is run again in a process of its own makes up for it.
 */
#include <stdbool.h>

bool mrt_keep(void);
void mrt_renew(void);

#ifdef __linux__
#include <link.h>

#define MRT_RANGES 8

typedef struct {
    uint64_t *start; /* in the library */
    uint64_t *kept;  /* its copy */
    size_t words;
} mrt_range;

static mrt_range ranges[MRT_RANGES];
static int range_count;

/* The sanitizer does not let its gaps between variables be read. */
static void copy_words(volatile uint64_t *to, const volatile uint64_t *from, size_t count) MRT_UNTOUCHED;

static void copy_words(volatile uint64_t *to, const volatile uint64_t *from, size_t count) {
    for (size_t k = 0; k < count; k++)
        to[k] = from[k];
}

/* Notes what can be written of the library that `base` is the address of; 1 when not all of it can be put back. */
static int note_ranges(struct dl_phdr_info *library, size_t size, void *base) {
    (void)size;
    if (library->dlpi_addr != (uintptr_t)base)
        return 0;
    uintptr_t constant = 0, variable = 0; /* what the loader has written for good lies from the one to the other */
    for (int k = 0; k < library->dlpi_phnum; k++) {
        const ElfW(Phdr) *part = &library->dlpi_phdr[k];
        if (part->p_type == PT_TLS && part->p_memsz > 0)
            return 1; /* variables of a thread lie elsewhere */
        if (part->p_type == PT_GNU_RELRO) {
            constant = library->dlpi_addr + part->p_vaddr;
            variable = constant + part->p_memsz;
        }
    }
    for (int k = 0; k < library->dlpi_phnum; k++) {
        const ElfW(Phdr) *part = &library->dlpi_phdr[k];
        if (part->p_type != PT_LOAD || (part->p_flags & PF_W) == 0)
            continue;
        uintptr_t start = library->dlpi_addr + part->p_vaddr, end = start + part->p_memsz;
        if (constant <= start && start < variable)
            start = variable;
        if (start >= end)
            continue;
        if (range_count == MRT_RANGES)
            return 1;
        /* Whole words: a page, of which both ends are part, has room for them. */
        start = start / sizeof(uint64_t) * sizeof(uint64_t);
        size_t words = (end - start + sizeof(uint64_t) - 1) / sizeof(uint64_t);
        ranges[range_count++] = (mrt_range){.start = (uint64_t *)start, .words = words};
    }
    return 0;
}

/* Keeps the variables as they are, for mrt_renew; false when that cannot be done. */
bool mrt_keep(void) {
    Dl_info own;
    if (dladdr((void *)&mrt_keep, &own) == 0 || dl_iterate_phdr(note_ranges, own.dli_fbase) != 0)
        return false;
    for (int k = 0; k < range_count; k++) {
        ranges[k].kept = malloc(ranges[k].words * sizeof(uint64_t));
        if (ranges[k].kept == NULL)
            return false;
    }
    for (int k = 0; k < range_count; k++)
        copy_words(ranges[k].kept, ranges[k].start, ranges[k].words);
    return range_count > 0;
}

/* Puts the variables back as mrt_keep found them, and the C library's random numbers to their beginning. */
void mrt_renew(void) {
    const mrt_range *all = ranges;
    for (int k = 0; k < range_count; k++)
        copy_words(all[k].start, all[k].kept, all[k].words);
    unsigned short first[3] = {0, 0, 0};
    seed48(first);
    srand(1);
}
#else
bool mrt_keep(void) {
    return false;
}

void mrt_renew(void) {
}
#endif
