// Radiance pictures (.hdr): RGBE, run-length encoded or flat. Read here, as this stb never returns from a truncated one.
#pragma once

#include "framework/io/image_file.h"

#include <string_view>

namespace etendue {

bool is_hdr(std::string_view bytes);
// Linear as it stands; EXPOSURE lines are not applied. Throws Error without the file's name.
RgbImage decode_hdr(std::string_view bytes);

}  // namespace etendue
