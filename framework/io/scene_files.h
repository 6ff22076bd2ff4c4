// The files that the file of a scene names: where they may lie, and how much may be read of them.
//
// A scene from elsewhere is not trusted: it must neither read what lies beside it on the disk unnoticed, nor take a reader's
// time or memory without end. So all that it names is read here.
//
//   place    a file outside the folder of the scene and the folders below it, symbolic links resolved, is told in a warning;
//            where the scene is confined, it is an error
//   includes 10,000 files and 1 GiB in all, each counted as often as it is included, at most 32 deep
//   memory   what is read, and the texels it becomes, must fit into the memory that is free
#pragma once

#include "framework/core/error.h"
#include "framework/io/approximations.h"
#include "framework/io/image/image_file.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace etendue {

struct SceneReading {
  bool confined = false;          // a file outside the scene's folder is an error
  std::string pixel_filter = {};  // by name, in the place of the scene's; empty: that one
  bool approximate = false;       // what has no exact equal here is approximated and told (approximations.h), not an error
};

// Every function throws Error, at the place that is given, where a file cannot be read.
class SceneFiles {
 public:
  static constexpr int most_nested_includes = 32;
  static constexpr std::uint64_t most_includes = 10'000, most_included_bytes = std::uint64_t{1} << 30;

  // `first_folder_first`: names are relative to the first file's folder, else to that of the file they stand in, not the other
  // way round.
  SceneFiles(std::string first_file, const SceneReading& reading, bool first_folder_first = false);

  const std::string& first_file() const { return first_file_; }

  struct File {
    std::string path;  // as messages name it
    std::string bytes;
  };
  // `name`: relative to the folder of the file `named_in` or of the first file.
  File read(const std::string& name, const std::string& named_in, const Location& where);
  File include(const std::string& name, const std::string& named_in, const Location& where);
  RgbImage image(const std::string& name, const std::string& named_in, const Location& where,
                 Encoding encoding = Encoding::srgb);

  // Throws Error where there is no room for so much of what a scene makes of `name`.
  void need_memory(std::uint64_t bytes, const std::string& name, const Location& where = {});

  Approximations& approximations() { return approximations_; }
  // Adds to the scene's warnings. What is told more than once is counted.
  void warn(const Location& where, const std::string& what);

  // What was approximated and told. Then the first ten files outside the scene's folder, and how many more there are.
  std::vector<std::string> warnings() const;

 private:
  std::string resolve(const std::string& name, const std::string& named_in) const;
  void check_place(const std::string& path, const std::string& name, const Location& where);

  std::string first_file_;
  bool confined_, first_folder_first_;
  Approximations approximations_;
  struct Told {
    std::string text;
    std::uint64_t count = 1;
  };
  std::vector<Told> told_;
  std::map<std::string, std::size_t, std::less<>> told_index_;  // by what is told, wherever it is
  std::uint64_t untold_ = 0;                                    // different ones beyond the first thousand
  std::filesystem::path folder_;                                // of the first file, symbolic links resolved
  std::set<std::filesystem::path> outside_;
  std::vector<std::string> outside_warnings_;
  std::uint64_t includes_ = 0, included_bytes_ = 0;
  std::uint64_t unchecked_bytes_ = 0;  // taken since the free memory was looked at
};

}  // namespace etendue
