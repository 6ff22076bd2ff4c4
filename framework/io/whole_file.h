// Files that are whole or absent, whatever happens meanwhile, and what tells that one is still what was written.
#pragma once

#include "framework/core/error.h"

#include <cstdint>
#include <string>
#include <string_view>

namespace etendue {

// The machine's fault and not the input's: a full disk, a file that is too large, a folder that may not be written to.
class WriteError : public Error {
 public:
  using Error::Error;
};

// Size and XXH3 of a file's bytes.
struct FileStamp {
  std::uint64_t bytes = 0;
  std::string hash;  // 16 hexadecimal digits; "": not known

  bool operator==(const FileStamp&) const = default;
};

std::string hash_text(std::string_view bytes);  // XXH3, 16 hexadecimal digits
FileStamp stamp_of(std::string_view bytes);
// Is it a regular file, or a link to one? False where it cannot be looked at.
bool is_file(const std::string& path);
// Says why the file is not what the stamp says ("missing", "empty", "3 of 10 bytes", …); "" where it is.
std::string difference(const std::string& path, const FileStamp& stamp);

// Replaces the file in one step: the bytes go to a new file beside it, to the disk, and only then to its name, which is on the
// disk as well on return. A symbolic link stays; what it leads to is replaced. Throws WriteError, with the old file as it was
// and nothing left beside it.
FileStamp write_whole_file(const std::string& path, std::string_view bytes);

// Checks without touching it that the file could be written. Returns `path` made absolute, with links followed, even one to a
// file that is not there yet. Throws Error.
std::string check_writable(const std::string& path, const Location& where);

// Flushes the names of a folder's files to the disk. Throws WriteError.
void sync_folder(const std::string& folder);
// Makes the folder and those above it that are missing, all of them on the disk on return. Throws WriteError.
void make_folders(const std::string& folder);

// Removes what killed processes left of files that they were writing there. Call only while no other process writes there.
void remove_partial_files(const std::string& folder);

}  // namespace etendue
