// The partial sums from which vertex connection and merging weighs its strategies ([Georgiev2012b]).
//
// A path of k scattering events can be sampled in many ways: the camera's part meets the light by itself (hit), or is joined to
// a point of the light (next event), or to a vertex of the light's part (connection); the light's part is joined to the lens
// (splat); or the ends of both parts fall within a radius r of each other (merge). By the balance heuristic ([Veach1995]) each
// sample is weighed by n_i p_i / sum n_j p_j, by the power heuristic by the squares of the same. The sum over all ways to
// sample the same path is kept along both parts in three numbers a vertex, so that a weight costs the same however long the
// path is.
//
// Every density is per area where it belongs to a vertex ("area") and per solid angle where it belongs to a direction.
// Roulette is left out of the densities: survival depends on the throughput, and weights that all ignore it still sum to one.
//
// Deviation: delta lobes. The report takes their forward and reverse probabilities for equal; for refraction the densities of
// the two directions differ by the solid angles they fill, which is accounted for here (scatter_specular).
#pragma once

#include "framework/core/vec.h"

namespace etendue {

// Direct light, of one scattering event: next events and hits draw evenly spread points and have less variance than their
// densities tell, while splats and merges are particles that fall at random. The latter count for this share of their number,
// which keeps their noise out of direct light. The weights' sum stays one; where next events are hopeless and splats are not,
// the densities still decide. ([Grittmann2019] measures such factors for each technique and pixel.)
inline constexpr double direct_share = 0.01;

// How strategies are weighed against each other, and what the merges at a vertex weigh.
struct MisRule {
  bool power = false;  // the power heuristic (beta = 2); else the balance heuristic
  double merge = 0;    // n pi r^2 ([Georgiev2012b] eq. 20) and its inverse, under the heuristic; both 0 without merging
  double connect = 0;

  MisRule(bool squares, double merges) : power(squares), merge((*this)(merges)), connect(merges > 0 ? 1 / merge : 0) {}
  double operator()(double ratio) const { return power ? ratio * ratio : ratio; }
};

struct MisPartials {
  // After `arrive`, at a vertex v with the vertex u before it: the strategies that end in the edge between the two, those that
  // connect an edge further back, and those that merge further back, each over the density that led here. Under the power
  // heuristic all are squares, which leave a float's range.
  double vcm = 0, vc = 0, vm = 0;

  // At a light, [Georgiev2012b] eq. 31-33 without the first vertex's cosine. emission is LightSampler::emission_pdf; `direct`
  // the density with which the first vertex finds the light, for a light that is a point times the distance's square; cos_light
  // 1 but at area lights. A delta light cannot be hit.
  static MisPartials at_light(const MisRule& rule, double emission, double direct, double cos_light, bool delta) {
    const double vc = delta ? 0 : rule(cos_light / emission);
    return {rule(direct * cos_light / emission), vc, vc * rule.connect};
  }
  // At the lens: the only other strategy there is the splat, tried by each of the light paths. [Georgiev2012b] eq. 31-33.
  static MisPartials at_camera(const MisRule& rule, double light_paths, double pdf_camera) {
    return {rule(light_paths / pdf_camera), 0, 0};
  }

  // To the next vertex: from solid angle there to area here. The first vertex of a light path takes no distance: at_light has
  // it.
  void arrive(const MisRule& rule, double distance_squared, double cos_in) {
    vcm *= rule(distance_squared / cos_in);
    vc /= rule(cos_in);
    vm /= rule(cos_in);
  }
  // Through a lobe with a density, where a merge could have been made. [Georgiev2012b] eq. 34-36.
  void scatter(const MisRule& rule, double cos_out, double pdf_forward, double pdf_reverse) {
    const double g = rule(cos_out / pdf_forward), reverse = rule(pdf_reverse);
    vc = g * (vc * reverse + vcm + rule.merge);
    vm = g * (vm * reverse + vcm * rule.connect + 1);
    vcm = rule(1 / pdf_forward);
  }
  // Through a delta lobe, where nothing can be joined. `stretch`: solid angle leaving per solid angle arriving.
  // [Georgiev2012b] eq. 53-55.
  void scatter_specular(const MisRule& rule, double cos_out, double stretch) {
    vcm = 0;
    vc *= rule(cos_out * stretch);
    vm *= rule(cos_out * stretch);
  }

  // The other strategies of a part that ends at this vertex, over the density of a strategy that joins to it with density
  // `joining` per area; `reverse` is the density per solid angle, then, of the way back. [Georgiev2012b] eq. 40, 41, 44-46.
  double joined(const MisRule& rule, double joining, double reverse) const {
    return rule(joining) * (rule.merge + vcm + vc * rule(reverse));
  }
  // The same for a splat of the first vertex: next event and hit count for more (direct_share).
  double joined_directly(const MisRule& rule, double joining, double reverse) const {
    return rule(joining) * (rule.merge + (vcm + vc * rule(reverse)) / direct_share);
  }
  // Likewise for a merge at this vertex. [Georgiev2012b] eq. 38, 39.
  double merged(const MisRule& rule, double reverse) const { return vcm * rule.connect + vm * rule(reverse); }
};

// [Georgiev2012b] eq. 37: the weight of a strategy, given the sums of the others over its own density.
inline float mis_weight_of(double light_side, double camera_side) {
  return static_cast<float>(1 / (light_side + 1 + camera_side));
}

}  // namespace etendue
