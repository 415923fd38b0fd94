/* kernel.c - programs that ask the kernel for doors, and for more rights. */
#include "hostile.h"
#include <arpa/inet.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/un.h>

ATTACK(internet) { COULD(socket(AF_INET, SOCK_STREAM, 0) >= 0 || socket(AF_INET6, SOCK_DGRAM, 0) >= 0); }
ATTACK(local_socket) { COULD(socket(AF_UNIX, SOCK_STREAM, 0) >= 0); }
ATTACK(socket_pair)
{
    int ends[2];
    COULD(socketpair(AF_UNIX, SOCK_STREAM, 0, ends) == 0 || pipe(ends) == 0);
}
ATTACK(netlink_socket) { COULD(socket(AF_NETLINK, SOCK_RAW, 0) >= 0 || socket(AF_PACKET, SOCK_RAW, 0) >= 0); }
ATTACK(new_namespaces) { COULD(unshare(CLONE_NEWUSER) == 0 || unshare(CLONE_NEWNS) == 0 || unshare(CLONE_NEWPID) == 0); }
ATTACK(mount_something) { COULD(mount("none", "/mrt", "tmpfs", 0, NULL) == 0 || umount("/mrt/stage") == 0 || chroot("/") == 0); }
ATTACK(become_root) { COULD(setuid(0) == 0 || setgid(0) == 0 || setresuid(0, 0, 0) == 0); }
ATTACK(io_ring) { COULD(syscall(SYS_io_uring_setup, 8, calloc(1, 256)) >= 0); }
ATTACK(kernel_program) { COULD(syscall(SYS_bpf, 0, calloc(1, 256), 128) >= 0); }
ATTACK(page_faults) { COULD(syscall(SYS_userfaultfd, 0) >= 0); }
ATTACK(counters) { COULD(syscall(SYS_perf_event_open, calloc(1, 256), 0, -1, -1, 0) >= 0); }
ATTACK(keys) { COULD(syscall(SYS_add_key, "user", MARK, "x", 1, -1) >= 0); }
ATTACK(be_dumpable) { COULD(prctl(PR_SET_DUMPABLE, 1) == 0 || prctl(PR_SET_PDEATHSIG, 0) == 0); }
ATTACK(filter_again) { COULD(prctl(PR_SET_SECCOMP, 0) == 0 || syscall(SYS_seccomp, 1, 0, NULL) == 0); }
ATTACK(more_time)
{
    struct rlimit all = {RLIM_INFINITY, RLIM_INFINITY};
    COULD(setrlimit(RLIMIT_CPU, &all) == 0 || setrlimit(RLIMIT_AS, &all) == 0 || setrlimit(RLIMIT_FSIZE, &all) == 0);
}
ATTACK(open_by_handle) { COULD(syscall(SYS_open_by_handle_at, -100, calloc(1, 256), 0) >= 0 || open(".", O_TMPFILE | O_RDWR, 0600) >= 0); }
ATTACK(watch_files) { COULD(syscall(SYS_fanotify_init, 0, 0) >= 0 || syscall(SYS_inotify_init1, 0) >= 0); }
#ifdef __x86_64__
/* The same calls under their 32-bit numbers: socket is 102 there, and 41 with the x32 bit here. */
ATTACK(other_numbers) { COULD(syscall(0x40000000 + 41, AF_INET, SOCK_STREAM, 0) >= 0); }
ATTACK(old_gate)
{
    long answer;
    __asm__ volatile("int $0x80" : "=a"(answer) : "a"(20L) : "memory"); /* getpid for 32 bits: kills */
    COULD(answer > 0);
}
#else
ATTACK(other_numbers) { COULD(0); }
ATTACK(old_gate) { abort(); }
#endif
ATTACK(send_descriptor)
{
    char control[CMSG_SPACE(sizeof(int))] = {0}, byte = 0;
    struct iovec part = {&byte, 1};
    struct msghdr message = {.msg_iov = &part, .msg_iovlen = 1, .msg_control = control, .msg_controllen = sizeof control};
    struct cmsghdr *head = CMSG_FIRSTHDR(&message);
    head->cmsg_level = SOL_SOCKET;
    head->cmsg_type = SCM_RIGHTS;
    head->cmsg_len = CMSG_LEN(sizeof(int));
    int sent = 0;
    for (int k = 3; k < 64; k++)
        sent += sendmsg(k, &message, 0) >= 0;
    COULD(sent);
}
ATTACK(shorten_page)
{
    int cut = 0;
    for (int k = 0; k < 256; k++)
        cut += ftruncate(k, 0) == 0;
    COULD(cut);
}
