// The records of a cache, drawn over the dimmed picture they were made for: the rim of the disc, ellipse or cube in which
// each serves, and its centre, but a cube's. Colour tells the radius (the longer semi-axis, half the edge): red the smallest,
// over yellow and green to blue, the largest, by equal steps of its logarithm between the 5th and the 95th of a hundred
// records.
//
// A pixel shows the records that cover the very point its centre sees, on surfaces that face as their records do; so records
// that something hides do not show. Seen in mirrors and through glass they are not drawn.
#pragma once

#include "framework/integrator.h"

#include <span>

namespace etendue {

// `image` has the context's resolution.
Image draw_records(const Image& image, const RenderContext& context, std::span<const RecordShape> records);

}  // namespace etendue
