// Radiance pictures (.hdr): RGBE, run-length encoded or flat. Decoded here because the stb of Debian 12 never returns from a
// truncated file.
#pragma once

#include "framework/io/image/image_file.h"

#include <string_view>

namespace etendue {

bool is_hdr(std::string_view bytes);
// Linear as it stands; EXPOSURE lines are not applied. Throws Error without the file's name.
RgbImage decode_hdr(std::string_view bytes);

}  // namespace etendue
