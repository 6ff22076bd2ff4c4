#include "framework/scenes/glossy_furnace.h"

#include "framework/scenes/exact_stage.h"

#include <array>
#include <cmath>

namespace etendue {

namespace {

double lambda(double alpha, double cosine) {
  const double tangent2 = 1 / (cosine * cosine) - 1;
  return 0.5 * (std::sqrt(1 + alpha * alpha * tangent2) - 1);
}

// Through Chebyshev's nodes for cosines of [low, 1].
class AlbedoCurve {
 public:
  AlbedoCurve(double alpha, double low) : low_(low) {
    for (std::size_t i = 0; i < count; ++i) values_[i] = ggx_albedo(alpha, cosine(i));
  }
  double at(double x) const {
    double sum = 0, weights = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double distance = x - cosine(i);
      if (distance == 0) return values_[i];
      const double weight = (i % 2 ? -1 : 1) * std::sin(angle(i)) / distance;  // [Berrut2004] section 5
      sum += weight * values_[i];
      weights += weight;
    }
    return sum / weights;
  }

 private:
  static constexpr std::size_t count = 10;
  static double angle(std::size_t i) { return (2.0 * static_cast<double>(i) + 1) * pi_d / (2.0 * count); }
  double cosine(std::size_t i) const { return low_ + (1 - low_) * 0.5 * (1 + std::cos(angle(i))); }

  double low_;
  std::array<double, count> values_;
};

}  // namespace

double ggx_albedo(double alpha, double cosine) {
  // Over the visible normals [Heitz2018] the weight is G2 / G1; normals come from the projected half disc of unit area.
  constexpr int steps = 96;
  const double sine = std::sqrt(1 - cosine * cosine);
  const double stretched = std::hypot(alpha * sine, cosine);
  const double vx = alpha * sine / stretched, vz = cosine / stretched;  // the view in the stretched space, in its x-z plane
  const double s = 0.5 * (1 + vz);
  double sum = 0;
  for (int i = 0; i < steps; ++i)
    for (int j = 0; j < steps; ++j) {
      const double r = std::sqrt((i + 0.5) / steps), turn = 2 * pi_d * (j + 0.5) / steps;
      const double p1 = r * std::cos(turn);
      const double p2 = (1 - s) * std::sqrt(1 - p1 * p1) + s * r * std::sin(turn);
      const double p3 = std::sqrt(std::max(0.0, 1 - p1 * p1 - p2 * p2));
      // p1 along y, p2 along the vector across both, p3 along the view.
      double nx = -p2 * vz + p3 * vx, ny = p1, nz = p2 * vx + p3 * vz;
      nx *= alpha;
      ny *= alpha;
      const double length = std::sqrt(nx * nx + ny * ny + nz * nz);
      nx /= length;
      nz /= length;
      const double incoming = 2 * (sine * nx + cosine * nz) * nz - cosine;
      if (incoming > 0) sum += (1 + lambda(alpha, cosine)) / (1 + lambda(alpha, cosine) + lambda(alpha, incoming));
    }
  return sum / (steps * steps);
}

Scene make_glossy_furnace(const GlossyFurnaceParams& params) {
  SceneBuilder b("builtin:glossy-furnace");
  const auto black = b.material(Diffuse{Rgb(0)});
  b.quadric(Sphere{vec3(0), 2}, black, Rgb(1), true);
  b.quadric(Disk{vec3(0), 1, {0, 1, 0}}, b.material(Conductor{.ideal = true, .alpha = vec2(params.alpha)}));
  b.quadric(Disk{{0, -0.2f, 0}, 1, {0, 1, 0}}, black);  // nothing is reflected from below
  if (params.veil) b.quadric(Sphere{vec3(0), 1.6f}, b.material(Dielectric{.eta = 1}));
  b.camera({0, 1.05f, 0.85f}, vec3(0), 36, {128, 128});
  b.closed_form("a lobe in a furnace: L = its albedo, once reflected",
                [curve = AlbedoCurve(params.alpha, 0.3)](const Ray& ray) {
                  return dvec3(curve.at(std::abs(glm::normalize(dvec3(ray.direction)).y)));
                });
  return b.finish();
}

}  // namespace etendue
