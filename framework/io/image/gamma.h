// Images whose integers are not encoded as sRGB.
#pragma once

#include "framework/io/image/image_file.h"

#include <string_view>

namespace etendue {

// Is it an image that stores floats (HDR, PFM, EXR), told by its content?
bool holds_floats(std::string_view bytes);
// Is it a PNG file of colours with an alpha channel, or an EXR file, which may have one?
bool may_have_alpha(std::string_view bytes);
// The exponent by which a PNG says that it encodes colours, 1 where it holds light as it is; 0: it says nothing, or sRGB.
float stated_gamma(std::string_view bytes);

// Turns values that stand as they are in the file (Encoding::linear) into those that they encode by this exponent; 0: as sRGB.
void decode_gamma(RgbImage& image, float gamma);

}  // namespace etendue
