#include "integrators/caches/records/hemisphere.h"

#include "framework/core/check.h"
#include "framework/core/elementary.h"

#include <vector>

namespace etendue {

IrradianceEstimate estimate_irradiance(const HemisphereStrata& strata, std::span<const HemisphereSample> samples,
                                       const Frame& frame) {
  CHECK_EQ(static_cast<int>(samples.size()), strata.count());
  const int rings = strata.theta, sectors = strata.phi;
  const float scale = pi / static_cast<float>(strata.count()), sector = 2 * pi / static_cast<float>(sectors);
  // sin(theta) at the upper (smaller) end of ring j, and the mean of tan(theta) over it: M times the integral of 2 sin^2.
  std::vector<float> ring_sine(static_cast<std::size_t>(rings) + 1), ring_tangent(static_cast<std::size_t>(rings));
  const auto primitive = [](float sine) { return math::asin(sine) - sine * safe_sqrt(1 - sine * sine); };
  for (int j = 0; j <= rings; ++j) ring_sine[j] = std::sqrt(static_cast<float>(j) / static_cast<float>(rings));
  for (int j = 0; j < rings; ++j)
    ring_tangent[j] = static_cast<float>(rings) * (primitive(ring_sine[j + 1]) - primitive(ring_sine[j]));
  const auto plane = [&](float angle) { return math::cos(angle) * frame.tangent + math::sin(angle) * frame.bitangent; };

  IrradianceEstimate out;
  double inverse_distance = 0, half_squares = 0;
  const auto add = [](mat3& gradient, const vec3& direction, const Rgb& amount) {
    for (int c = 0; c < 3; ++c) gradient[c] += amount[c] * direction;
  };
  const float turned = sectors > 1 ? scale : 0;  // one sector has no direction to turn to
  for (int k = 0; k < sectors; ++k) {
    const float middle = sector * (static_cast<float>(k) + 0.5f), edge = sector * static_cast<float>(k);
    Rgb turning(0), outward(0), around(0);
    for (int j = 0; j < rings; ++j) {
      const HemisphereSample& here = samples[static_cast<std::size_t>(j) * sectors + k];
      out.irradiance += scale * here.radiance;
      inverse_distance += 1 / static_cast<double>(here.distance);
      out.nearest = std::min(out.nearest, here.distance);
      turning += ring_tangent[j] * here.radiance;
      if (j > 0) {  // [Ward1992]: the wall towards the ring above moves by cos(theta) / r
        const HemisphereSample& above = samples[static_cast<std::size_t>(j - 1) * sectors + k];
        const float sine = ring_sine[j];
        outward +=
            (here.radiance - above.radiance) * (sector * sine * (1 - sine * sine) / std::min(here.distance, above.distance));
      }
      // and the wall towards the sector before by 1 / (r sin(theta)), integrated over the ring
      const HemisphereSample& before = samples[static_cast<std::size_t>(j) * sectors + (k + sectors - 1) % sectors];
      half_squares += 0.5 * square(luminance(here.radiance - before.radiance));
      around +=
          (here.radiance - before.radiance) * ((ring_sine[j + 1] - ring_sine[j]) / std::min(here.distance, before.distance));
    }
    add(out.rotation, plane(middle + 0.5f * pi), turned * turning);
    add(out.translation, plane(middle), outward);
    add(out.translation, plane(edge + 0.5f * pi), around);
  }
  out.inverse_distance = static_cast<float>(inverse_distance / strata.count());
  out.variance = static_cast<float>(square(scale) * half_squares);
  return out;
}

float photon_variance(const HemisphereStrata& strata, std::span<const HemisphereSample> samples, const Frame& frame) {
  const float scale = pi / static_cast<float>(strata.count());  // a stratum's projected solid angle
  double variance = 0;
  for (const HemisphereSample& s : samples) {
    if (!(s.photon_footprint > 0)) continue;
    const float facing = std::abs(glm::dot(s.direction, s.normal)), above = glm::dot(s.direction, frame.normal);
    const float footprint = scale * square(s.distance) / std::max(facing * above, 1e-4f);
    variance += square(scale * luminance(s.radiance)) * static_cast<double>(s.photon_footprint) / std::max(footprint, 1e-30f);
  }
  return static_cast<float>(variance);
}

void IrradianceEstimate::average_in(const IrradianceEstimate& next, int passes) {
  const float share = 1 / static_cast<float>(passes);
  const auto mix = [share](auto& mean, const auto& value) { mean += share * (value - mean); };
  mix(irradiance, next.irradiance);
  variance = square(1 - share) * variance + square(share) * next.variance;
  if (next.source == source)
    shared_variance = square((1 - share) * std::sqrt(shared_variance) + share * std::sqrt(next.shared_variance));
  else
    shared_variance = square(1 - share) * shared_variance + square(share) * next.shared_variance;
  source = next.source;
  mix(inverse_distance, next.inverse_distance);
  nearest = std::min(nearest, next.nearest);
  mix(rotation, next.rotation);
  mix(translation, next.translation);
  const auto mix_matrix = [share](TangentMatrix& mean, const TangentMatrix& value) {
    mean = mean * (1 - static_cast<double>(share));
    mean += value * static_cast<double>(share);
  };
  mix_matrix(hessian, next.hessian);
  mix_matrix(geometric, next.geometric);
}

}  // namespace etendue
