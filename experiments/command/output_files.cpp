#include "experiments/command/output_files.h"

#include "framework/core/error.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <map>
#include <system_error>

namespace etendue {

namespace {

namespace fs = std::filesystem;

constexpr int most_links = 40;  // as the kernel follows

[[noreturn]] void refuse(const Location& where, const std::error_code& reason) {
  throw Error(where,
              fmt::format("cannot be written ({}); expected a file in a directory that can be written to", reason.message()));
}

// The file that a path means: links followed, even one to a file that is not there yet, and absolute.
fs::path resolve(const std::string& path, const Location& where) {
  std::error_code error;
  fs::path target = fs::absolute(path, error);
  for (int links = 0; !error && fs::is_symlink(fs::symlink_status(target, error)); ++links) {
    if (links == most_links) refuse(where, std::make_error_code(std::errc::too_many_symbolic_link_levels));
    target = target.parent_path() / fs::read_symlink(target, error);
  }
  if (error && error != std::errc::no_such_file_or_directory) refuse(where, error);
  const fs::path parent = target.parent_path();
  if (!fs::is_directory(parent, error))
    throw Error(where, "no directory '" + fs::path(path).parent_path().string() + "'; expected one that exists");
  target = fs::canonical(parent, error) / target.filename();
  if (error) refuse(where, error);
  const fs::file_status status = fs::status(target, error);
  if (!fs::status_known(status)) refuse(where, error);
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw Error(where, "exists and is not a regular file; expected a file, or a name that is free");
  return target;
}

// A new, empty file in the directory of `target`; its name is short, so that any name of the target will do.
std::string create_beside(const fs::path& target, const Location& where) {
  for (int attempt = 0;; ++attempt) {
    const std::string partial = target.parent_path() / fmt::format("etendue-{}-{}.part", ::getpid(), attempt);
    if (std::FILE* file = std::fopen(partial.c_str(), "wbx")) {
      std::fclose(file);
      return partial;
    }
    if (errno != EEXIST) refuse(where, {errno, std::generic_category()});
  }
}

}  // namespace

void check_outputs(const std::vector<OutputFile>& outputs) {
  std::map<fs::path, std::string> options;
  for (const auto& [option, path] : outputs) {
    const Location where{option + " " + path};
    const fs::path target = resolve(path, where);
    if (const auto [other, is_new] = options.emplace(target, option); !is_new)
      throw Error(where, fmt::format("the same file as that of {}; expected another", other->second));
    std::remove(create_beside(target, where).c_str());
  }
}

void replace_file(const std::string& path, const std::function<void(const std::string& partial)>& write) {
  const Location where{path};
  const fs::path target = resolve(path, where);
  const std::string partial = create_beside(target, where);
  try {
    write(partial);
    fs::rename(partial, target);
  } catch (const std::exception& e) {
    std::remove(partial.c_str());
    throw Error(where, fmt::format("cannot be written: {}", e.what()));
  }
}

}  // namespace etendue
