/* canary.c - tries what a submission must not do. Each function returns 1 when it could, 0 when it was refused.
 *
 * Built and run exactly as a submission is; see canary.py.
 */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <fcntl.h>
#include <signal.h>
#include <stdint.h>
#include <sys/ptrace.h>
#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

/* The worker calls it in every library; a canary has nothing to watch. */
void mrt_watch(void *memory, int sanitized) {
    (void)memory;
    (void)sanitized;
}

int read_file(const char *path) {
    char byte;
    int file = open(path, O_RDONLY);
    int could = file >= 0 && read(file, &byte, 1) == 1;
    close(file);
    return could;
}

int write_file(const char *path) {
    int file = open(path, O_WRONLY | O_CREAT, 0600);
    int could = file >= 0 && write(file, "x", 1) == 1;
    close(file);
    return could;
}

int reach_network(int port) {
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    int end = socket(AF_INET, SOCK_STREAM, 0);
    int could = end >= 0 && connect(end, (struct sockaddr *)&address, sizeof address) == 0;
    close(end);
    return could;
}

/* Signal 0 harms nobody: it only tells whether another would arrive. */
int signal_process(int process) {
    return kill(process, 0) == 0 || kill(getppid(), 0) == 0;
}

int start_process(int unused) {
    (void)unused;
    pid_t child = fork();
    if (child == 0)
        _exit(0);
    return child > 0 && waitpid(child, NULL, 0) == child;
}

int leave_memory(int unused) {
    (void)unused;
    int memory = shmget(IPC_PRIVATE, 4096, 0600);
    if (memory >= 0)
        shmctl(memory, IPC_RMID, NULL);
    return memory >= 0;
}

int trace_worker(int unused) {
    (void)unused;
#ifdef __linux__
    if (ptrace(PTRACE_SEIZE, getppid(), NULL, NULL) == 0)
        return ptrace(PTRACE_DETACH, getppid(), NULL, NULL) == 0 || 1;
#endif
    return 0;
}
