#include "integrators/caches/records/spherical_harmonics.h"

#include "framework/core/check.h"

#include <array>

namespace etendue {

namespace {

// Factors of the recurrences of normalised associated Legendre functions: P_lm = a (z P_(l-1)m - b P_(l-2)m).
struct Factors {
  std::array<float, highest_sh_order * highest_sh_order> a{}, b{};
  std::array<float, highest_sh_order> diagonal{};  // P_mm over sin^m

  Factors() {
    double product = std::sqrt(0.25 / std::numbers::pi);
    for (int m = 0; m < highest_sh_order; ++m) {
      if (m > 0) product *= std::sqrt((2.0 * m + 1) / (2.0 * m));
      diagonal[m] = static_cast<float>(product);
      for (int l = m + 1; l < highest_sh_order; ++l) {
        const double l2 = l * l, m2 = m * m, below = (l - 1.0) * (l - 1.0);
        a[l * highest_sh_order + m] = static_cast<float>(std::sqrt((4 * l2 - 1) / (l2 - m2)));
        b[l * highest_sh_order + m] = static_cast<float>(std::sqrt((below - m2) / (4 * below - 1)));
      }
    }
  }
};

}  // namespace

void evaluate_sh(int order, const vec3& direction, std::span<float> values) {
  static const Factors factors;
  DCHECK(static_cast<int>(values.size()) >= order * order && order <= highest_sh_order);
  // sin^m(theta) times cos(m phi) and sin(m phi).
  float cosine = 1, sine = 0;
  for (int m = 0; m < order; ++m) {
    const float scale = m == 0 ? 1 : std::numbers::sqrt2_v<float>;
    float before = 0, here = factors.diagonal[m];
    for (int l = m; l < order; ++l) {
      if (l > m) {
        const std::size_t i = static_cast<std::size_t>(l) * highest_sh_order + m;
        const float next = factors.a[i] * (direction.z * here - (l > m + 1 ? factors.b[i] * before : 0));
        before = here;
        here = next;
      }
      values[sh_index(l, m)] = scale * here * cosine;
      if (m > 0) values[sh_index(l, -m)] = scale * here * sine;
    }
    const float next = direction.x * cosine - direction.y * sine;
    sine = direction.x * sine + direction.y * cosine;
    cosine = next;
  }
}

float cosine_convolution(int l) {
  if (l == 0) return pi;
  if (l == 1) return 2 * pi / 3;
  if (l % 2 != 0) return 0;
  // l! / (2^l (l/2)!^2), a product of (2k - 1) / (2k).
  double binomial = 1;
  for (int k = 1; k <= l / 2; ++k) binomial *= (2.0 * k - 1) / (2.0 * k);
  const double sign = l / 2 % 2 == 1 ? 1 : -1;
  return static_cast<float>(sign * 2 * std::numbers::pi / ((l + 2.0) * (l - 1.0)) * binomial);
}

}  // namespace etendue
