// Real spherical harmonics, orthonormal over the sphere, without the Condon-Shortley sign ([Sloan2008]).
//
// Harmonic (l, m) stands at index l (l + 1) + m. An order n has the n^2 harmonics of l < n.
#pragma once

#include "framework/core/vec.h"

#include <span>

namespace etendue {

inline constexpr int highest_sh_order = 16;

inline constexpr int sh_index(int l, int m) { return l * (l + 1) + m; }

// All harmonics of the order at a unit direction; `values` has order^2 elements.
void evaluate_sh(int order, const vec3& direction, std::span<float> values);

// The factor of all (l, m) in the convolution with the clamped cosine ([Ramamoorthi2001] eq. 19-22): the irradiance about n is
// the sum of A_l lambda_lm Y_lm(n).
float cosine_convolution(int l);

}  // namespace etendue
