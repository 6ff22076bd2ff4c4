// Preloaded into the program under test: calls that touch files below a folder are counted by kind, and one of them fails, or
// that one and all later ones of its kind.
//
//   ETENDUE_FAULT_BELOW   part of the paths that count
//   ETENDUE_FAULT         "write:7" or "write:7:on": the kind (open, write, fsync, rename), which call from 1, "on" for later
//   ones too ETENDUE_FAULT_COUNTS  file that gets "open N\nwrite N\n..." when the process ends
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

enum Kind { open_kind, write_kind, fsync_kind, rename_kind, kind_count };
constexpr const char* kind_names[] = {"open", "write", "fsync", "rename"};

constexpr int most_files = 4096;
std::atomic<bool> watched[most_files];
std::atomic<long> counts[kind_count];

struct Settings {
  const char* below = std::getenv("ETENDUE_FAULT_BELOW");
  int kind = -1;
  long which = 0;
  bool later_too = false;

  Settings() {
    const char* fault = std::getenv("ETENDUE_FAULT");
    if (fault == nullptr) return;
    for (int i = 0; i < kind_count; ++i) {
      const std::size_t length = std::strlen(kind_names[i]);
      if (std::strncmp(fault, kind_names[i], length) != 0 || fault[length] != ':') continue;
      kind = i;
      which = std::strtol(fault + length + 1, nullptr, 10);
      later_too = std::strstr(fault, ":on") != nullptr;
    }
  }
};

const Settings& settings() {
  static const Settings settings;
  return settings;
}

bool counts_path(const char* path) {
  return path != nullptr && settings().below != nullptr && std::strstr(path, settings().below) != nullptr;
}
bool counts_file(int file) { return file >= 0 && file < most_files && watched[file]; }

bool fails(Kind kind) {
  const long count = ++counts[kind];
  if (settings().kind != kind || !(count == settings().which || (settings().later_too && count > settings().which)))
    return false;
  errno = kind == write_kind ? ENOSPC : EIO;
  return true;
}

void trace(const char* call, const char* path, const char* target = "") {
  const char* const file = std::getenv("ETENDUE_FAULT_TRACE");
  if (file == nullptr) return;
  char line[3000];
  const int length = std::snprintf(line, sizeof(line), "%s %s %s\n", call, path, target);
  const int to = static_cast<int>(syscall(SYS_openat, AT_FDCWD, file, O_WRONLY | O_CREAT | O_APPEND, 0644));
  syscall(SYS_write, to, line, length);
  syscall(SYS_close, to);
}

void trace_file(const char* call, int file) {
  char link[64], path[1000];
  std::snprintf(link, sizeof(link), "/proc/self/fd/%d", file);
  const ssize_t length = readlink(link, path, sizeof(path) - 1);
  if (length <= 0) return;
  path[length] = '\0';
  trace(call, path);
}

// A number may have been another file's, which fclose closed unseen.
int note(int file, bool counted) {
  if (file >= 0 && file < most_files) watched[file] = counted;
  return file;
}

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

__attribute__((destructor)) void report() {
  const char* path = std::getenv("ETENDUE_FAULT_COUNTS");
  if (path == nullptr) return;
  char text[200];
  int length = 0;
  for (int i = 0; i < kind_count; ++i)
    length += std::snprintf(text + length, sizeof(text) - static_cast<std::size_t>(length), "%s %ld\n", kind_names[i],
                            counts[i].load());
  const int file = static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, O_WRONLY | O_CREAT | O_TRUNC, 0644));
  syscall(SYS_write, file, text, length);
  syscall(SYS_close, file);
}

int open_file(const char* path, int flags, mode_t mode) {
  const bool counted = counts_path(path);
  if (counted && fails(open_kind)) return -1;
  const int file = static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, flags, mode));
  return note(file, counted);
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(arguments, mode_t) : 0;
  va_end(arguments);
  return open_file(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(arguments, mode_t) : 0;
  va_end(arguments);
  return open_file(path, flags | O_LARGEFILE, mode);
}
FILE* fopen(const char* path, const char* mode) {
  const bool counted = counts_path(path);
  if (counted && fails(open_kind)) return nullptr;
  FILE* const file = next<FILE*(const char*, const char*)>("fopen")(path, mode);
  if (file != nullptr) note(fileno(file), counted);
  return file;
}
FILE* fopen64(const char* path, const char* mode) {
  const bool counted = counts_path(path);
  if (counted && fails(open_kind)) return nullptr;
  FILE* const file = next<FILE*(const char*, const char*)>("fopen64")(path, mode);
  if (file != nullptr) note(fileno(file), counted);
  return file;
}
int close(int file) {
  if (file >= 0 && file < most_files) watched[file] = false;
  return static_cast<int>(syscall(SYS_close, file));
}
ssize_t write(int file, const void* data, size_t size) {
  if (counts_file(file) && fails(write_kind)) {
    // On a disk that fills, half of it still fits.
    if (size > 1) syscall(SYS_write, file, data, size / 2);
    errno = ENOSPC;
    return -1;
  }
  if (counts_file(file)) trace_file("write", file);
  return syscall(SYS_write, file, data, size);
}
ssize_t writev(int file, const iovec* parts, int count) {
  if (counts_file(file) && fails(write_kind)) return -1;
  return syscall(SYS_writev, file, parts, count);
}
int fsync(int file) {
  if (counts_file(file) && fails(fsync_kind)) return -1;
  if (counts_file(file)) trace_file("fsync", file);
  return static_cast<int>(syscall(SYS_fsync, file));
}
int rename(const char* from, const char* to) {
  if (counts_path(to) && fails(rename_kind)) return -1;
  if (counts_path(to)) trace("rename", from, to);
  return static_cast<int>(syscall(SYS_renameat, AT_FDCWD, from, AT_FDCWD, to));
}

}  // extern "C"
