// Caches on disk as `etendue render` reads and writes them.
#pragma once

#include "experiments/config/method.h"

#include <string>
#include <string_view>

namespace etendue {

// Throws Error where it cannot be read, or does not begin as a cache does.
std::string read_cache_bytes(const std::string& path);

// The integrator that a cache was made by, where none is named ("" in `integrator`), and each of its parameters that is not
// given. Throws Error where the file is not a whole cache, or of another integrator.
void complete_from_cache(std::string_view bytes, const std::string& path, Method& integrator);

// Throw Error, with the names of those that do, where an integrator keeps no cache, has no records to show, or knows no error
// of its own.
void require_savable(const Method& integrator, const std::string& option);
void require_records(const Method& integrator, const std::string& option);
void require_standard_error(const Method& integrator, const std::string& option);

}  // namespace etendue
