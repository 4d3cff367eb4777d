/* Calls of the C library that fail for files below one folder, to be preloaded: see benchmarks/disk_faults.py. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

static char folder[4096];
static int number, reading;
static long left = -1, many, calls;

/* Let calls below a folder fail with an error number: `count` of them (-1: all) from the one numbered `first` on. */
void fault_begin(const char *where, int error, long first, long count, int reads) {
    snprintf(folder, sizeof folder, "%s/", where);
    number = error, left = first, many = count, reading = reads, calls = 0;
}

/* Return how many calls there were that could have failed. */
long fault_calls(void) { return calls; }

static int fails(const char *path) {
    if (!folder[0] || strncmp(path, folder, strlen(folder)) != 0) return 0;
    calls++;
    if (left > 0) return left--, 0;
    if (many == 0 || left < 0) return 0;
    if (many > 0) many--;
    errno = number;
    return 1;
}

static int fails_at(int descriptor) {
    char link[64], path[4096];
    if (!folder[0]) return 0;
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
ON_FILE(ssize_t, read, (int fd, void *data, size_t size), (fd, data, size), reading)
ON_FILE(ssize_t, pread, (int fd, void *data, size_t size, off_t at), (fd, data, size, at), reading)
ON_FILE(ssize_t, pread64, (int fd, void *data, size_t size, off64_t at), (fd, data, size, at), reading)
ON_FILE(int, ftruncate, (int fd, off_t size), (fd, size), 1)
ON_FILE(int, ftruncate64, (int fd, off64_t size), (fd, size), 1)
ON_FILE(int, fsync, (int fd), (fd), 1)
ON_FILE(int, fdatasync, (int fd), (fd), 1)

int rename(const char *from, const char *to) { return fails(to) ? -1 : REAL(rename)(from, to); }
int mkdir(const char *path, mode_t mode) { return fails(path) ? -1 : REAL(mkdir)(path, mode); }

#define OPENS(name) \
    int name(const char *path, int flags, ...) { \
        va_list rest; \
        va_start(rest, flags); \
        mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0; \
        va_end(rest); \
        return ((flags & O_ACCMODE) != O_RDONLY || reading) && fails(path) ? -1 : REAL(name)(path, flags, mode); \
    }
OPENS(open)
OPENS(open64)
