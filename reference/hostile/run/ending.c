/* ending.c - programs that end, or do not end, in every way. */
#include "hostile.h"

ATTACK(exit_0) { (void)img; exit(0); }
ATTACK(exit_at_once) { (void)img; _exit(0); }
ATTACK(abort_at_once) { (void)img; abort(); }
ATTACK(die_by_kill) { (void)img; kill(getpid(), SIGKILL); }
ATTACK(stop_itself) { (void)img; kill(getpid(), SIGSTOP); }
ATTACK(endless_loop) { for (volatile int k = 0;; k ^= 1) img[0].y = (float)k; }
ATTACK(endless_loop_deaf)
{
    for (int k = 1; k < 65; k++)
        signal(k, SIG_IGN);
    for (volatile int k = 0;; k ^= 1)
        img[0].y = (float)k;
}
ATTACK(sleep_for_ever) { (void)img; for (;;) sleep(1000); }
ATTACK(sleep_deaf)
{
    sigset_t all;
    sigfillset(&all);
    sigprocmask(SIG_BLOCK, &all, NULL);
    for (;;)
        img[0].y = (float)sleep(1000);
}
static volatile int sink;
static int deeper(int depth)
{
    volatile char room[512];
    room[depth % 512] = 1;
    sink = depth;
    return deeper(depth + 1) + room[depth % 512];
}
ATTACK(endless_recursion) { img[0].y = (float)deeper(0); }
ATTACK(null_pointer) { (void)img; *(volatile int *)0 = 1; }
ATTACK(far_outside) { ((volatile color *)img)[1 << 28].x = 1; }
ATTACK(one_past) { ((volatile color *)img)[WIDTH * HEIGHT].x = 1; }
ATTACK(divide_by_zero)
{
    volatile int zero = 0;
    img[0].y = (float)(7 / zero);
}
ATTACK(illegal_instruction) { (void)img; __builtin_trap(); }
static void leave_quietly(int number)
{
    (void)number;
    _exit(0);
}
ATTACK(leave_on_fault)
{
    (void)img;
    signal(SIGSEGV, leave_quietly);
    *(volatile int *)0 = 1;
}
ATTACK(unmap_everything)
{
    (void)img;
    for (uintptr_t page = 0x10000; page < 0x7fffffffffff; page += 1ul << 32)
        munmap((void *)page, 1ul << 32);
}
ATTACK(take_3_gigabytes)
{
    char *memory = malloc(3ul << 30);
    if (memory)
        for (size_t k = 0; k < 3ul << 30; k += 4096)
            memory[k] = 1;
    COULD(memory != NULL);
}
ATTACK(take_all_memory)
{
    /* Until there is none; then what the worker itself asks for fails. */
    for (size_t size = 1 << 28; size >= 16;) {
        char *memory = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (memory == MAP_FAILED)
            size /= 2;
        if (size < 4096)
            break;
    }
    while (malloc(1 << 10))
        ;
    while (malloc(16))
        ;
    (void)img;
}
ATTACK(fill_shadow)
{
#ifdef __SANITIZE_ADDRESS__
    /* Reserved before the limit of addresses is set, and touched from here on, without a check. */
    for (unsigned long page = 0x030000000000ul, n = 1; n <= 3000; n++, page += 1 << 20) {
        unsigned long start = page, count = 1 << 20;
        __asm__ volatile("mov $1, %%al; rep stosb" : "+D"(start), "+c"(count) : : "rax", "memory");
        if (n % 100 == 0)
            printf("%lu MB\n", n);
    }
    COULD(1);
#else
    COULD(0);
#endif
}
ATTACK(not_a_number) { for (int k = 0; k < WIDTH * HEIGHT; k++) img[k] = vector_init(0.f / 0.f, 1.f / 0.f, 0); }
