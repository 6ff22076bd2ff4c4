// BSDFs: what `sample` draws follows `pdf` (chi-square), weights are f cos / pdf, energy is kept, and the two transport modes
// are adjoint.
#include "framework/transport/bsdf.h"
#include "framework/core/sampling.h"
#include "framework/materials/fresnel.h"
#include "integrators/photons/cache_points.h"

#include <gtest/gtest.h>

#include <vector>

namespace etendue {
namespace {

struct Looks {
  std::string name;
  Material material;
};

std::vector<Looks> all_looks() {
  const Rgb eta(0.2f, 0.9f, 1.1f), k(3.9f, 2.5f, 2.2f);
  return {
      {"diffuse", Diffuse{Rgb(0.7f)}},
      {"conductor", Conductor{.eta = eta, .k = k, .alpha = vec2(0.3f)}},
      {"anisotropic conductor", Conductor{.eta = eta, .k = k, .alpha = vec2(0.15f, 0.5f)}},
      {"rough glass", Dielectric{.eta = 1.5f, .alpha = 0.3f}},
      {"leaf", DiffuseTransmission{Rgb(0.3f), Rgb(0.6f)}},
      {"Beckmann conductor",
       Conductor{.eta = eta, .k = k, .alpha = vec2(0.15f, 0.5f), .distribution = NormalDistribution::beckmann}},
      {"Beckmann glass", Dielectric{.eta = 1.5f, .alpha = 0.3f, .distribution = NormalDistribution::beckmann}},
      {"Beckmann plastic",
       Plastic{.reflectance = Rgb(0.6f), .coat = 1.5f, .alpha = 0.2f, .distribution = NormalDistribution::beckmann}},
      {"plastic", Plastic{.reflectance = Rgb(0.6f), .coat = 1.5f}},
      {"rough plastic", Plastic{.reflectance = Rgb(0.6f), .coat = 1.5f, .alpha = 0.2f}},
      {"dimming plastic", Plastic{.reflectance = Rgb(0.6f), .coat = {1.5f, 0.3f}, .alpha = 0.2f}},
  };
}

struct Setting {
  Scene scene;
  SurfacePoint point;

