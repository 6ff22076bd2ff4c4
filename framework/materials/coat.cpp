#include "framework/materials/coat.h"

#include "framework/materials/fresnel.h"

namespace etendue {

namespace {

// The integral over [0, end] by midpoints; the integrands here have bounded second derivatives.
template <class Integrand>
double integral(double end, const Integrand& integrand) {
  constexpr int steps = 1024;
  double sum = 0;
  for (int i = 0; i < steps; ++i) sum += integrand((i + 0.5) * end / steps);
  return sum * end / steps;
}

}  // namespace

Coat::Coat(float eta, float depth) : eta_(eta), depth_(depth), entering_(1 - fresnel_average(eta)) {
  internal_ = 1 - entering_ / (eta * eta);
  leaving_ = 1 - internal_;
  if (depth == 0) return;
  // Inside, mu dmu is that of outside over eta^2; what lies beyond the critical angle is reflected entirely.
  const double square_eta = static_cast<double>(eta) * eta, critical = std::sqrt(std::max(0.0, 1 - 1 / square_eta));
  const auto dimmed = [depth](double cosine, int times) { return math::exp(-times * depth / cosine); };
  const auto of_outside = [&](auto share) {
    return integral(1, [&](double mu) {
      float inside = 0;
      const float reflected = fresnel_dielectric(static_cast<float>(mu), eta, &inside);
      return 2 * mu * share(static_cast<double>(reflected), static_cast<double>(inside));
    });
  };
  const double through = of_outside([&](double r, double inside) { return (1 - r) * dimmed(inside, 1); });
  const double back = of_outside([&](double r, double inside) { return r * dimmed(inside, 2); });
  const double beyond = integral(critical, [&](double mu) { return 2 * mu * dimmed(mu, 2); });
  entering_ = static_cast<float>(through);
  leaving_ = static_cast<float>(through / square_eta);
  internal_ = static_cast<float>(back / square_eta + beyond);
}

}  // namespace etendue
