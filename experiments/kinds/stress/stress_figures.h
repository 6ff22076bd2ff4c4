// These figures are measured of an image where a method fails. Ratios are of a pixel's mean over channels to the reference's,
// over pixels in which the reference is at least a thousandth of its largest value (for `darkest`, nine tenths: the evenly lit
// ones).
#pragma once

#include "framework/core/error.h"
#include "framework/image/film.h"

#include <span>
#include <string>

namespace etendue {

struct StructureHazard;  // structure_hazard.h

struct StressFigure {
  std::string name, text;
  double (*compute)(const Image& image, const Image& reference) = nullptr;
  double (*of_structure)(const StructureHazard& measured) = nullptr;  // one of the two
};

std::span<const StressFigure> stress_figures();
const StressFigure& find_stress_figure(const std::string& name, const Location& where);  // throws Error

}  // namespace etendue
