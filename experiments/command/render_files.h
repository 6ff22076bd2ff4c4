// The files that `etendue render` writes, checked before its work, and the caches that it reads.
#pragma once

#include "experiments/config/method.h"

#include <string>
#include <string_view>
#include <vector>

namespace etendue {

struct OutputFile {
  std::string option;  // that names it, such as "-o"
  std::string path;
};

// Can each be written, and is each another file? Leaves nothing behind and touches no file that exists. Throws Error naming
// the option.
void check_outputs(const std::vector<OutputFile>& outputs);

// Throws Error where it cannot be read, or does not begin as a cache does.
std::string read_cache_bytes(const std::string& path);

// The integrator that a cache was made by, where none is named ("" in `integrator`), and each of its parameters that is not
// given. Throws Error where the file is not a whole cache, or of another integrator.
void complete_from_cache(std::string_view bytes, const std::string& path, Method& integrator);

// Throw Error, with the names of those that do, where an integrator keeps no cache that can be saved, or none at all, of which
// it then `lacks` the records or an error of its own.
void require_savable(const Method& integrator, const std::string& option);
void require_cache(const Method& integrator, const std::string& option, const char* lacks);

}  // namespace etendue
