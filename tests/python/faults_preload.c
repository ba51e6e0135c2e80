/* Preloaded into a run, makes one of its calls that change files fail, or ends the run there (tests/python/faults.py).

   FAULT_FOLDER  only calls on files below it count
   FAULT_AT      the number of the call, from 1; 0: none
   FAULT_KIND    kill    SIGKILL before the call
                 power   the same, and what was not on the disk by fsync is gone: bytes, names, renames
                 eio, enospc   the call fails
                 short   a write writes half of its bytes, others go on
                 eintr   the call is interrupted once
   FAULT_COUNT   a file that gets the number of calls at the end */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static long calls = 0;

/* What a power loss would take back, the oldest first. */
struct change {
  enum { GROWN, MADE, RENAMED } kind;
  char path[PATH_MAX];
  char before[PATH_MAX];  /* RENAMED: the name it had */
  char replaced[PATH_MAX]; /* RENAMED: a link to what had the name; empty if nothing had */
  off_t size;             /* GROWN: on the disk */
};
static struct change* changes = NULL;
static size_t change_count = 0;

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static int is_ours(const char* path, char* full) {
  const char* folder = getenv("FAULT_FOLDER");
  char buffer[PATH_MAX];
  if (folder == NULL) return 0;
  if (path[0] != '/') {
    char here[PATH_MAX];
    if (getcwd(here, sizeof here) == NULL) return 0;
    snprintf(buffer, sizeof buffer, "%s/%s", here, path);
  } else {
    snprintf(buffer, sizeof buffer, "%s", path);
  }
  if (full != NULL) strcpy(full, buffer);
  return strncmp(buffer, folder, strlen(folder)) == 0;
}

static int is_our_descriptor(int descriptor, char* full) {
  char link[64];
  char path[PATH_MAX];
  snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  const ssize_t size = readlink(link, path, sizeof path - 1);
  if (size < 0) return 0;
  path[size] = 0;
  return is_ours(path, full);
}

static int is_power(void) {
  const char* kind = getenv("FAULT_KIND");
  return kind != NULL && strcmp(kind, "power") == 0;
}

static struct change* note(int kind, const char* path) {
  changes = realloc(changes, (change_count + 1) * sizeof *changes);
  struct change* one = &changes[change_count++];
  memset(one, 0, sizeof *one);
  one->kind = kind;
  strcpy(one->path, path);
  return one;
}

static void forget(int (*is_safe)(const struct change*, const char*), const char* path) {
  size_t kept = 0;
  for (size_t k = 0; k < change_count; ++k) {
    if (!is_safe(&changes[k], path)) {
      changes[kept++] = changes[k];
    } else if (changes[k].replaced[0] != 0) {
      REAL(unlink)(changes[k].replaced);
    }
  }
  change_count = kept;
}
static int is_of_file(const struct change* one, const char* path) { return one->kind == GROWN && strcmp(one->path, path) == 0; }
static int is_of_folder(const struct change* one, const char* path) {
  const char* last = strrchr(one->path, '/');
  const size_t length = (size_t)(last - one->path);
  return one->kind != GROWN && strlen(path) == length && strncmp(one->path, path, length) == 0;
}

static void lose_power(void) {
  while (change_count > 0) {
    const struct change* one = &changes[--change_count];
    if (one->kind == GROWN) {
      if (REAL(truncate)(one->path, one->size) != 0) continue;
    } else if (one->kind == MADE) {
      REAL(unlink)(one->path);
    } else {
      REAL(rename)(one->path, one->before);
      if (one->replaced[0] != 0) REAL(rename)(one->replaced, one->path);
      for (size_t k = 0; k < change_count; ++k) { /* what was noted of it under its later name */
        if (strcmp(changes[k].path, one->path) == 0 && changes[k].kind == GROWN) strcpy(changes[k].path, one->before);
      }
    }
  }
}

/* 0: go on; else the call fails with errno set, or 1: it is to be cut short. */
static int fault(int is_write) {
  pthread_mutex_lock(&mutex);
  const long number = ++calls;
  const char* at = getenv("FAULT_AT");
  const char* kind = getenv("FAULT_KIND");
  int result = 0;
  if (at != NULL && kind != NULL && number == atol(at)) {
    if (strcmp(kind, "kill") == 0 || strcmp(kind, "power") == 0) {
      if (is_power()) lose_power();
      raise(SIGKILL);
    }
    if (strcmp(kind, "short") == 0) result = is_write;
    if (strcmp(kind, "eio") == 0) result = -EIO;
    if (strcmp(kind, "enospc") == 0) result = -ENOSPC;
    if (strcmp(kind, "eintr") == 0) result = is_write ? -EINTR : 0;
  }
  pthread_mutex_unlock(&mutex);
  if (result < 0) errno = -result;
  return result;
}

