#include "framework/io/whole_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <xxhash.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>
#include <vector>

namespace etendue {

namespace {

namespace fs = std::filesystem;

constexpr int most_links = 40;  // as the kernel follows
constexpr std::string_view partial_start = "etendue-", partial_end = ".part";

std::error_code last_error() { return {errno, std::generic_category()}; }

std::string reason_text(const std::error_code& reason) {
  return fmt::format("cannot be written ({}); expected a file in a directory that can be written to", reason.message());
}

// The file that a path means.
fs::path resolve(const std::string& path, const Location& where) {
  std::error_code error;
  fs::path target = fs::absolute(path, error);
  for (int links = 0; !error && fs::is_symlink(fs::symlink_status(target, error)); ++links) {
    if (links == most_links) throw Error(where, reason_text(std::make_error_code(std::errc::too_many_symbolic_link_levels)));
    target = target.parent_path() / fs::read_symlink(target, error);
  }
  if (error && error != std::errc::no_such_file_or_directory) throw Error(where, reason_text(error));
  const fs::path parent = target.parent_path();
  if (!fs::is_directory(parent, error))
    throw Error(where, "no directory '" + fs::path(path).parent_path().string() + "'; expected one that exists");
  target = fs::canonical(parent, error) / target.filename();
  if (error) throw Error(where, reason_text(error));
  const fs::file_status status = fs::status(target, error);
  if (!fs::status_known(status)) throw Error(where, reason_text(error));
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw Error(where, "exists and is not a regular file; expected a file, or a name that is free");
  return target;
}

// A new, empty file beside `target`, removed at the end unless it took the target's name. Its own name is short, so that any
// name of the target will do.
class PartialFile {
 public:
  PartialFile(const fs::path& target, const Location& where) : target_(target), where_(where) {
    for (int attempt = 0;; ++attempt) {
      path_ = target.parent_path() / fmt::format("{}{}-{}{}", partial_start, ::getpid(), attempt, partial_end);
      file_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
      if (file_ >= 0) return;
      if (errno != EEXIST && errno != EINTR) throw WriteError(where, reason_text(last_error()));
    }
  }
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;
  ~PartialFile() {
    if (file_ >= 0) ::close(file_);
    if (!path_.empty()) ::unlink(path_.c_str());
  }

  void write(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t written = ::write(file_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail();
      bytes.remove_prefix(static_cast<std::size_t>(written));
    }
  }
  void take_name() {
    if (::fsync(file_) != 0) fail();
    if (::close(std::exchange(file_, -1)) != 0) fail();
    if (::rename(path_.c_str(), target_.c_str()) != 0) fail();
    path_.clear();
  }

 private:
  [[noreturn]] void fail() const { throw WriteError(where_, "cannot be written: " + last_error().message()); }

  fs::path target_, path_;
  Location where_;
  int file_ = -1;
};

}  // namespace

std::string hash_text(std::string_view bytes) { return fmt::format("{:016x}", XXH3_64bits(bytes.data(), bytes.size())); }

FileStamp stamp_of(std::string_view bytes) { return {bytes.size(), hash_text(bytes)}; }

bool is_file(const std::string& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

std::string difference(const std::string& path, const FileStamp& stamp) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) return "missing";
  if (!fs::is_regular_file(status)) return "no regular file";
  const auto size = fs::file_size(path, error);
  if (error) return "cannot be read: " + error.message();
  if (size == 0 && stamp.bytes > 0) return "empty";
  if (size != stamp.bytes) return fmt::format("{} bytes instead of {}", size, stamp.bytes);
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file || bytes.size() != size) return "cannot be read to its end";
  return hash_text(bytes) == stamp.hash ? "" : "not the bytes that were written";
}

FileStamp write_whole_file(const std::string& path, std::string_view bytes) {
  const Location where{path};
  fs::path target;
  try {
    target = resolve(path, where);
  } catch (const Error& e) {
    throw WriteError(e.what());
  }
  {
    PartialFile partial(target, where);
    partial.write(bytes);
    partial.take_name();
  }
  sync_folder(target.parent_path().string());
  return stamp_of(bytes);
}

std::string check_writable(const std::string& path, const Location& where) {
  const fs::path target = resolve(path, where);
  try {
    const PartialFile attempt(target, where);
  } catch (const WriteError& e) {
    throw Error(e.what());
  }
  return target.string();
}

void sync_folder(const std::string& folder) {
  const Location where{folder};
  const int file = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) throw WriteError(where, "cannot be flushed to disk: " + last_error().message());
  const bool failed = ::fsync(file) != 0 && errno != EINVAL;  // some file systems have nothing to flush
  const std::error_code error = last_error();
  ::close(file);
  if (failed) throw WriteError(where, "cannot be flushed to disk: " + error.message());
}

void make_folders(const std::string& folder) {
  if (folder.empty()) return;  // the working directory, of which there is no absolute path to walk up from
  std::error_code error;
  std::vector<fs::path> missing;
  for (fs::path path = fs::absolute(folder, error).lexically_normal(); !fs::exists(path, error); path = path.parent_path())
    missing.push_back(path);
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder, error))
    throw WriteError(Location{folder}, "cannot make the directory: " +
                                           (error ? error : std::make_error_code(std::errc::not_a_directory)).message());
  for (const fs::path& path : missing)
    if (path.has_filename()) sync_folder(path.parent_path().string());
}

void remove_partial_files(const std::string& folder) {
  std::error_code ignored;
  std::vector<fs::path> partial;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(partial_start) && name.ends_with(partial_end)) partial.push_back(entry.path());
  }
  for (const fs::path& path : partial) fs::remove(path, ignored);
}

}  // namespace etendue
