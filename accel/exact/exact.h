// Intersection in double precision over a whole scene: decides whether the answers of structures, and of brute force, are
// right.
//
// Triangles are tested by the signs of three volumes, one per edge: an edge shared by two triangles gets exactly opposite
// values in them, so no ray slips through between. Instances are inverted in double from their matrix.
#pragma once

#include "accel/bvh/build/binary_tree.h"
#include "framework/scene/scene.h"

#include <optional>
#include <vector>

namespace etendue {

struct ExactRay;

struct ExactHit {
  double t;
  std::uint32_t instance, primitive;
  double cos_surface;  // |cos| between the ray and the surface's normal, in world space
};

// The nearest surface with t in (t_min, t_max], by brute force.
std::optional<ExactHit> exact_closest(const Scene& scene, const Ray& ray);

// Is `answer` an acceptable result in single precision for this ray, where `exact` is its exact_closest?
//
//   - A miss is right if there is no exact hit.
//   - A hit is right if its point lies on the primitive it names, give or take rounding, and nothing is met clearly before it.
//     Rounding is 1e-5 of the largest length involved; what is met before counts along its normal (a grazing ray moves far
//     along the surface for a small error across it).
bool is_right(const Scene& scene, const Ray& ray, const Hit& answer, const std::optional<ExactHit>& exact);

// The same of an answer to "is anything hit?": right if it holds for the ray with its end moved by 1e-4, to either side.
bool is_right(const Scene& scene, const Ray& ray, bool occluded);

// The same by trees of boxes met in double precision, fast enough to judge every answer.
//
// Near the outline of a surface, single precision may find either what the outline borders or what lies behind it; inside, and
// so at every edge and vertex that triangles share, it may not. `is_right` tells the two apart by asking about rays and meshes
// moved by rounding: an answer is right if it is right, as above, of
//
//   - the ray, or one of ten whose origins lie 2^-20 of the distance to the scene's far end away from its own;
//   - the ray in one of 512 meshes whose vertices lie up to that distance away from their own along each axis, a vertex at the
//     same place for all triangles that have it. The watertight test is exact but for rounding each vertex so, and thus closes
//     the edges whose ends two triangles share. Where a vertex of one stands on another's edge, or ends of two differ by a
//     rounding, the mesh has a crack as wide as rounding itself, which no test in single precision can close.
//
// A ray that leaked through a closed surface is wrong for all of them, as moved vertices leave it closed.
class ExactTracer {
 public:
  // `scene` must outlive it.
  explicit ExactTracer(const Scene& scene);

  std::optional<ExactHit> closest(const Ray& ray) const;
  // `exact`: what closest(ray) gave.
  bool is_right(const Ray& ray, const Hit& answer, const std::optional<ExactHit>& exact) const;
  bool is_right(const Ray& ray, bool occluded, const std::optional<ExactHit>& exact) const;

 private:
  std::optional<ExactHit> closest(const ExactRay& ray) const;
  double reach(const ExactRay& ray) const;
  template <class Holds>
  bool any_moved(const ExactRay& ray, const std::optional<ExactHit>& exact, const Holds& holds) const;
  bool may_slip(const ExactRay& ray, const ExactHit& hit, double distance) const;

  const Scene& scene_;
  Bounds bounds_;
  std::vector<BinaryTree> bottoms_;  // by object
  BinaryTree top_;                   // over the instances
};

}  // namespace etendue
