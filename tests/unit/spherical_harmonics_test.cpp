// Spherical harmonics and records of radiance in them.
#include "integrators/caches/records/spherical_harmonics.h"
#include "framework/core/sampler.h"
#include "framework/core/sampling.h"
#include "integrators/caches/records/radiance_cache_records.h"
#include "integrators/caches/rough_cache.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

std::vector<float> harmonics_at(int order, const vec3& direction) {
  std::vector<float> values(static_cast<std::size_t>(order) * order);
  evaluate_sh(order, direction, values);
  return values;
}

TEST(SphericalHarmonics, FirstOnesAreTheirClosedForms) {
  const vec3 w = glm::normalize(vec3(0.3f, -0.5f, 0.7f));
  const auto y = harmonics_at(3, w);
  EXPECT_NEAR(y[0], 0.28209479, 1e-6);
  EXPECT_NEAR(y[sh_index(1, -1)], 0.48860251 * w.y, 1e-6);
  EXPECT_NEAR(y[sh_index(1, 0)], 0.48860251 * w.z, 1e-6);
  EXPECT_NEAR(y[sh_index(1, 1)], 0.48860251 * w.x, 1e-6);
  EXPECT_NEAR(y[sh_index(2, -2)], 1.09254843 * w.x * w.y, 1e-6);
  EXPECT_NEAR(y[sh_index(2, 0)], 0.31539157 * (3 * w.z * w.z - 1), 1e-6);
  EXPECT_NEAR(y[sh_index(2, 2)], 0.54627422 * (w.x * w.x - w.y * w.y), 1e-6);
}

// Unsoeld: the squares of a band add up to (2 l + 1) / (4 pi) in every direction.
TEST(SphericalHarmonics, BandsObeyTheAdditionTheorem) {
  for (std::uint32_t i = 0; i < 50; ++i) {
    Sampler sampler(SamplerKind::sobol, 1, Stream::test, 0, i);
    const auto y = harmonics_at(highest_sh_order, sample_unit_sphere(sampler.get_2d()));
    for (int l = 0; l < highest_sh_order; ++l) {
      double sum = 0;
      for (int m = -l; m <= l; ++m) sum += square(y[sh_index(l, m)]);
      EXPECT_NEAR(sum * 4 * pi / (2 * l + 1), 1, 2e-4) << l;
    }
  }
}

TEST(SphericalHarmonics, AreOrthonormal) {
  constexpr int order = 6, count = order * order, n = 128;
  std::vector<double> gram(count * count, 0);
  for (int j = 0; j < n; ++j)
    for (int k = 0; k < n; ++k) {
      const auto y = harmonics_at(order, sample_unit_sphere((vec2(j, k) + 0.5f) / float(n)));
      for (int a = 0; a < count; ++a)
        for (int b = 0; b < count; ++b) gram[a * count + b] += y[a] * y[b] * 4 * pi / (n * n);
    }
  for (int a = 0; a < count; ++a)
    for (int b = 0; b < count; ++b) EXPECT_NEAR(gram[a * count + b], a == b, 5e-3) << a << " " << b;
}

// Irradiance of a cone of light about the axis: pi sin^2 of its half angle.
TEST(SphericalHarmonics, CosineConvolutionGivesIrradiance) {
  constexpr int order = 11, n = 200;
  for (const float cos_max : {0.5f, 0.0f, -1.0f}) {
    std::vector<double> light(order, 0);  // zonal coefficients
    for (int k = 0; k < n; ++k) {
      const float z = cos_max + (1 - cos_max) * (k + 0.5f) / n;
      const auto y = harmonics_at(order, {std::sqrt(1 - z * z), 0, z});
      for (int l = 0; l < order; ++l) light[l] += y[sh_index(l, 0)] * 2 * pi * (1 - cos_max) / n;
    }
    const auto axis = harmonics_at(order, {0, 0, 1});
    double irradiance = 0;
    for (int l = 0; l < order; ++l) irradiance += cosine_convolution(l) * light[l] * axis[sh_index(l, 0)];
    const double exact = pi * (1 - square(std::max(0.0f, cos_max)));
    EXPECT_NEAR(irradiance / exact, 1, 0.01) << cos_max;
  }
}

// A floor under a large plane at height one whose radiance is 1 + x: E / pi is 1 + (x + 0) by symmetry where the plane is
// infinite, so that the gradient along x is what the strata see move.
RadianceEstimate under_slope(const HemisphereStrata& strata, const Frame& frame, float place) {
  std::vector<HemisphereSample> samples(static_cast<std::size_t>(strata.count()));
  for (int i = 0; i < strata.count(); ++i) {
    Sampler sampler(SamplerKind::sobol, 1, Stream::test, 0, static_cast<std::uint32_t>(i));
    const vec3 local = strata.even_direction(i, sampler.get_2d());
    const float distance = 1 / std::max(local.z, 1e-3f);
    samples[i] = {.radiance = Rgb(2 + std::sin(0.3f * (place + distance * local.x))),
                  .distance = distance,
                  .direction = frame.to_world(local)};
  }
  return estimate_radiance(10, strata, samples, frame);
}

