#include "framework/io/scene_files.h"

#include "framework/core/memory.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_named = 10;

// To look how much memory is free takes longer than to read a small file.
constexpr std::uint64_t look_every_bytes = std::uint64_t{1} << 26;

fs::path resolved(const fs::path& path) {
  std::error_code error;
  const fs::path canonical = fs::weakly_canonical(path.empty() ? fs::path(".") : path, error);
  return error ? fs::absolute(path, error).lexically_normal() : canonical;
}

bool lies_below(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

}  // namespace

SceneFiles::SceneFiles(std::string first_file, const SceneReading& reading, bool first_folder_first)
    : first_file_(std::move(first_file)),
      confined_(reading.confined),
      first_folder_first_(first_folder_first),
      approximations_(reading.approximate),
      folder_(resolved(fs::path(first_file_).parent_path())) {}

std::string SceneFiles::resolve(const std::string& name, const std::string& named_in) const {
  const fs::path beside = fs::path(named_in).parent_path() / name;  // `name` itself when absolute
  const fs::path beside_first = fs::path(first_file_).parent_path() / name;
  std::error_code ignored;
  for (const fs::path& path : {first_folder_first_ ? beside_first : beside, beside_first})
    if (fs::exists(path, ignored)) return path.string();
  if (std::string with_slashes = name; name.find('\\') != std::string::npos) {
    std::replace(with_slashes.begin(), with_slashes.end(), '\\', '/');
    return resolve(with_slashes, named_in);
  }
  return beside.string();
}

void SceneFiles::check_place(const std::string& path, const std::string& name, const Location& where) {
  const fs::path place = resolved(path);
  if (lies_below(place, folder_)) return;
  const std::string what = fmt::format("{} lies outside the folder of the scene", etendue::quote(name));
  if (confined_) throw Error(what + "; --confined allows only files below that folder");
  if (outside_.insert(place).second && outside_warnings_.size() < most_named)
    outside_warnings_.push_back(where.text() + ": " + what);
}

void SceneFiles::need_memory(std::uint64_t bytes, const std::string& name, const Location& where) {
  unchecked_bytes_ += bytes;
  if (unchecked_bytes_ < look_every_bytes) return;
  require_memory(static_cast<double>(bytes), where, etendue::quote(name), "a smaller file, or fewer of them");
  unchecked_bytes_ = 0;
}

SceneFiles::File SceneFiles::read(const std::string& name, const std::string& named_in, const Location& where) {
  try {
    const std::string path = resolve(name, named_in);
    check_place(path, name, where);
    std::string bytes = read_file(path);
    need_memory(bytes.size(), name);  // for what becomes of them
    return {path, std::move(bytes)};
  } catch (const Error& e) {
    throw Error(where, e.what());
  }
}

SceneFiles::File SceneFiles::include(const std::string& name, const std::string& named_in, const Location& where) {
  if (++includes_ > most_includes)
    throw Error(where, fmt::format("the scene includes more than {} files, each counted as often as it is included; does one "
                                   "include another many times?",
                                   most_includes));
  File file = read(name, named_in, where);
  included_bytes_ += file.bytes.size();
  if (included_bytes_ > most_included_bytes)
    throw Error(where,
                fmt::format("the scene includes more than {} MiB, each file counted as often as it is included; expected "
                            "large meshes as .ply",
                            most_included_bytes >> 20));
  return file;
}

RgbImage SceneFiles::image(const std::string& name, const std::string& named_in, const Location& where, Encoding encoding) {
  const File file = read(name, named_in, where);
  try {
    RgbImage image = decode_image(file.bytes, file.path, encoding);
    need_memory(image.texels.size() * sizeof(Rgb), name);
    return image;
  } catch (const Error& e) {
    throw Error(where, e.what());
  }
}

void SceneFiles::warn(const Location& where, const std::string& what) {
  constexpr std::size_t most = 1000;
  if (const auto found = told_index_.find(what); found != told_index_.end()) {
    ++told_[found->second].count;
  } else if (told_.size() == most) {
    ++untold_;
  } else {
    told_index_.emplace(what, told_.size());
    told_.push_back({where.text() + ": " + what});
  }
}

std::vector<std::string> SceneFiles::warnings() const {
  std::vector<std::string> warnings;
  for (const Told& told : told_)
    warnings.push_back(told.count > 1 ? fmt::format("{} ({} times in all)", told.text, told.count) : told.text);
  if (untold_ > 0) warnings.push_back(fmt::format("{}: {} more warnings of what the files hold", first_file_, untold_));
  for (const std::string& approximation : approximations_.warnings()) warnings.push_back(approximation);
  warnings.insert(warnings.end(), outside_warnings_.begin(), outside_warnings_.end());
  if (outside_.size() > outside_warnings_.size())
    warnings.push_back(fmt::format("{}: {} more files lie outside the folder of the scene", first_file_,
                                   outside_.size() - outside_warnings_.size()));
  return warnings;
}

}  // namespace etendue
