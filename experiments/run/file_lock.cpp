#include "experiments/run/file_lock.h"

#include "framework/core/error.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>
#include <cerrno>
#include <cstring>
#include <utility>

namespace etendue {

namespace {

int open_lock(const std::string& path) {
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file < 0) throw Error(Location{path}, std::string("cannot make the lock: ") + std::strerror(errno));
  return file;
}

}  // namespace

FileLock::FileLock(const std::string& path) : file_(open_lock(path)) {
  while (flock(file_, LOCK_EX) != 0) {
    if (errno == EINTR) continue;
    const int error = errno;
    close(file_);
    throw Error(Location{path}, std::string("cannot lock: ") + std::strerror(error));
  }
}

std::optional<FileLock> FileLock::try_lock(const std::string& path) {
  FileLock lock;
  lock.file_ = open_lock(path);
  if (flock(lock.file_, LOCK_EX | LOCK_NB) == 0) return lock;
  if (errno != EWOULDBLOCK) throw Error(Location{path}, std::string("cannot lock: ") + std::strerror(errno));
  return std::nullopt;
}

FileLock::FileLock(FileLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}

FileLock::~FileLock() {
  if (file_ >= 0) close(file_);
}

}  // namespace etendue
