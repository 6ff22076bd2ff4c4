// Exact scenes of a rough mirror (GGX, height-correlated masking, one reflection): in a glowing sphere behind a veil
// (exact_stage.h), where the radiance is the lobe's albedo, and before a lamp of any size, where it is the lobe's share of it.
#include "framework/core/elementary.h"
#include "framework/scenes/builtin_scenes.h"
#include "framework/scenes/exact_stage.h"

#include <array>
#include <cmath>

namespace etendue {

namespace {

double lambda(double alpha, double cosine) {
  const double tangent2 = 1 / (cosine * cosine) - 1;
  return 0.5 * (std::sqrt(1 + alpha * alpha * tangent2) - 1);
}

// The share of light from `cosine` to the normal that the microfacets send back, in double precision and within 1e-5 for a
// cosine above 0.3.
double ggx_albedo(double alpha, double cosine) {
  // Over the visible normals [Heitz2018] the weight is G2 / G1; normals come from the projected half disc. The tail of the lobe
  // lies at its rim, where circles are dense: of radius^2 = 1 - w^2.
  constexpr int circles = 256, points = 64;
  const double sine = std::sqrt(1 - cosine * cosine);
  const double stretched = math::hypot(alpha * sine, cosine);
  const double vx = alpha * sine / stretched, vz = cosine / stretched;  // the view in the stretched space, in its x-z plane
  const double s = 0.5 * (1 + vz);
  double sum = 0;
  for (int i = 0; i < circles; ++i)
    for (int j = 0; j < points; ++j) {
      const double w = (i + 0.5) / circles, r = std::sqrt(1 - w * w), turn = 2 * pi_d * (j + 0.5) / points;
      const double p1 = r * math::cos(turn);
      const double p2 = (1 - s) * std::sqrt(1 - p1 * p1) + s * r * math::sin(turn);
      const double p3 = std::sqrt(std::max(0.0, 1 - p1 * p1 - p2 * p2));
      // p1 along y, p2 along the vector across both, p3 along the view.
      const dvec3 normal = glm::normalize(dvec3(alpha * (p3 * vx - p2 * vz), alpha * p1, p2 * vx + p3 * vz));
      const double incoming = 2 * (sine * normal.x + cosine * normal.z) * normal.z - cosine;
      if (incoming > 0) sum += 2 * w * (1 + lambda(alpha, cosine)) / (1 + lambda(alpha, cosine) + lambda(alpha, incoming));
    }
  return sum / (circles * points);
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
      const double weight = (i % 2 ? -1 : 1) * math::sin(angle(i)) / distance;  // [Berrut2004] section 5
      sum += weight * values_[i];
      weights += weight;
    }
    return sum / weights;
  }

 private:
  static constexpr std::size_t count = 10;
  static double angle(std::size_t i) { return (2.0 * static_cast<double>(i) + 1) * pi_d / (2.0 * count); }
  double cosine(std::size_t i) const { return low_ + (1 - low_) * 0.5 * (1 + math::cos(angle(i))); }

  double low_;
  std::array<double, count> values_;
};

// The share of a lamp's radiance that they send to the unit vector `to_viewer`, from a sphere that is seen in the direction
// `to_lamp` and of a size as below. The normal is z; the lamp lies above the horizon.
double ggx_lamp_share(double alpha, double size, const dvec3& to_viewer, const dvec3& to_lamp) {
  // Circles about the lamp's middle, dense where the lobe is: the angle is alpha sinh(s).
  constexpr int circles = 256, points = 96;
  const dvec3 aside = glm::normalize(glm::cross(to_lamp, dvec3(1, 0, 0))), across = glm::cross(to_lamp, aside);
  const double widest = math::asinh(math::asin(size) / alpha);
  double sum = 0;
  for (int i = 0; i < circles; ++i) {
    const double s = widest * (i + 0.5) / circles, angle = alpha * math::sinh(s);
    const double area = math::sin(angle) * alpha * math::cosh(s) * widest / circles * 2 * pi_d / points;
    for (int j = 0; j < points; ++j) {
      const double turn = 2 * pi_d * (j + 0.5) / points;
      const dvec3 wi = math::cos(angle) * to_lamp + math::sin(angle) * (math::cos(turn) * aside + math::sin(turn) * across);
      const dvec3 h = glm::normalize(wi + to_viewer);
      const double t = (h.x * h.x + h.y * h.y) / (alpha * alpha) + h.z * h.z;
      const double density = 1 / (pi_d * alpha * alpha * t * t);  // [Walter2007] eq. 33
      sum += area * density / (4 * to_viewer.z * (1 + lambda(alpha, wi.z) + lambda(alpha, to_viewer.z)));
    }
  }
  return sum;
}

