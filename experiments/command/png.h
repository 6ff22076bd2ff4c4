// Previews: linear radiance to 8-bit sRGB.
#pragma once

#include "framework/image/film.h"

#include <string>

namespace etendue {

// Clamped to [0, 1], then the sRGB curve; no exposure. Written beside its final name and renamed when complete. Throws Error.
void write_png(const std::string& path, const Image& image);

}  // namespace etendue
