// The files that a command writes, checked before its work.
#pragma once

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

}  // namespace etendue