__attribute__((destructor)) static void tell(void) {
  const char* path = getenv("FAULT_COUNT");
  FILE* file = path == NULL ? NULL : fopen(path, "w");
  if (file == NULL) return;
  fprintf(file, "%ld\n", calls);
  fclose(file);
}

static void note_growth(const char* path, int descriptor) {
  struct stat status;
  if (!is_power() || fstat(descriptor, &status) != 0) return;
  pthread_mutex_lock(&mutex);
  int is_known = 0;
  for (size_t k = 0; k < change_count; ++k) is_known = is_known || is_of_file(&changes[k], path);
  if (!is_known) note(GROWN, path)->size = status.st_size;
  pthread_mutex_unlock(&mutex);
}

ssize_t write(int descriptor, const void* data, size_t size) {
  char path[PATH_MAX];
  if (!is_our_descriptor(descriptor, path)) return REAL(write)(descriptor, data, size);
  const int what = fault(1);
  if (what < 0) return -1;
  note_growth(path, descriptor);
  return REAL(write)(descriptor, data, what == 1 && size > 1 ? size / 2 : size);
}

int open(const char* path, int flags, ...) {
  mode_t mode = 0;
  if (flags & O_CREAT) {
    va_list arguments;
    va_start(arguments, flags);
    mode = va_arg(arguments, mode_t);
    va_end(arguments);
  }
  char full[PATH_MAX];
  if (!(flags & O_CREAT) || !is_ours(path, full)) return REAL(open)(path, flags, mode);
  if (fault(0) < 0) return -1;
  struct stat status;
  if (is_power() && stat(full, &status) != 0) {
    pthread_mutex_lock(&mutex);
    note(MADE, full);
    pthread_mutex_unlock(&mutex);
  }
  return REAL(open)(path, flags, mode);
}

int rename(const char* from, const char* to) {
  char full_from[PATH_MAX], full_to[PATH_MAX];
  if (!is_ours(from, full_from) || !is_ours(to, full_to)) return REAL(rename)(from, to);
  if (fault(0) < 0) return -1;
  if (is_power()) {
    pthread_mutex_lock(&mutex);
    struct change* one = note(RENAMED, full_to);
    strcpy(one->before, full_from);
    static int number = 0;
    snprintf(one->replaced, sizeof one->replaced, "%s/power-%d", getenv("FAULT_SPARE"), number++);
    if (link(full_to, one->replaced) != 0) one->replaced[0] = 0;
    pthread_mutex_unlock(&mutex);
  }
  return REAL(rename)(from, to);
}

int fsync(int descriptor) {
  char path[PATH_MAX];
  if (!is_our_descriptor(descriptor, path)) return REAL(fsync)(descriptor);
  if (fault(0) < 0) return -1;
  if (is_power()) {
    struct stat status;
    fstat(descriptor, &status);
    pthread_mutex_lock(&mutex);
    if (S_ISDIR(status.st_mode))
      forget(is_of_folder, path);
    else
      forget(is_of_file, path);
    pthread_mutex_unlock(&mutex);
  }
  return 0; /* nothing needs to be on the real disk */
}

int ftruncate(int descriptor, off_t size) {
  if (is_our_descriptor(descriptor, NULL) && fault(0) < 0) return -1;
  return REAL(ftruncate)(descriptor, size);
}

int close(int descriptor) {
  char path[PATH_MAX];
  struct stat status;
  const int counts = fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && is_our_descriptor(descriptor, path) &&
                     (fcntl(descriptor, F_GETFL) & O_ACCMODE) != O_RDONLY;
  const int result = counts ? fault(0) : 0;
  const int error = errno;
  const int closed = REAL(close)(descriptor);
  if (result == 0) return closed;
  errno = error;
  return -1;
}

int unlink(const char* path) {
  if (is_ours(path, NULL) && fault(0) < 0) return -1;
  return REAL(unlink)(path);
}

int mkdir(const char* path, mode_t mode) {
  if (is_ours(path, NULL) && fault(0) < 0) return -1;
  return REAL(mkdir)(path, mode);
}
