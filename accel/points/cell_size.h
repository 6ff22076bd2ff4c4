// How large the cells of a grid over points should be.
#pragma once

#include "accel/points/neighbourhood.h"

namespace etendue {

// The edge, at least `smallest`, at which cells that are not empty hold `points_per_cell` points on average. Points are taken
// to lie on surfaces, where that number grows as the edge squared. `bounds`: of the finite points, at least one.
float cell_size_for(std::span<const vec3> points, const Bounds& bounds, float points_per_cell, float smallest);

}  // namespace etendue
