/* leaving.c - programs that leave something behind, or fill the machine. */
#include "hostile.h"
#include <mqueue.h>
#include <semaphore.h>
#include <sys/msg.h>
#include <sys/sem.h>
#include <sys/shm.h>

static int writes(const char *path)
{
    int file = open(path, O_WRONLY | O_CREAT, 0666);
    return file >= 0 && write(file, "x", 1) == 1;
}

ATTACK(write_tmp) { COULD(writes("/tmp/" MARK) || writes("/var/tmp/" MARK) || writes("/" MARK)); }
ATTACK(write_shared_memory) { COULD(writes("/dev/shm/" MARK) || shm_open("/" MARK, O_CREAT | O_RDWR, 0600) >= 0); }
ATTACK(write_beside_secret) { COULD(writes(SECRET "." MARK)); }
ATTACK(write_stage) { COULD(writes("/mrt/stage/" MARK) || writes("/mrt/inbox/" MARK) || writes(MARK)); }
ATTACK(replace_worker) { COULD(open("/mrt/stage/grader/worker/session.py", O_RDWR) >= 0); }
ATTACK(remove_secret) { COULD(unlink(SECRET) == 0 || rename(SECRET, "/tmp/" MARK) == 0 || truncate(SECRET, 0) == 0); }
ATTACK(make_folder) { COULD(mkdir("/tmp/" MARK, 0777) == 0 || symlink("/", "/tmp/" MARK) == 0); }
ATTACK(make_device) { COULD(mknod("/tmp/" MARK, S_IFIFO | 0600, 0) == 0); }

ATTACK(many_files)
{
    char path[128];
    int made = 0;
    for (int k = 0; k < 100000; k++) {
        snprintf(path, sizeof path, "/tmp/" MARK "%d", k);
        made += writes(path);
    }
    COULD(made);
}

ATTACK(fill_outputs)
{
    static char block[1 << 16];
    memset(block, 'x', sizeof block);
    for (int k = 0; k < 4096; k++)
        if (write(1, block, sizeof block) < 0 && write(2, block, sizeof block) < 0)
            break;
    struct stat about;
    COULD(fstat(1, &about) == 0 && about.st_size > 4000000);
}

ATTACK(sparse_output) { COULD(lseek(1, 1LL << 40, SEEK_SET) > 0 && write(1, "x", 1) == 1 && lseek(1, 0, SEEK_END) > 1 << 30); }
ATTACK(system_v_memory) { COULD(shmget(0x4d525421, 4096, IPC_CREAT | 0600) >= 0); }
ATTACK(system_v_queue) { COULD(msgget(0x4d525421, IPC_CREAT | 0600) >= 0 || semget(0x4d525421, 1, IPC_CREAT | 0600) >= 0); }
ATTACK(posix_queue) { COULD(syscall(SYS_mq_open, MARK, O_CREAT | O_RDWR, 0600, NULL) >= 0); }
ATTACK(memory_file) { COULD(syscall(SYS_memfd_create, MARK, 0) >= 0); }
ATTACK(write_expected) { COULD(writes(ROOT "/build/" MARK) || writes(ROOT "/" MARK)); }
