// Brute force in double precision over a whole scene: the arbiter where two structures disagree, and the oracle's oracle.
//
// Triangles are tested by the signs of three volumes, one per edge: an edge shared by two triangles gets exactly opposite
// values in them, so no ray slips through between. Instances are inverted in double from their matrix.
#pragma once

#include "framework/scene/scene.h"

#include <optional>

namespace etendue {

struct ExactHit {
  double t;
  std::uint32_t instance, primitive;
  double cos_surface;  // |cos| between the ray and the surface's normal, in world space
};

// The nearest surface with t in (t_min, t_max].
std::optional<ExactHit> exact_closest(const Scene& scene, const Ray& ray);

// Is `answer` what a structure working in single precision may say of this ray, `exact` being exact_closest of it?
//
//   - A miss is right if there is no exact hit.
//   - A hit is right if its primitive is met at that distance, give or take rounding, and nothing is met clearly before it.
//     Rounding is 1e-5 of the largest length involved, measured along the surface's normal (a grazing ray moves far along the
//     surface for a small error across it), and at a primitive's rim 1e-4 of a triangle, 1e-5 of a quadric.
bool is_right(const Scene& scene, const Ray& ray, const Hit& answer, const std::optional<ExactHit>& exact);

// The same of an answer to "is anything hit?": right if it holds for the ray with its end moved by 1e-4, to either side.
bool is_right(const Scene& scene, const Ray& ray, bool occluded);

}  // namespace etendue
