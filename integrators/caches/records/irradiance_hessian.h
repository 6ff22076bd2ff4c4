// Second derivatives of irradiance over the tangent plane, from one stratified hemisphere of samples: what error metrics of
// second order judge by ([Jarosz2012], [Schwarzhaupt2012]).
//
//   radiometric  what is seen is patches fixed in space, each visible wherever the point moves ([Jarosz2012]): the Hessian of
//                sum L_j F_j. Occlusion is unknown to it; an edge seen from the side makes it diverge as 1 / cos.
//   geometric    the same patches, all of unit radiance, their Hessians' absolute values summed ([Jarosz2012]): a bound that
//                trusts no radiance, so that it holds where surroundings are black.
//   occlusion    the samples are vertices of a mesh around the point, each triangle as bright as its farthest vertex
//                ([Schwarzhaupt2012]): what bridges the step from an occluder to what lies behind is as bright as what it will
//                uncover. The mesh's irradiance is a sum over its edges (Lambert's formula), differentiated in closed form.
//                It stays where it is as the point moves, so the sliding of a curved occluder's silhouette is unknown to it.
//
// Closed forms here: an edge from a to b (seen from the point) adds phi q / 2 times the difference of its two triangles, with
// q = (a x b) . n and phi = angle / |a x b| = integral of dt / r^2 along the edge, so that its derivatives are integrals of
// powers of 1 / r, which the substitution of the angle makes elementary.
//
// The mesh of polar strata is closed at the zenith by a vertex at the inner ring's mean distance and at the horizon by a ring
// of vertices at the outer ring's distances. What is seen at infinity is put far away.
#pragma once

#include "integrators/caches/records/hemisphere.h"

namespace etendue {

// Luminance of radiance counts.
TangentMatrix radiometric_hessian(const HemisphereStrata& strata, std::span<const HemisphereSample> samples,
                                  const Frame& frame);
// Per unit of radiance: to be compared with an irradiance of pi.
TangentMatrix geometric_hessian(const HemisphereStrata& strata, std::span<const HemisphereSample> samples, const Frame& frame);

struct MeshDerivatives {
  Rgb irradiance{0};      // of the mesh: a check on it, biased by its triangulation
  mat3 translation{0};    // as in IrradianceEstimate
  TangentMatrix hessian;  // of the luminance
};
MeshDerivatives occlusion_derivatives(const HemisphereStrata& strata, std::span<const HemisphereSample> samples,
                                      const Frame& frame);

// phi q and its derivatives as the point moves over the tangent plane (x, y), for an edge from a to b, in the point's frame.
struct EdgeDerivatives {
  double value, x, y;
  TangentMatrix hessian;
};
EdgeDerivatives edge_derivatives(const dvec3& a, const dvec3& b);

// Eigenvalues by falling absolute value, and the unit eigenvector of the first; of the second it is (-y, x).
struct TangentEigen {
  double first, second;
  dvec2 axis;
};
TangentEigen eigen(const TangentMatrix& m);
// Has eigenvalue `a` along the unit vector u, and `b` across.
TangentMatrix tangent_matrix(double a, double b, const dvec2& u);

}  // namespace etendue
