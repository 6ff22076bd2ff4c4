// Sums over values at places in a plane, and the linear function that fits the values best.
//
// A cell of a grid (path_space_grid.h) keeps these sums instead of its values. Places are coordinates in the cell's tangent
// plane, relative to the centre of the cell and in units of its edge. Sums of several cells add, once they are about the same
// centre, so a cell can be merged into one of twice its edge without its values.
//
// The fit is by least squares, as in local linear regression ([Fan1993]), with a ridge: 16 values of no slope at a distance of
// one edge, so that a few values answer with little more than their mean. [Binder2018] answers with the mean alone, which is
// wrong in the first order of the cell's size where all values lie on one side of the point that asks.
#pragma once

#include "framework/core/vec.h"

namespace etendue {

struct PlaneMoments {
  float count = 0;            // sum of the values' weights
  float squared_weights = 0;  // sum of these weights' squares
  vec2 place{0};
  vec3 place_square{0};                  // xx, yy, xy
  Rgb value{0}, value_x{0}, value_y{0};  // value, and value times each coordinate of its place
  float square = 0;                      // of the value's luminance

  static PlaneMoments of(const vec2& place, const Rgb& value);
  PlaneMoments& operator+=(const PlaneMoments& other);
  PlaneMoments& operator*=(float weight);  // of all values, beside what they weigh already
  // The same values in a cell of twice the edge, in whose coordinates this cell's centre lies at `centre`.
  PlaneMoments in_coarser(const vec2& centre) const;
  // The fitted value at `at`. `reach`: how far the cell extends from its centre along the axes of the plane.
  Rgb fit(const vec2& at, const vec2& reach) const;
  // So many values of equal weight would have a mean of the same variance.
  float effective_count() const { return count * (count / squared_weights); }
  float variance() const;  // of the values' luminance, each alone
  // Whether values could have these sums: to be checked where they come from a file.
  bool is_valid() const;
};

}  // namespace etendue
