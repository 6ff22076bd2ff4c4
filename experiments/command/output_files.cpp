#include "experiments/command/output_files.h"

#include "framework/io/whole_file.h"

#include <fmt/format.h>

#include <map>

namespace etendue {

void check_outputs(const std::vector<OutputFile>& outputs) {
  std::map<std::string, std::string> options;
  for (const auto& [option, path] : outputs) {
    const Location where{option + " " + path};
    const std::string target = check_writable(path, where);
    if (const auto [other, is_new] = options.emplace(target, option); !is_new)
      throw Error(where, fmt::format("the same file as that of {}; expected another", other->second));
  }
}

}  // namespace etendue
