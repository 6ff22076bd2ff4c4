// Tells which surfaces that lie in one place are lit one beside the other.
//
// Where opaque surfaces lie one above the other the upper one has the light, and what lands within a kernel's radius counts for
// both. Where a mask lets a part of the light through (Shape::mask), the sheet and what lies beneath are lit both, and to take
// the photons of one for those of the other would count light twice. So such a place of a sheet is a layer by itself: light on
// it counts for its own shape alone. Where a mask stops all light or none, its shape is a surface like others, lest the borders
// of leaves and holes lose light.
#pragma once

#include <cstdint>

namespace etendue {

// 0 where there is no mask; else a number of the shape, and whether the place lets light through. Five bits.
using Layer = std::uint8_t;
inline constexpr Layer layer_shapes = 15;  // shapes of more than that share numbers
inline constexpr Layer layer_lets_light_through = 16;
inline constexpr float opaque_from = 0.98f;  // a mask that stops so much is taken for opaque

constexpr bool lets_light_through(int layer) { return (layer & layer_lets_light_through) != 0; }
// Does light on one count for the other, where they are near each other?
constexpr bool share_light(Layer a, Layer b) { return ((a ^ b) & layer_shapes) == 0 || !lets_light_through(a | b); }

}  // namespace etendue