struct GlossyLampParams {
  float alpha = 0.1f;
  float size = 0.1f;
};

template <class Visitor>
void describe(Visitor& v, GlossyLampParams& p) {
  v.number("alpha", p.alpha, 0.005, 1, "GGX alpha", "roughness of the mirror");
  v.number("size", p.size, 1e-4, 0.6, "1", "sine of the angle between the lamp's middle and its edge");
}

// The camera sees a lamp in the mirror, at 45 degrees, of radiance 1 in the middle. A direction of a narrow lobe finds it with
// a chance of p = 1 / (1 + q), q = 4 alpha^2 cos / size^2, and thus has a relative variance of q; a point of the lamp has one
// of (1 + q)^2 / (3 q) - 1. By multiple importance sampling it is small in both cases.
Scene make_glossy_lamp(const GlossyLampParams& params) {
  // Seen and lit from so far that one part of the mirror is like the next.
  constexpr float far = 10, half = 0.001f;
  const vec3 eye(0, far, far), lamp(0, far, -far);
  const auto share = [alpha = double(params.alpha), size = double(params.size), eye, lamp](double x, double z) {
    const dvec3 to_viewer = glm::normalize(dvec3(eye) - dvec3(x, 0, z)), to_lamp = glm::normalize(dvec3(lamp) - dvec3(x, 0, z));
    return ggx_lamp_share(alpha, size, {to_viewer.x, to_viewer.z, to_viewer.y}, {to_lamp.x, to_lamp.z, to_lamp.y});
  };
  SceneBuilder b("builtin:glossy-lamp");
  b.mesh(quad({-half, 0, half}, {half, 0, half}, {half, 0, -half}, {-half, 0, -half}),
         b.material(Conductor{.ideal = true, .alpha = vec2(params.alpha)}));
  const auto radiance = static_cast<float>(1 / share(0, 0));
  b.quadric(Sphere{lamp, params.size * glm::length(lamp)}, b.material(Diffuse{Rgb(0)}), Rgb(radiance));
  b.camera(eye, vec3(0), 0.004f, exact_resolution);
  // Between the corners the radiance is bilinear to within 1e-3 for the narrowest lobe, and 1e-4 from a roughness of 0.02 on.
  std::array<double, 4> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = radiance * share(i & 1 ? half : -half, i & 2 ? half : -half);
  b.closed_form("a lamp in a rough mirror: L = its lobe's share of the lamp", [corners](const Ray& ray) {
    const dvec3 o(ray.origin), d(ray.direction), p = o - o.y / d.y * d;
    const double u = 0.5 + 0.5 * p.x / half, v = 0.5 + 0.5 * p.z / half;
    return dvec3((1 - v) * ((1 - u) * corners[0] + u * corners[1]) + v * ((1 - u) * corners[2] + u * corners[3]));
  });
  return b.finish();
}

struct GlossyFurnaceParams {
  float alpha = 0.3f;
  bool veil = true;
};

template <class Visitor>
void describe(Visitor& v, GlossyFurnaceParams& p) {
  v.number("alpha", p.alpha, 0.001, 1, "GGX alpha", "roughness of the mirror");
  v.flag("veil", p.veil, "a sphere of index 1 about the mirror: no shadow ray gets through, the image stays the same");
}

// From n photons that arrive evenly within a kernel, a narrow lobe makes an estimate of relative variance
// 1 / (12 alpha^2 cos^2 n), cos to the viewer: pi times the integral of f^2 cos, over the albedo squared.
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

}  // namespace

std::vector<BuiltinScene> glossy_scenes() {
  return {with_params<make_glossy_furnace>("glossy-furnace", "exact: a rough mirror in a glowing sphere"),
          with_params<make_glossy_lamp>("glossy-lamp", "exact: a lamp of any size in a mirror of any roughness")};
}

}  // namespace etendue
