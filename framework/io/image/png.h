// Previews: linear radiance to 8-bit sRGB.
#pragma once

#include "framework/image/film.h"
#include "framework/io/whole_file.h"

#include <string>

namespace etendue {

// Linear [0, 1], clamped, to the sRGB curve (IEC 61966-2-1) in 8 bits; NaN gives 0.
std::uint8_t linear_to_srgb_byte(double linear);

// The image is not exposed. Throws WriteError, with an older file as it was.
FileStamp write_png(const std::string& path, const Image& image);

}  // namespace etendue
