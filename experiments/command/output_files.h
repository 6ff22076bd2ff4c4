// The files that a command writes: checked before its work, each replaced in one step after it.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace etendue {

struct OutputFile {
  std::string option;  // that names it, such as "-o"
  std::string path;
};

// Can each be written, and is each another file? Leaves nothing behind and touches no file that exists. Throws Error naming
// the option.
void check_outputs(const std::vector<OutputFile>& outputs);

// `write` fills the file whose path it is given, beside the final one, which it then replaces; of a symbolic link, what it
// leads to. Throws Error, with the old file as it was.
void replace_file(const std::string& path, const std::function<void(const std::string& partial)>& write);

}  // namespace etendue
