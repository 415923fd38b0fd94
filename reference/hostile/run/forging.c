/* forging.c - programs that answer in the worker's place, or change it. */
#include "hostile.h"
#include <dlfcn.h>

/* A frame as worker/frames.py describes it: two lengths, JSON, bytes. */
static void forge(const char *json, const void *bytes, uint64_t count, uint64_t claimed)
{
    char frame[1 << 16];
    uint32_t length = (uint32_t)strlen(json);
    memcpy(frame, &length, 4);
    memcpy(frame + 4, &claimed, 8);
    memcpy(frame + 12, json, length);
    memcpy(frame + 12 + length, bytes, count);
    for (int k = 3; k < 64; k++)
        if (write(k, frame, 12 + length + count) < 0)
            continue;
}

ATTACK(forge_short_answer) { (void)img; forge("{\"is\": \"done\"}", "", 0, 0); _exit(0); }
ATTACK(forge_long_answer) { forge("{\"is\": \"done\"}", img, 64, 1ull << 60); _exit(0); }
ATTACK(forge_refusal) { (void)img; forge("{\"is\": \"refused\"}", "the grader is wrong", 19, 19); _exit(0); }
ATTACK(forge_missing) { (void)img; forge("{\"is\": \"refused\"}", "missing: everything", 19, 19); _exit(0); }
ATTACK(forge_memory) { (void)img; forge("{\"is\": \"memory\"}", "", 0, 0); _exit(0); }
ATTACK(forge_locked) { (void)img; forge("{\"is\": \"locked\"}", "", 0, 0); _exit(0); }
ATTACK(forge_list) { (void)img; forge("[1, 2, 3]", "", 0, 0); _exit(0); }
ATTACK(forge_verdict) { (void)img; forge("{\"is\": \"passed\", \"points\": 100}", "", 0, 0); _exit(0); }
ATTACK(forge_number) { (void)img; forge("{\"is\": 1e999999999}", "", 0, 0); _exit(0); }
ATTACK(forge_deep)
{
    static char deep[60000];
    memset(deep, '[', sizeof deep - 1);
    (void)img;
    forge(deep, "", 0, 0);
    _exit(0);
}
ATTACK(forge_nonsense) { (void)img; forge("\xff\xfe not JSON", "", 0, 0); _exit(0); }
ATTACK(drip_answer)
{
    uint32_t length = 1000;
    for (;;) {
        for (int k = 3; k < 64; k++)
            if (write(k, &length, 1) < 0)
                continue;
        usleep(200000);
        (void)img;
    }
}
ATTACK(flood_answer)
{
    static char zeros[1 << 16];
    for (;;)
        for (int k = 3; k < 64; k++)
            if (write(k, zeros, sizeof zeros) < 0)
                continue;
    (void)img;
}
ATTACK(close_everything)
{
    (void)img;
    for (int k = 0; k < 1024; k++)
        close(k);
}
ATTACK(steal_requests)
{
    /* Takes the worker's place for good: reads what it is asked, and answers nothing. */
    static char bytes[4096];
    for (;;)
        for (int k = 3; k < 64; k++)
            if (read(k, bytes, sizeof bytes) > 0)
                img[0].y = 1;
}
ATTACK(rewrite_interpreter)
{
    int (*run)(const char *) = (int (*)(const char *))dlsym(RTLD_DEFAULT, "PyRun_SimpleString");
    int (*ensure)(void) = (int (*)(void))dlsym(RTLD_DEFAULT, "PyGILState_Ensure");
    if (run && ensure) {
        ensure();
        run("import sys, os, gc\n"
            "for each in gc.get_objects():\n"
            "    if isinstance(each, dict) and ('expected' in each or 'points' in each): print('EXPECTED', each)\n"
            "os._exit(0)\n");
    }
    (void)img;
}
ATTACK(spoil_trace)
{
    /* The page of markers: all that the process shares with the grader. */
    memset(todo_page, 0xff, 136 + 280);
    abort();
    (void)img;
}
ATTACK(lie_in_trace)
{
    uint64_t *words = (uint64_t *)(void *)(todo_page + 136);
    words[0] = 0;
    words[1] = 0x1234;
    words[2] = 11 | (1000000ull << 32);
    for (int k = 3; k < 35; k++)
        words[k] = (uint64_t)k << 32;
    _exit(3);
    (void)img;
}
ATTACK(fool_terminal)
{
    printf("\033]0;title\007\033[2J\033[31mred\r\b\x9b" "31m \xff\xfe");
    fflush(stdout);
    _exit(1);
    (void)img;
}
ATTACK(fake_report)
{
    fprintf(stderr, "ERROR: AddressSanitizer: everything-is-right on address 0x0\n"
                    "    #0 0x1  (/mrt/inbox/mrt-0.so+0x1)\nmain.c:1:1: runtime error: points 100\n");
    abort();
    (void)img;
}
