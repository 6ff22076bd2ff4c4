// The types of pbrt's directives that are read, each with how. The reader takes no type that does not stand here, and
// docs/scene-files.md has a row for each, which a test holds against this.
#pragma once

#include "framework/core/error.h"

#include <span>
#include <string>
#include <string_view>

namespace etendue {

struct PbrtSupport {
  std::string_view directive, type, how;
};
std::span<const PbrtSupport> pbrt_support();

// Throws Error at `where`, with the nearest names, unless there is such a row. `kind` is what the message calls it.
void require_known(std::string_view directive, std::string_view kind, const std::string& type, const Location& where);

}  // namespace etendue
