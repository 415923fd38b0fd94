/* reading.c - programs that read what is not theirs. */
#include "hostile.h"
#include <dirent.h>
#include <sys/uio.h>

static int reads(const char *path)
{
    char bytes[64];
    int file = open(path, O_RDONLY);
    ssize_t count = file < 0 ? -1 : read(file, bytes, sizeof bytes);
    if (count > 0)
        fwrite(bytes, 1, (size_t)count, stdout); /* the test looks for the secret in all that comes back */
    return count > 0;
}

ATTACK(read_secret) { COULD(reads(SECRET)); }
ATTACK(read_passwd) { COULD(reads("/etc/passwd")); }
ATTACK(read_shadow) { COULD(reads("/etc/shadow")); }
ATTACK(read_reference) { COULD(reads(ROOT "/reference/raytracer.c")); }
ATTACK(read_expected) { COULD(reads(ROOT "/reference/expected/manifest.json")); }
ATTACK(read_grader) { COULD(reads(ROOT "/grader/judge.py")); }
ATTACK(read_processes) { COULD(reads("/proc/1/environ") || reads("/proc/self/maps") || reads("/proc/1/cmdline")); }

ATTACK(read_memory_of_worker)
{
    char path[64];
    snprintf(path, sizeof path, "/proc/%d/mem", getppid());
    COULD(open(path, O_RDWR) >= 0);
}

ATTACK(read_worker_directly)
{
    char here[8];
    struct iovec mine = {here, sizeof here}, theirs = {img, sizeof here};
    COULD(process_vm_readv(getppid(), &mine, 1, &theirs, 1, 0) > 0);
}

ATTACK(list_folders) { COULD(opendir("/") != NULL && readdir(opendir("/")) != NULL); }
ATTACK(read_devices) { COULD(reads("/dev/urandom") || reads("/dev/zero") || reads("/dev/mem")); }
ATTACK(read_home) { COULD(reads("/root/.bashrc") || reads("/home")); }
ATTACK(read_open_files)
{
    char byte;
    int found = 0;
    for (int k = 4; k < 256; k++)
        found += pread(k, &byte, 1, 0) == 1;
    COULD(found);
}
