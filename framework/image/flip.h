// FLIP: how large the difference of two images looks to somebody who flips between them ([Andersson2020]), and over all
// exposures under which they may be shown ([Andersson2021]).
//
// An observer sees 67 pixels to a degree: a screen 0.7 m and 3840 pixels wide, 0.7 m away. Both images go through the
// contrast sensitivity of the eye; what is left of their colours is compared in Hunt-adjusted L*a*b* by the HyAB distance, and
// where one image has an edge or a point that the other lacks, the error grows. A pixel's error lies within [0, 1]; 0 only
// where nothing differs.
//
// Deviations: negative radiance counts as black in the choice of exposures, too. Where the median luminance is 0, that of the
// luminances above 0 takes its place, and there are 64 exposures at most. Filters are separable, which changes no value.
#pragma once

#include "framework/image/film.h"

#include <vector>

namespace etendue {

// Gives each pixel's HDR-FLIP: the largest LDR-FLIP of the exposures that suit the reference. Both images are linear RGB of
// one size (CHECK). Throws Error where a pixel is not finite.
std::vector<double> flip_errors(const Image& image, const Image& reference);

// Gives each pixel's LDR-FLIP of two images in linear RGB as a screen shows them, clamped to [0, 1]. Throws likewise.
std::vector<double> ldr_flip_errors(const Image& image, const Image& reference);

// The exposures of HDR-FLIP in stops, evenly from the one that maps the reference's highest luminance to 0.85 of white to the
// one that maps its median there; a black reference has the exposure 0.
std::vector<double> flip_exposures(const Image& reference);

// The tone map of HDR-FLIP: the fit to ACES of [Narkowicz2016] without its own exposure, within [0, 1].
double flip_tone_map(double value);

}  // namespace etendue
