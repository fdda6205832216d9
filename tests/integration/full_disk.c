/* A disk that is full on demand, for tests: preloaded (LD_PRELOAD) into the programs.
 *
 * Every call that changes what is below one of the folders of FULL_DISK_ROOTS (separated by colons) is a step. While the
 * file FULL_DISK_CONTROL/full exists, each step fails with ENOSPC. FULL_DISK_CONTROL/after holds a number: that many steps
 * succeed, then `full` is made. The child that reads uploads has no environment, so its output file, which ingestd opens
 * for it, is /dev/full in a step of its own.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static int below_roots(const char* path) {
  const char* at = getenv("FULL_DISK_ROOTS");
  while (at != NULL && *at != 0) {
    const size_t length = strcspn(at, ":");
    if (length > 0 && strncmp(path, at, length) == 0 && (path[length] == '/' || path[length] == 0)) return 1;
    at += length + (at[length] == ':');
  }
  return 0;
}

/* Raw system calls from here on: nothing of the bookkeeping is a step. */
static int control(const char* name, int flags) {
  char path[4096];
  const char* folder = getenv("FULL_DISK_CONTROL");
  if (folder == NULL) return -1;
  snprintf(path, sizeof path, "%s/%s", folder, name);
  return (int)syscall(SYS_openat, AT_FDCWD, path, flags | O_CLOEXEC, 0666);
}

static int step_fails(void) {
  const int saved = errno;
  int fails = 0;
  const int full = control("full", O_RDONLY);
  if (full >= 0) {
    syscall(SYS_close, full);
    fails = 1;
  } else {
    const int after = control("after", O_RDWR);
    if (after >= 0) {
      char text[32] = {0};
      syscall(SYS_flock, after, LOCK_EX);
      if (syscall(SYS_pread64, after, text, sizeof text - 1, 0) > 0) {
        const long left = atol(text);
        if (left == 0) {
          const int made = control("full", O_WRONLY | O_CREAT);
          if (made >= 0) syscall(SYS_close, made);
          syscall(SYS_ftruncate, after, 0);
          fails = 1;
        } else {
          const int length = snprintf(text, sizeof text, "%-10ld\n", left - 1);
          syscall(SYS_pwrite64, after, text, length, 0);
        }
      }
      syscall(SYS_close, after);
    }
  }
  errno = fails ? ENOSPC : saved;
  return fails;
}

static int path_step_fails(int folder, const char* path) {
  char full[8192];
  if (path[0] == '/') return below_roots(path) && step_fails();
  char link[64];
  snprintf(link, sizeof link, folder == AT_FDCWD ? "/proc/self/cwd" : "/proc/self/fd/%d", folder);
  const ssize_t length = readlink(link, full, 4095);
  if (length <= 0) return 0;
  snprintf(full + length, sizeof full - (size_t)length, "/%s", path);
  return below_roots(full) && step_fails();
}

static int fd_step_fails(int fd) {
  char link[64], path[4096];
  const int saved = errno;
  snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t length = readlink(link, path, sizeof path - 1);
  errno = saved;
  if (length <= 0) return 0;
  path[length] = 0;
  return below_roots(path) && step_fails();
}

static int open_step(int folder, const char* path, int* flags, const char** instead) {
  if ((*flags & O_TMPFILE) == O_TMPFILE) {
    if (path_step_fails(folder, path)) return -1;
    if (path_step_fails(folder, path)) {
      *instead = "/dev/full";
      *flags = O_RDWR | O_CLOEXEC;
    }
    return 0;
  }
  struct stat info;
  const int makes = (*flags & O_CREAT) != 0 && fstatat(folder, path, &info, 0) != 0;
  return makes && path_step_fails(folder, path) ? -1 : 0;
}

#define OPEN(name, folder_parameter, folder, call)            \
  int name(folder_parameter const char* path, int flags, ...) { \
    va_list list;                                              \
    va_start(list, flags);                                     \
    const mode_t mode = va_arg(list, mode_t);                  \
    va_end(list);                                              \
    const char* instead = path;                                \
    if (open_step(folder, path, &flags, &instead) != 0) return -1; \
    path = instead;                                            \
    return call;                                               \
  }
#define COMMA ,
OPEN(open, , AT_FDCWD, REAL(open)(path, flags, mode))
OPEN(open64, , AT_FDCWD, REAL(open64)(path, flags, mode))
OPEN(openat, int folder COMMA, folder, REAL(openat)(folder, path, flags, mode))
OPEN(openat64, int folder COMMA, folder, REAL(openat64)(folder, path, flags, mode))

ssize_t write(int fd, const void* data, size_t bytes) { return fd_step_fails(fd) ? -1 : REAL(write)(fd, data, bytes); }
ssize_t writev(int fd, const struct iovec* parts, int count) {
  return fd_step_fails(fd) ? -1 : REAL(writev)(fd, parts, count);
}
ssize_t pwrite(int fd, const void* data, size_t bytes, off_t at) {
  return fd_step_fails(fd) ? -1 : REAL(pwrite)(fd, data, bytes, at);
}
ssize_t pwrite64(int fd, const void* data, size_t bytes, off64_t at) {
  return fd_step_fails(fd) ? -1 : REAL(pwrite64)(fd, data, bytes, at);
}
int fsync(int fd) { return fd_step_fails(fd) ? -1 : REAL(fsync)(fd); }
int fdatasync(int fd) { return fd_step_fails(fd) ? -1 : REAL(fdatasync)(fd); }
int mkdir(const char* path, mode_t mode) { return path_step_fails(AT_FDCWD, path) ? -1 : REAL(mkdir)(path, mode); }
int rename(const char* from, const char* to) { return path_step_fails(AT_FDCWD, to) ? -1 : REAL(rename)(from, to); }
int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) {
  return path_step_fails(to_folder, to) ? -1 : REAL(renameat2)(from_folder, from, to_folder, to, flags);
}
int unlink(const char* path) { return path_step_fails(AT_FDCWD, path) ? -1 : REAL(unlink)(path); }
int unlinkat(int folder, const char* path, int flags) {
  return path_step_fails(folder, path) ? -1 : REAL(unlinkat)(folder, path, flags);
}
int rmdir(const char* path) { return path_step_fails(AT_FDCWD, path) ? -1 : REAL(rmdir)(path); }
int remove(const char* path) { return path_step_fails(AT_FDCWD, path) ? -1 : REAL(remove)(path); }
