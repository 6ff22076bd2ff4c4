// Pixels as the page's viewer reads them (pixels.js): half-floats, which keep noise as it is at 11 significant bits.
#pragma once

#include "framework/core/vec.h"

#include <string>
#include <vector>

namespace etendue {

// The half-float nearest to `value` / `unit`, times `unit`; what is too large for one is the largest (65504 units).
double rounded_to_half(double value, double unit);

// Makes `size.x` x `size.y` pixels, in rows from the top, the text that decodeHalves reads: three planes of half-floats in
// units of `unit`, each row as differences of its neighbours' bits, all high bytes before all low ones, deflated (zlib), in
// base64.
std::string encode_halves(const std::vector<dvec3>& pixels, ivec2 size, double unit);
// One plane of them, in units of 1.
std::string encode_halves(const std::vector<double>& values, ivec2 size);

}  // namespace etendue