  explicit Setting(const Material& material) {
    scene.materials.push_back(material);
    const vec3 n = glm::normalize(vec3(0.3f, -0.5f, 0.8f));
    point = {vec3(0), n, n, vec3(1, 0.2f, 0), vec2(0.5f), 0, no_id};
  }
  Bsdf bsdf() const { return Bsdf(scene, point); }
  // A direction with a given cosine to the normal; below the surface where negative.
  vec3 direction(float cosine, float phi) const {
    const float s = std::sqrt(1 - cosine * cosine);
    return Frame::from_normal(point.normal).to_world({s * std::cos(phi), s * std::sin(phi), cosine});
  }
};

Sampler numbers(int i, int salt = 0) { return Sampler(SamplerKind::independent, 11, Stream::test, i, salt); }

constexpr float cosines[] = {0.95f, 0.5f, 0.15f, -0.6f};

// Upper tail of chi-square by the Wilson-Hilferty cube root, good to a few percent of the tail, which suffices at 1e-5.
double chi_square_z(double chi2, double dof) {
  return (std::cbrt(chi2 / dof) - (1 - 2 / (9 * dof))) / std::sqrt(2 / (9 * dof));
}

TEST(Bsdf, SamplesFollowThePdf) {
  constexpr int rows = 16, columns = 12, samples = 100000, fine = 24;
  for (const Looks& c : all_looks()) {
    const Setting setting(c.material);
    const Bsdf bsdf = setting.bsdf();
    const Frame frame = Frame::from_normal(setting.point.normal);
    for (const float cosine : cosines) {
      const vec3 wo = setting.direction(cosine, 0.8f);
      std::vector<double> observed(rows * columns, 0), expected(rows * columns, 0);
      for (int i = 0; i < samples; ++i) {
        Sampler s = numbers(i);
        const float u_lobe = s.get_1d();
        const BsdfSample drawn = bsdf.sample(wo, u_lobe, s.get_2d());
        if (!drawn || drawn.specular) continue;
        const vec3 local = frame.to_local(drawn.wi);
        const float phi = std::atan2(local.y, local.x) / (2 * pi);
        const int row = std::clamp(static_cast<int>(0.5f * (local.z + 1) * rows), 0, rows - 1);
        const int column = std::clamp(static_cast<int>((phi < 0 ? phi + 1 : phi) * columns), 0, columns - 1);
        ++observed[row * columns + column];
      }
      // Bins are equal in z and phi, so equal in solid angle: midpoint rule.
      for (int row = 0; row < rows * fine; ++row)
        for (int column = 0; column < columns * fine; ++column) {
          const float z = 2 * (static_cast<float>(row) + 0.5f) / (rows * fine) - 1;
          const float phi = 2 * pi * (static_cast<float>(column) + 0.5f) / (columns * fine);
          const float sine = std::sqrt(1 - z * z);
          const vec3 wi = frame.to_world({sine * std::cos(phi), sine * std::sin(phi), z});
          if (is_black(bsdf.evaluate(wo, wi))) continue;  // drawn, but given no weight
          expected[row / fine * columns + column / fine] +=
              bsdf.pdf(wo, wi) * samples * 4 * pi / (rows * columns * fine * fine);
        }
      double chi2 = 0, pooled_observed = 0, pooled_expected = 0;
      int dof = 0;
      for (std::size_t i = 0; i < observed.size(); ++i) {
        if (expected[i] < 10) {
          pooled_observed += observed[i];
          pooled_expected += expected[i];
          continue;
        }
        chi2 += square(static_cast<float>(observed[i] - expected[i])) / expected[i];
        ++dof;
      }
      if (pooled_expected > 10) {
        chi2 += square(static_cast<float>(pooled_observed - pooled_expected)) / pooled_expected;
        ++dof;
      }
      ASSERT_GT(dof, 1) << c.name;
      EXPECT_LT(chi_square_z(chi2, dof), 4.5) << c.name << " cos " << cosine << " chi2 " << chi2 << " dof " << dof;
    }
  }
}

TEST(Bsdf, WeightsAreValueOverDensity) {
  for (const Looks& c : all_looks()) {
    const Setting setting(c.material);
    const Bsdf bsdf = setting.bsdf();
    for (const float cosine : cosines)
      for (const TransportMode mode : {TransportMode::radiance, TransportMode::importance})
        for (int i = 0; i < 200; ++i) {
          const vec3 wo = setting.direction(cosine, 0.1f * static_cast<float>(i));
          Sampler s = numbers(i, 1);
          const float u_lobe = s.get_1d();
          const BsdfSample drawn = bsdf.sample(wo, u_lobe, s.get_2d(), mode);
          if (!drawn || drawn.specular) continue;
          const Rgb value = bsdf.evaluate(wo, drawn.wi, mode) / drawn.pdf_solid_angle;
          EXPECT_NEAR(drawn.pdf_solid_angle, bsdf.pdf(wo, drawn.wi), 2e-2f * drawn.pdf_solid_angle) << c.name;
          EXPECT_NEAR(value.y, drawn.weight.y, 2e-2f * drawn.weight.y + 1e-4f) << c.name;
        }
  }
}

double mean_weight(const Bsdf& bsdf, const vec3& wo, TransportMode mode) {
  constexpr int samples = 1 << 14;
  double sum = 0;
  for (int i = 0; i < samples; ++i) {
    Sampler s(SamplerKind::sobol, 1, Stream::test, 0, i);
    const float u_lobe = s.get_1d();
    sum += bsdf.sample(wo, u_lobe, s.get_2d(), mode).weight.y;
  }
  return sum / samples;
}

TEST(Bsdf, LosslessSurfacesKeepAllEnergy) {
  const Looks lossless[] = {{"white", Diffuse{Rgb(1)}},
                            {"mirror", Conductor{.ideal = true}},
                            {"glass", Dielectric{.eta = 1.5f}},
                            {"pane", Dielectric{.eta = 1.5f, .thin = true}},
                            {"leaf", DiffuseTransmission{Rgb(0.25f), Rgb(0.75f)}},
                            {"white plastic", Plastic{.reflectance = Rgb(1), .coat = 1.5f}}};
  for (const Looks& c : lossless) {
    const Setting setting(c.material);
    for (const float cosine : cosines)
      // Importance counts particles: refraction does not change their number.
      EXPECT_NEAR(mean_weight(setting.bsdf(), setting.direction(cosine, 1), TransportMode::importance), 1, 5e-3)
          << c.name << " " << cosine;
  }
}

// Held to a walk between base and coat, which is dimmed at each crossing and counts what leaves.
TEST(Bsdf, ACoatDimsWhatCrossesIt) {
  for (const float depth : {0.01f, 0.5f}) {
    const float albedo = 0.8f, eta = 1.5f, cosine = 0.6f;
    const Setting setting(Plastic{.reflectance = Rgb(albedo), .coat = {eta, depth}});
    float inside = 0;
    const double reflected = fresnel_dielectric(cosine, eta, &inside);
    double sum = 0;
    constexpr int walks = 100'000;
    for (int i = 0; i < walks; ++i) {
      Sampler s = numbers(i, 5);
      double left = (1 - reflected) * std::exp(-depth / inside);
      while (left > 1e-6) {
        const float mu = std::sqrt(s.get_1d());
        left *= albedo * std::exp(-depth / mu);
        const double back = fresnel_dielectric(mu, 1 / eta);
        sum += left * (1 - back);
        left *= back * std::exp(-depth / mu);
      }
    }
    const double energy = mean_weight(setting.bsdf(), setting.direction(cosine, 1), TransportMode::importance);
    EXPECT_NEAR(energy, reflected + sum / walks, 3e-3) << depth;
  }
}

TEST(Bsdf, ADeepCoatHidesItsBase) {
  const Setting setting(Plastic{.reflectance = Rgb(0.8f), .coat = {1.5f, 500}});
  const vec3 wo = setting.direction(0.6f, 1);
  EXPECT_EQ(setting.bsdf().evaluate(wo, setting.direction(0.9f, 2)), Rgb(0));
  EXPECT_EQ(base_reflectance(setting.scene, setting.point, setting.bsdf(), wo), Rgb(0));
}

TEST(Bsdf, RoughSurfacesLoseAndNeverGain) {
  constexpr auto beckmann = NormalDistribution::beckmann;
  const Looks rough[] = {{"conductor", Conductor{.ideal = true, .alpha = vec2(0.4f)}},
                         {"Beckmann conductor", Conductor{.ideal = true, .alpha = vec2(0.4f), .distribution = beckmann}},
                         {"Beckmann glass", Dielectric{.eta = 1.5f, .alpha = 0.4f, .distribution = beckmann}},
                         {"glass", Dielectric{.eta = 1.5f, .alpha = 0.4f}},
                         {"plastic", Plastic{.reflectance = Rgb(1), .coat = 1.5f, .alpha = 0.3f}}};
  for (const Looks& c : rough) {
    const Setting setting(c.material);
    for (const float cosine : cosines) {
      const double energy = mean_weight(setting.bsdf(), setting.direction(cosine, 1), TransportMode::importance);
      EXPECT_LT(energy, 1.02) << c.name << " " << cosine;
      EXPECT_GT(energy, 0.65) << c.name << " " << cosine;
    }
  }
}

TEST(Bsdf, SwappingDirectionsGivesTheAdjoint) {
  // f(wo, wi) for radiance is f*(wi, wo) for importance, also across an interface and under a tilted shading normal.
  for (const Looks& c : all_looks()) {
    Setting setting(c.material);
    setting.point.shading_normal = glm::normalize(setting.point.normal + vec3(0.1f, 0.15f, -0.1f));
    const Bsdf bsdf = setting.bsdf();
    for (int i = 0; i < 500; ++i) {
      Sampler s = numbers(i, 2);
      const vec3 wo = sample_unit_sphere(s.get_2d()), wi = sample_unit_sphere(s.get_2d());
      // evaluate holds |cos wi| to the shading normal; the adjoint is defined against geometric cosines.
      const float radiance = bsdf.evaluate(wo, wi).y / std::abs(glm::dot(wi, setting.point.shading_normal));
      const float importance = bsdf.evaluate(wi, wo, TransportMode::importance).y /
                               std::abs(glm::dot(wo, setting.point.normal)) * std::abs(glm::dot(wi, setting.point.normal)) /
                               std::abs(glm::dot(wi, setting.point.shading_normal));
      EXPECT_NEAR(radiance, importance, 2e-3f * std::abs(radiance) + 1e-5f) << c.name;
    }
  }
}

// With a shading normal far from the geometric one, a direction may be above one surface and below the other.
TEST(Bsdf, NormalsThatDisagreeOnTheSideLetNothingThrough) {
  for (const Looks& c : all_looks()) {
    Setting setting(c.material);
    const vec3 normal = setting.point.normal;
    setting.point.shading_normal = setting.direction(0.6f, 0.3f);
    const Bsdf bsdf = setting.bsdf();
    const auto agree = [&](const vec3& wo, const vec3& wi) {
      const vec3& shading = setting.point.shading_normal;
      return (glm::dot(wo, normal) * glm::dot(wi, normal) > 0) == (glm::dot(wo, shading) * glm::dot(wi, shading) > 0);
    };
    int disagreeing = 0;
    for (int i = 0; i < 2000; ++i) {
      Sampler s = numbers(i, 7);
      const vec3 wo = sample_unit_sphere(s.get_2d()), wi = sample_unit_sphere(s.get_2d());
      if (!agree(wo, wi)) {
        ++disagreeing;
        EXPECT_EQ(bsdf.evaluate(wo, wi), Rgb(0)) << c.name;
      }
      const float u_lobe = s.get_1d();
      const BsdfSample drawn = bsdf.sample(wo, u_lobe, s.get_2d());
      EXPECT_TRUE(!drawn || agree(wo, drawn.wi)) << c.name;
    }
    EXPECT_GT(disagreeing, 300) << c.name;
  }
}

TEST(Microfacets, NormalsCoverTheirSurface) {
  for (const NormalDistribution distribution : {NormalDistribution::ggx, NormalDistribution::beckmann})
    for (const float alpha : {0.1f, 0.4f, 1.0f}) {
      const Microfacets facets(vec2(alpha, 0.5f * alpha), distribution);
      constexpr int side = 1000;
      double sum = 0;
      for (int i = 0; i < side; ++i)
        for (int j = 0; j < side / 10; ++j) {
          const double theta = 0.5 * pi * (i + 0.5) / side, phi = 20 * pi * (j + 0.5) / side;
          const vec3 h(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
          sum += facets.density(h) * std::cos(theta) * std::sin(theta) * (0.5 * pi / side) * (20 * pi / side);
        }
      EXPECT_NEAR(sum, 1, 2e-3) << alpha;
    }
}

// Smith's masking in closed form, whose fit is [Walter2007] eq. 27.
TEST(Microfacets, BeckmannsMaskingIsSmiths) {
  const Microfacets facets(vec2(0.5f), NormalDistribution::beckmann);
  for (float cosine = 0.05f; cosine < 1; cosine += 0.05f) {
    const double c = cosine / (0.5 * std::sqrt(1 - cosine * cosine));
    const double exact = 1 / (1 + 0.5 * (std::erf(c) - 1) + std::exp(-c * c) / (2 * c * std::sqrt(pi)));
    EXPECT_NEAR(facets.masking(vec3(std::sqrt(1 - cosine * cosine), 0, cosine)), exact, 4e-3) << cosine;
  }
}

TEST(Fresnel, HemisphericalAverageMatchesQuadrature) {
  for (const float eta : {1.1f, 1.33f, 1.5f, 2.4f}) {
    constexpr int steps = 20000;
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
      const double cosine = (i + 0.5) / steps;
      sum += 2 * cosine * fresnel_dielectric(static_cast<float>(cosine), eta) / steps;
    }
    EXPECT_NEAR(fresnel_average(eta), sum, 2e-5) << eta;
  }
}

TEST(Fresnel, NormalIncidenceAndTotalReflection) {
  EXPECT_NEAR(fresnel_dielectric(1.0f, 1.5f), 0.04f, 1e-6f);
  float cos_t = 1;
  EXPECT_EQ(fresnel_dielectric(0.3f, 1 / 1.5f, &cos_t), 1);
  EXPECT_EQ(cos_t, 0);
  // A conductor without absorption is a dielectric.
  EXPECT_NEAR(fresnel_conductor(0.4f, Rgb(1.5f), Rgb(0)).x, fresnel_dielectric(0.4f, 1.5f), 1e-5f);
}

}  // namespace
}  // namespace etendue
