// Portable float maps (.pfm): "PF" for RGB or "Pf" for grey, size, a scale, by whose magnitude values are multiplied and whose
// sign tells the byte order, then rows from the bottom.
#pragma once

#include "framework/io/image/image_file.h"

#include <string_view>

namespace etendue {

bool is_pfm(std::string_view bytes);
// Linear as it stands. Throws Error without the file's name.
RgbImage decode_pfm(std::string_view bytes);

}  // namespace etendue
