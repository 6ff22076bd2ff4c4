// The partial sums from which vertex connection and merging computes the weights of its strategies ([Georgiev2012b]).
//
// A path of k scattering events can be sampled in many ways: the camera's part meets the light by itself (hit), or is joined to
// a point of the light (next event), or to a vertex of the light's part (connection); the light's part is joined to the lens
// (splat); or the ends of both parts fall within a radius r of each other (merge). By the balance heuristic ([Veach1995]) each
// sample is weighted by n_i p_i / sum n_j p_j. The sum over all ways to sample the same path is kept along both parts in three
// numbers a vertex, so that a weight costs the same however long the path is.
//
// Every density is per area where it belongs to a vertex ("area") and per solid angle where it belongs to a direction.
// Roulette is left out of the densities: survival depends on the throughput, and weights that all ignore it still sum to one.
//
// Delta lobes are where this deviates. The report takes their forward and reverse probabilities for equal; for refraction the
// densities of the two directions differ by the solid angles they fill, which is accounted for here (scatter_specular).
#pragma once

#include "framework/core/vec.h"

#include <algorithm>

namespace etendue {

struct MisPartials {
  // After `arrive`, at a vertex v with the vertex u before it: the strategies that end in the edge between the two, those that
  // connect an edge further back, and those that merge further back, each over the density that led here.
  float vcm = 0, vc = 0, vm = 0;

  // At a light: emission is LightSampler::emission_pdf, `direct` the density of finding the light from the first vertex.
  // `geometry`: cos at an area light, 1 at others and at infinity; for `direct` times distance^2 at lights that are a point.
  // [Georgiev2012b] eq. 31-33, without the first vertex's cosine. A delta light cannot be hit.
  static MisPartials at_light(float emission, float direct, float cos_light, float point_distance_squared, bool delta,
                              float connect) {
    const float vc = delta ? 0 : cos_light / emission;
    return {direct * cos_light * point_distance_squared / emission, vc, vc * connect};
  }
  // At the lens: the only other strategy there is the splat, tried by each of the light paths. [Georgiev2012b] eq. 31-33.
  static MisPartials at_camera(float light_paths, float pdf_camera) { return {light_paths / pdf_camera, 0, 0}; }

  // Goes to the next vertex: from solid angle there to area here. The first vertex of a light path takes no distance: at_light
  // has it.
  void arrive(float distance_squared, float cos_in) {
    cos_in = std::max(cos_in, 1e-7f);  // 0 where a ray grazes the surface: absent strategies would give 0 / 0
    vcm *= distance_squared / cos_in;
    vc /= cos_in;
    vm /= cos_in;
  }
  // Through a lobe with a density, where a merge could have been made. `merge` = n pi r^2, `connect` its inverse, each 0 where
  // there is no such strategy. [Georgiev2012b] eq. 34-36.
  void scatter(float merge, float connect, float cos_out, float pdf_forward, float pdf_reverse) {
    const float g = cos_out / pdf_forward;
    vc = g * (vc * pdf_reverse + vcm + merge);
    vm = g * (vm * pdf_reverse + vcm * connect + 1);
    vcm = 1 / pdf_forward;
  }
  // Through a delta lobe, where nothing can be joined. `stretch`: solid angle leaving per solid angle arriving.
  // [Georgiev2012b] eq. 53-55.
  void scatter_specular(float cos_out, float stretch) {
    vcm = 0;
    vc *= cos_out * stretch;
    vm *= cos_out * stretch;
  }

  // The rest of a part that another strategy joins to at this vertex, its reverse density there given. [Georgiev2012b] eq. 40,
  // 41, 44-46 (the factor of the joining edge aside).
  float connected(float merge, float pdf_reverse) const { return merge + vcm + vc * pdf_reverse; }
  // [Georgiev2012b] eq. 38, 39.
  float merged(float connect, float pdf_other) const { return vcm * connect + vm * pdf_other; }
};

// [Georgiev2012b] eq. 37: of a strategy, given the sums of the others over its own density.
inline float mis_balance(float light_side, float camera_side) { return 1 / (light_side + 1 + camera_side); }

}  // namespace etendue
