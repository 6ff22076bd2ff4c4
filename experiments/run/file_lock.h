// An exclusive lock on a file, held for the object's life and released by the system however the process ends.
#pragma once

#include <optional>
#include <string>

namespace etendue {

class FileLock {
 public:
  // Waits until the lock is free. Throws Error where the file cannot be made.
  explicit FileLock(const std::string& path);
  // nullopt where another process holds it.
  static std::optional<FileLock> try_lock(const std::string& path);

  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&&) = delete;
  ~FileLock();

 private:
  FileLock() = default;
  int file_ = -1;
};

}  // namespace etendue
