// How large the cells of a grid over points should be.
#pragma once

#include "accel/point/neighbourhood.h"

namespace etendue {

// The edge at which a cell that holds any point holds about `points_per_cell` on the mean, at least `smallest`. Points are
// taken to lie on surfaces, where that number grows as the edge squared. `bounds`: of the finite points, at least one.
float cell_size_for(std::span<const vec3> points, const Bounds& bounds, float points_per_cell, float smallest);

}  // namespace etendue
