/* Calls of the C library that fail for files below one folder, to be preloaded: see benchmarks/disk_faults.py. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/types.h>
#include <unistd.h>

/* What fails: calls below `folder` numbered `first` to `end` (not included; -1: all from `first` on). */
struct plan {
    char folder[4096];
    int number, reading;
    long first, end, calls, failed;
};
static struct plan own, *plan = &own;

/* One plan for every process that has KNITLAB_FAULTS, the name of a file of this size or more. */
__attribute__((constructor)) static void share(void) {
    const char *name = getenv("KNITLAB_FAULTS");
    int file = name ? open(name, O_RDWR) : -1;
    if (file < 0) return;
    void *shared = mmap(NULL, sizeof own, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (shared != MAP_FAILED) plan = shared;
    close(file);
}

/* Let calls below a folder fail with an error number: `count` of them (-1: all) from the one numbered `first` on.
   Without a folder none fails any more, and the counts stay. */
void fault_begin(const char *where, int error, long first, long count, int reads) {
    plan->folder[0] = 0;
    if (!where[0]) return;
    plan->number = error, plan->reading = reads, plan->calls = plan->failed = 0;
    plan->first = first, plan->end = count < 0 ? -1 : first + count;
    snprintf(plan->folder, sizeof plan->folder, "%s/", where);
}

/* Return how many calls there were that could have failed, and how many did. */
long fault_calls(void) { return plan->calls; }
long fault_failed(void) { return plan->failed; }

static int fails(const char *path) {
    if (!plan->folder[0] || strncmp(path, plan->folder, strlen(plan->folder)) != 0) return 0;
    long call = __atomic_fetch_add(&plan->calls, 1, __ATOMIC_RELAXED);
    if (call < plan->first || (plan->end >= 0 && call >= plan->end)) return 0;
    __atomic_fetch_add(&plan->failed, 1, __ATOMIC_RELAXED);
    errno = plan->number;
    return 1;
}

static int fails_at(int descriptor) {
    char link[64], path[4096];
    if (!plan->folder[0]) return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0) return 0;
    path[length] = 0;
    return fails(path);
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))
#define ON_FILE(type, name, parameters, arguments, when) \
    type name parameters { return (when) && fails_at(fd) ? (type)-1 : REAL(name) arguments; }

ON_FILE(ssize_t, write, (int fd, const void *data, size_t size), (fd, data, size), 1)
ON_FILE(ssize_t, pwrite, (int fd, const void *data, size_t size, off_t at), (fd, data, size, at), 1)
ON_FILE(ssize_t, pwrite64, (int fd, const void *data, size_t size, off64_t at), (fd, data, size, at), 1)
ON_FILE(ssize_t, read, (int fd, void *data, size_t size), (fd, data, size), plan->reading)
ON_FILE(ssize_t, pread, (int fd, void *data, size_t size, off_t at), (fd, data, size, at), plan->reading)
ON_FILE(ssize_t, pread64, (int fd, void *data, size_t size, off64_t at), (fd, data, size, at), plan->reading)
ON_FILE(int, ftruncate, (int fd, off_t size), (fd, size), 1)
ON_FILE(int, ftruncate64, (int fd, off64_t size), (fd, size), 1)
ON_FILE(int, fsync, (int fd), (fd), 1)
ON_FILE(int, fdatasync, (int fd), (fd), 1)

int rename(const char *from, const char *to) { return fails(to) ? -1 : REAL(rename)(from, to); }
int mkdir(const char *path, mode_t mode) { return fails(path) ? -1 : REAL(mkdir)(path, mode); }
int unlink(const char *path) { return fails(path) ? -1 : REAL(unlink)(path); }
int unlinkat(int fd, const char *name, int flags) { return fails_at(fd) ? -1 : REAL(unlinkat)(fd, name, flags); }
int link(const char *from, const char *to) { return fails(to) ? -1 : REAL(link)(from, to); }

#define OPENS(name) \
    int name(const char *path, int flags, ...) { \
        va_list rest; \
        va_start(rest, flags); \
        mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0; \
        va_end(rest); \
        return ((flags & O_ACCMODE) != O_RDONLY || plan->reading) && fails(path) ? -1 : REAL(name)(path, flags, mode); \
    }
OPENS(open)
OPENS(open64)
