// Images beside a picture. Of a cache they show its records, and the error that it states of itself. What the camera sees first
// in each pixel serves denoisers, compositing and masks; it depends on the scene and the camera alone, so that it is the same
// whatever method rendered the picture. docs/using.md says what each shows, and with which units.
//
// Means are over 4 x 4 rays of the pixel, as denoisers want them; the others have none across an edge. Where a number is all
// that is shown, all channels have it. Among primitives of an object triangles come first, and infinite planes are their number,
// -2 and -2. Numbers above 2^24 are rounded, since the files hold single precision.
#pragma once

#include "framework/image/film.h"
#include "framework/integrator.h"

#include <span>
#include <string>
#include <vector>

namespace etendue {

inline const std::string records_aov = "records", standard_error_aov = "standard-error";
std::vector<std::string> aov_names();  // of all of them

bool is_surface_image(const std::string& name);
// `name` is one of those of surfaces (CHECK).
Image draw_surface_image(const std::string& name, const RenderContext& context);

// The records of a cache, drawn over the dimmed picture they were made for: the rim of the disc, ellipse or cube in which
// each serves, and its centre, but a cube's. Colour tells the radius (the longer semi-axis, half the edge): red the smallest,
// over yellow and green to blue, the largest, by equal steps of its logarithm between the 5th and the 95th of a hundred
// records.
//
// A pixel shows the records that cover the very point its centre sees, on surfaces that face as their records do; so records
// that something hides do not show. Seen in mirrors and through glass they are not drawn.
// `image` has the context's resolution.
Image draw_records(const Image& image, const RenderContext& context, std::span<const RecordShape> records);

}  // namespace etendue
