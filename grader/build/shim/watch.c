/* watch.c - part of the shim: where a submission was when it died, or when it was told to stop.
 *
 * On a signal, the addresses of the running calls go to memory that outlives the process; the grader turns them into
 * functions and lines. Only async-signal-safe functions are called, but for backtrace, which mrt_watch has called once
 * before so that all it needs is there.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <execinfo.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/ucontext.h>

#ifndef SI_KERNEL
#define SI_KERNEL 128 /* Linux's */
#endif
#define MRT_FRAMES 32
#define MRT_STACK_BYTES 65536

/* An act that isolation may refuse (acts.c): its kind, 0 for none, and from where it was done. */
typedef struct {
    uint64_t from;
    uint32_t kind;
    uint32_t unused;
} mrt_act;

/* The same layout as in worker/frames.py. */
typedef struct {
    uint64_t base;    /* where the library is */
    uint64_t pc;      /* the instruction that was running */
    uint64_t stack;   /* where the stack ended */
    uint64_t address; /* what could not be read or written */
    uint32_t signal;  /* 0 as long as all is well */
    uint32_t count;   /* of frames */
    uint64_t frames[MRT_FRAMES];
    mrt_act refused; /* the first that was */
    mrt_act worked;  /* the first that was not */
} mrt_trace;

static mrt_trace *volatile trace;
static _Alignas(16) char signal_stack[MRT_STACK_BYTES];

static void note_registers(const ucontext_t *context) {
#if defined(__linux__) && defined(__x86_64__)
    trace->pc = (uint64_t)context->uc_mcontext.gregs[REG_RIP];
    trace->stack = (uint64_t)context->uc_mcontext.gregs[REG_RSP];
#elif defined(__linux__) && defined(__aarch64__)
    trace->pc = (uint64_t)context->uc_mcontext.pc;
    trace->stack = (uint64_t)context->uc_mcontext.sp;
#else
    (void)context;
#endif
}

static void on_signal(int number, siginfo_t *info, void *context) {
    if (trace->signal == 0) { /* a second fault, in here, has nothing to add */
        trace->signal = (uint32_t)number;
        note_registers(context);
        /* A signal that was sent has no address, and of some faults the processor does not tell it. */
        trace->address =
            info->si_code > 0 && info->si_code != SI_KERNEL ? (uint64_t)(uintptr_t)info->si_addr : UINT64_MAX;
        void *frames[MRT_FRAMES];
        int count = backtrace(frames, MRT_FRAMES);
        for (int k = 0; k < count; k++)
            trace->frames[k] = (uint64_t)(uintptr_t)frames[k];
        trace->count = (uint32_t)count;
    }
    /* Die of that signal, as if nobody had looked. */
    signal(number, SIG_DFL);
    sigset_t only;
    sigemptyset(&only);
    sigaddset(&only, number);
    sigprocmask(SIG_UNBLOCK, &only, NULL);
    raise(number);
}

/* Watches from now on; with the sanitizers, faults are left to them, who know more. */
void mrt_watch(void *memory, int sanitized) {
    void *frame;
    backtrace(&frame, 1);
    trace = memory;
    Dl_info library;
    trace->base = dladdr((void *)&mrt_watch, &library) != 0 ? (uint64_t)(uintptr_t)library.dli_fbase : 0;
    setvbuf(stdout, NULL, _IONBF, 0); /* what is printed before a crash would be lost */
    stack_t stack = {.ss_sp = signal_stack, .ss_size = sizeof signal_stack};
    sigaltstack(&stack, NULL);
    struct sigaction action = {.sa_flags = SA_SIGINFO | SA_ONSTACK};
    action.sa_sigaction = on_signal;
    const int signals[] = {SIGABRT, SIGXCPU, SIGUSR1, SIGTRAP, SIGILL, SIGSEGV, SIGBUS, SIGFPE};
    const int count = (int)(sizeof signals / sizeof signals[0]);
    for (int k = 0; k < (sanitized ? 4 : count); k++)
        sigaction(signals[k], &action, NULL);
}