Rgb answer(const ShLobe& lobe, const RadianceEstimate& estimate, std::size_t part) {
  Rgb sum(0);
  for (std::size_t i = 0; i < lobe.size(); ++i) sum += lobe[i] * estimate.coefficients[100 * part + i];
  return sum;
}

TEST(RadianceRecords, ConstantLightGivesItself) {
  const HemisphereStrata strata = HemisphereStrata::of(1024);
  const Frame frame = Frame::from_normal(glm::normalize(vec3(0.2f, 0.9f, -0.3f)));
  std::vector<HemisphereSample> samples(static_cast<std::size_t>(strata.count()));
  for (int i = 0; i < strata.count(); ++i)
    samples[i] = {.radiance = Rgb(3, 2, 1), .distance = 1, .direction = frame.to_world(strata.even_direction(i, vec2(0.5f)))};
  const auto estimate = estimate_radiance(10, strata, samples, frame);
  const Rgb white = answer(diffuse_lobe(10, frame.normal), estimate, 0);
  EXPECT_NEAR(white.x, 3, 0.01);
  EXPECT_NEAR(white.z, 1, 0.005);
  for (const std::size_t part : {1u, 2u}) EXPECT_NEAR(answer(diffuse_lobe(10, frame.normal), estimate, part).x, 0, 0.01);
}

TEST(RadianceRecords, GradientIsTheDifferenceBetweenPlaces) {
  const HemisphereStrata strata = HemisphereStrata::of(16384);
  const Frame frame = Frame::from_normal({0, 0, 1});
  const ShLobe lobe = diffuse_lobe(10, frame.normal);
  const float step = 0.2f;
  const double difference =
      (answer(lobe, under_slope(strata, frame, step), 0).x - answer(lobe, under_slope(strata, frame, -step), 0).x) / (2 * step);
  const auto here = under_slope(strata, frame, 0);
  EXPECT_NEAR(answer(lobe, here, 1).x / difference, 1, 0.08);
  EXPECT_NEAR(answer(lobe, here, 2).x, 0, 0.05 * difference);
}

// Each coefficient by itself, of high degree too.
TEST(RadianceRecords, GradientsOfCoefficientsAreDifferencesBetweenPlaces) {
  const HemisphereStrata strata = HemisphereStrata::of(65536);
  const Frame frame = Frame::from_normal({0, 0, 1});
  const float step = 0.05f;
  const auto before = under_slope(strata, frame, -step), after = under_slope(strata, frame, step);
  const auto here = under_slope(strata, frame, 0);
  double squares = 0, errors = 0;
  for (std::size_t i = 0; i < 64; ++i) {  // l < 8
    const double difference = (after.coefficients[i].x - before.coefficients[i].x) / (2.0 * step);
    squares += square(difference);
    errors += square(here.coefficients[100 + i].x - difference);
  }
  EXPECT_LT(std::sqrt(errors / squares), 0.15);
}

// The lobe's transform over the plane, by quadrature: integral of J_0(l t) g(t) t over that of g(t) t.
TEST(LobeShare, IsTheTransformOfTheLobe) {
  for (const float alpha : {0.1f, 0.3f, 0.6f})
    for (const int degree : {1, 4, 9}) {
      double sum = 0, all = 0;
      const double a = 2.0 * alpha, far = 200 * a;
      constexpr int n = 40000;
      for (int k = 0; k < n; ++k) {
        const double t = (k + 0.5) * far / n, g = t / square(1 + square(t / a));
        sum += std::cyl_bessel_j(0.0, degree * t) * g;
        all += g;
      }
      EXPECT_NEAR(lobe_share(alpha, degree), sum / all, 1e-3) << alpha << " " << degree;
    }
}

TEST(LobeShare, IsThatOfTheBesselFunction) {
  for (const float alpha : {0.001f, 0.02f, 0.3f})
    for (const int degree : {1, 3, 10, 60}) {
      const double x = 2.0 * alpha * degree;
      EXPECT_NEAR(lobe_share(alpha, degree) / (x * std::cyl_bessel_k(1.0, x)), 1, 3e-7) << x;
    }
}

TEST(LobeShare, NarrowLobesAskForMoreBands) {
  EXPECT_EQ(lobe_order(0.6f, 0.025f), 4);
  EXPECT_EQ(lobe_order(0.25f, 0.025f), 10);
  EXPECT_EQ(lobe_order(0.15f, 0.025f), highest_sh_order);
}

}  // namespace
}  // namespace etendue
