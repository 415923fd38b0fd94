/* processes.c - programs that start, stop, or take over processes. */
#include "hostile.h"
#include <pthread.h>
#include <spawn.h>
#include <sys/ptrace.h>
#include <sys/uio.h>

extern char **environ;

ATTACK(start_child)
{
    pid_t child = fork();
    if (child == 0)
        for (;;)
            pause();
    COULD(child > 0);
}

ATTACK(fork_bomb)
{
    int started = 0;
    for (int k = 0; k < 100000; k++) {
        pid_t child = fork();
        if (child == 0)
            k = 0;
        started += child > 0;
    }
    COULD(started);
}

ATTACK(daemon_that_outlives)
{
    pid_t child = fork();
    if (child == 0) {
        setsid();
        if (fork() == 0)
            for (;;)
                pause();
        _exit(0);
    }
    COULD(child > 0);
}

ATTACK(raw_clone) { COULD(syscall(SYS_clone, SIGCHLD, 0, 0, 0, 0) > 0); }
ATTACK(vfork_child)
{
    pid_t child = (pid_t)syscall(SYS_clone3, NULL, 0);
    COULD(child > 0);
}
ATTACK(run_shell) { COULD(system("touch /tmp/" MARK) == 0); }
ATTACK(run_pipe) { COULD(popen("id", "r") != NULL); }
ATTACK(become_shell)
{
    char *words[] = {"/bin/sh", "-c", "exit 0", NULL};
    execve(words[0], words, environ);
    COULD(0);
}
ATTACK(spawn_program)
{
    char *words[] = {"/usr/bin/touch", "/tmp/" MARK, NULL};
    pid_t child;
    COULD(posix_spawn(&child, words[0], NULL, NULL, words, environ) == 0);
}

static void *think(void *nothing)
{
    for (;;)
        sched_yield();
    return nothing;
}

ATTACK(start_thread)
{
    pthread_t thread;
    COULD(pthread_create(&thread, NULL, think, NULL) == 0);
}

ATTACK(kill_grader) { COULD(kill(PARENT, SIGKILL) == 0); }
ATTACK(kill_worker) { COULD(kill(getppid(), SIGKILL) == 0 || kill(1, SIGKILL) == 0 || kill(2, SIGKILL) == 0); }
ATTACK(kill_everyone) { COULD(kill(-1, SIGKILL) == 0 || killpg(0, SIGKILL) == 0 || kill(0, SIGKILL) == 0); }
ATTACK(stop_worker) { COULD(kill(getppid(), SIGSTOP) == 0); }
ATTACK(signal_thread_of_worker) { COULD(syscall(SYS_tgkill, getppid(), getppid(), SIGKILL) == 0 || syscall(SYS_tkill, getppid(), SIGKILL) == 0); }
ATTACK(queue_signal)
{
    union sigval value = {0};
    COULD(sigqueue(getppid(), SIGKILL, value) == 0);
}
ATTACK(trace_worker) { COULD(ptrace(PTRACE_ATTACH, getppid(), NULL, NULL) == 0); }
ATTACK(trace_grader) { COULD(ptrace(PTRACE_SEIZE, PARENT, NULL, NULL) == 0); }
ATTACK(write_worker)
{
    char here[8] = {0};
    struct iovec mine = {here, sizeof here}, theirs = {img, sizeof here};
    COULD(process_vm_writev(getppid(), &mine, 1, &theirs, 1, 0) > 0);
}
ATTACK(leave_session) { COULD(setsid() >= 0 || setpgid(0, 0) == 0); }
ATTACK(limit_worker)
{
    uint64_t none[2] = {0, 0};
    COULD(syscall(SYS_prlimit64, getppid(), 0, none, NULL) == 0);
}
ATTACK(watch_worker) { COULD(syscall(SYS_pidfd_open, getppid(), 0) >= 0); }
