// Sets of points and records as renderers have them, with the places of their queries.
#pragma once

#include "framework/scene/scene.h"

#include <cstdint>
#include <vector>

namespace etendue {

struct PointSet {
  std::vector<vec3> points;   // along a space-filling curve, as integrators keep them
  std::vector<vec3> queries;  // in tiles of an image, as integrators ask
};

// Photons of a scene, traced as photon mapping traces them; asked for where the camera sees surfaces. Throws Error where no
// photon lands.
PointSet photons_of_scene(const Scene& scene, std::uint64_t count, std::uint64_t queries, std::uint64_t seed);

// Two unit squares at a right angle that hold half of the points evenly, and the others on a square spot in one of them, which
// add `contrast` times that density; at 1 all are even. One half of the tiles of queries lies on the spot.
PointSet clustered_points(double contrast, std::uint64_t count, std::uint64_t queries, std::uint64_t seed);

struct RecordSet {
  std::vector<vec3> centres;
  std::vector<float> radii;
  std::vector<vec3> queries;
};

// A set of records where a camera sees surfaces. Their radii have evenly distributed logarithms between r and r * spread, such
// that `covering` records cover a query on the mean. Throws Error where the camera sees nothing.
RecordSet records_of_scene(const Scene& scene, double spread, double covering, std::uint64_t count, std::uint64_t queries,
                           std::uint64_t seed);

}  // namespace etendue
