// A method holds or fails by these figures of its image. Ratios are of a pixel's mean over channels to the reference's, over
// pixels in which the reference is at least a thousandth of its largest value (for `darkest`, nine tenths: the evenly lit
// ones).
#pragma once

#include "framework/core/error.h"
#include "framework/image/film.h"

#include <span>
#include <string>
#include <vector>

namespace etendue {

struct StructureHazard;  // structure_hazard.h

struct StressFigure {
  std::string name, text;
  double (*compute)(const Image& image, const Image& reference) = nullptr;
  double (*of_structure)(const StructureHazard& measured) = nullptr;  // one of the two
};

// The tail index of the noise of each image of a method, one a seed (statistics.h): of the brightest twentieth of its pixels,
// less the mean of the other seeds', over the reference's, and 1. What all seeds have in common, a bias, is not taken for a
// tail; of a single seed it cannot be told, and there is none. 0 where fewer than one pixel in twenty has a thousandth of its
// light.
std::vector<double> image_tails(const std::vector<Image>& images, const Image& reference);

std::span<const StressFigure> stress_figures();
const StressFigure& find_stress_figure(const std::string& name, const Location& where);  // throws Error

}  // namespace etendue
