// Kernels of photon density estimation, all normalised: over the disc of radius r each integrates to one.
//
// The Gaussian is Jensen's filter ([Jensen2001], alpha = 0.918 and beta = 1.953) divided by its mean over the disc. As
// printed it integrates to 0.531, so that an image made with it is about half as bright as it should be.
#pragma once

#include "framework/core/elementary.h"

#include <array>

namespace etendue {

enum class Kernel : std::uint8_t { box, cone, epanechnikov, gaussian };

constexpr auto names_of(Kernel) { return std::array{"box", "cone", "epanechnikov", "gaussian"}; }

namespace detail {
inline constexpr float gaussian_beta = 1.953f;
inline constexpr float gaussian_end = 0.858152f;   // 1 - exp(-beta)
inline constexpr float gaussian_mean = 0.578600f;  // of 1 - (1 - exp(-beta x / 2)) / gaussian_end over x in [0, 1]
}  // namespace detail

// The kernel times pi r^2, at x = (distance / r)^2 in [0, 1]: its mean over x is one.
inline float kernel_shape(Kernel kernel, float x) {
  switch (kernel) {
    case Kernel::box:
      return 1;
    case Kernel::cone:
      return 3 * (1 - std::sqrt(x));
    case Kernel::epanechnikov:
      return 2 * (1 - x);
    case Kernel::gaussian:
      return (1 - (1 - math::exp(-0.5f * detail::gaussian_beta * x)) / detail::gaussian_end) / detail::gaussian_mean;
  }
  return 0;
}

// The part of the kernel's integral at distances up to r sqrt(x): the mean of kernel_shape over [0, x], times x.
inline float kernel_within(Kernel kernel, float x) {
  switch (kernel) {
    case Kernel::box:
      return x;
    case Kernel::cone:
      return x * (3 - 2 * std::sqrt(x));
    case Kernel::epanechnikov:
      return x * (2 - x);
    case Kernel::gaussian: {
      const float falling = x + 2 / detail::gaussian_beta * math::expm1(-0.5f * detail::gaussian_beta * x);
      return (x - falling / detail::gaussian_end) / detail::gaussian_mean;
    }
  }
  return 0;
}

}  // namespace etendue
