#include "integrators/caches/records/irradiance_hessian.h"

#include "framework/core/check.h"
#include "framework/core/elementary.h"

#include <vector>

namespace etendue {

namespace {

constexpr double least_cosine = 0.01;  // at which a patch is taken to be seen

// Hessian over the tangent plane of a patch's form factor F = A (n.r)(m.r) / r^4, n.m for the cosines at point and patch:
// F / r^2 times 24 d d' - 4 I - 4 (m d' + d m') / cos, where d is the direction to it ([Jarosz2012], differentiated here).
TangentMatrix patch_hessian(const HemisphereSample& sample, const Frame& frame) {
  if (!(sample.distance < infinity) || sample.distance == 0) return {};
  const dvec3 d(frame.to_local(sample.direction));
  dvec3 m(frame.to_local(sample.normal));
  if (glm::dot(m, d) < 0) m = -m;
  const double slant = 4 / std::max(glm::dot(m, d), least_cosine);
  const TangentMatrix bracket{24 * d.x * d.x - 4 - 2 * slant * m.x * d.x, 24 * d.x * d.y - slant * (m.x * d.y + m.y * d.x),
                              24 * d.y * d.y - 4 - 2 * slant * m.y * d.y};
  return bracket * (1 / (static_cast<double>(sample.distance) * sample.distance));
}

TangentMatrix absolute(const TangentMatrix& m) {
  const TangentEigen e = eigen(m);
  return tangent_matrix(std::abs(e.first), std::abs(e.second), e.axis);
}

struct Vertex {
  dvec3 position;  // in the point's frame
  double distance;
  dvec3 radiance;
};

// The strata's samples with the vertices that close the mesh: ring 0 is the zenith (one vertex), rings 1 .. M the samples,
// ring M + 1 the horizon.
class HemisphereMesh {
 public:
  HemisphereMesh(const HemisphereStrata& strata, std::span<const HemisphereSample> samples, const Frame& frame)
      : rings_(strata.theta), sectors_(strata.phi) {
    double far = 0;
    for (const HemisphereSample& s : samples)
      if (s.distance < infinity) far = std::max(far, static_cast<double>(s.distance));
    far = far > 0 ? 1e4 * far : 1;
    vertices_.reserve(samples.size() + sectors_);
    double inverse = 0;
    dvec3 zenith(0);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const HemisphereSample& s = samples[i];
      const double distance = std::min(static_cast<double>(s.distance), far);
      const vec3 direction =
          s.direction == vec3(0) ? frame.to_world(strata.direction(static_cast<int>(i), vec2(0.5f))) : s.direction;
      vertices_.push_back({distance * dvec3(frame.to_local(direction)), distance, dvec3(s.radiance)});
      if (i < static_cast<std::size_t>(sectors_)) {
        inverse += 1 / distance;
        zenith += dvec3(s.radiance);
      }
    }
    const double distance = sectors_ / inverse;
    zenith_ = {{0, 0, distance}, distance, zenith / static_cast<double>(sectors_)};
    for (int k = 0; k < sectors_; ++k) {
      Vertex edge = at(rings_, k);
      const double flat = math::hypot(edge.position.x, edge.position.y);
      edge.position = edge.distance / flat * dvec3(edge.position.x, edge.position.y, 0);
      vertices_.push_back(edge);
    }
  }

  // Every edge once: body(a, b, step) with the radiance of the triangle that runs from a to b less that of the one that runs
  // back. Triangles run so that their irradiance is positive: along a ring with growing azimuth where they lie above it.
  template <class Body>
  void for_edges(const Body& body) const {
    std::vector<dvec3> above(sectors_), lower(sectors_), upper(sectors_);
    for (int k = 0; k < sectors_; ++k) above[k] = farthest(zenith_, at(1, k), at(1, k + 1));
    for (int k = 0; k < sectors_; ++k)
      body(zenith_.position, at(1, k).position, above[k] - above[(k + sectors_ - 1) % sectors_]);
    for (int ring = 1; ring <= rings_; ++ring) {
      // Each quadrangle between two rings is cut from (ring, k) to (ring + 1, k + 1).
      for (int k = 0; k < sectors_; ++k) {
        upper[k] = farthest(at(ring, k), at(ring, k + 1), at(ring + 1, k + 1));
        lower[k] = farthest(at(ring, k), at(ring + 1, k), at(ring + 1, k + 1));
      }
      for (int k = 0; k < sectors_; ++k) {
        body(at(ring, k).position, at(ring, k + 1).position, above[k] - upper[k]);
        body(at(ring, k).position, at(ring + 1, k + 1).position, upper[k] - lower[k]);
        body(at(ring, k).position, at(ring + 1, k).position, lower[k] - upper[(k + sectors_ - 1) % sectors_]);
      }
      above = lower;
    }
    for (int k = 0; k < sectors_; ++k) body(at(rings_ + 1, k).position, at(rings_ + 1, k + 1).position, above[k]);
  }

 private:
  const Vertex& at(int ring, int k) const { return vertices_[static_cast<std::size_t>(ring - 1) * sectors_ + k % sectors_]; }
  static const dvec3& farthest(const Vertex& a, const Vertex& b, const Vertex& c) {
    const Vertex& ab = b.distance > a.distance ? b : a;
    return (c.distance > ab.distance ? c : ab).radiance;
  }

  int rings_, sectors_;
  std::vector<Vertex> vertices_;
  Vertex zenith_;
};

}  // namespace

TangentEigen eigen(const TangentMatrix& m) {
  const double mean = 0.5 * (m.xx + m.yy), half = 0.5 * (m.xx - m.yy), root = math::hypot(half, m.xy);
  const double first = mean >= 0 ? mean + root : mean - root, second = mean >= 0 ? mean - root : mean + root;
  const double angle = 0.5 * math::atan2(m.xy, half) + (mean >= 0 ? 0 : 0.5 * std::numbers::pi);
  return {first, second, {math::cos(angle), math::sin(angle)}};
}

TangentMatrix tangent_matrix(double a, double b, const dvec2& u) {
  return {a * u.x * u.x + b * u.y * u.y, (a - b) * u.x * u.y, a * u.y * u.y + b * u.x * u.x};
}

TangentMatrix radiometric_hessian(const HemisphereStrata& strata, std::span<const HemisphereSample> samples,
                                  const Frame& frame) {
  TangentMatrix sum;
  for (const HemisphereSample& s : samples) sum += patch_hessian(s, frame) * static_cast<double>(luminance(s.radiance));
  return sum * (std::numbers::pi / strata.count());
}

TangentMatrix geometric_hessian(const HemisphereStrata& strata, std::span<const HemisphereSample> samples, const Frame& frame) {
  TangentMatrix sum;
  for (const HemisphereSample& s : samples) sum += absolute(patch_hessian(s, frame));
  return sum * (std::numbers::pi / strata.count());
}

EdgeDerivatives edge_derivatives(const dvec3& a, const dvec3& b) {
  const dvec3 e = b - a, c = glm::cross(a, b);
  const double cc = glm::dot(c, c), ee = glm::dot(e, e), aa = glm::dot(a, a), bb = glm::dot(b, b);
  if (!(cc > 1e-24 * aa * bb)) return {};
  const double length = std::sqrt(ee), area = std::sqrt(cc), h = area / length;
  const dvec3 along = e / length, foot = (a - glm::dot(a, along) * along) / h;
  const double angle = math::atan2(area, glm::dot(a, b));
  // The edge's points are r (cos psi foot + sin psi along) with cos psi = h / r; the integrals below run over psi.
  const double ra = std::sqrt(aa), rb = std::sqrt(bb), cos_a = h / ra, cos_b = h / rb;
  const double sin_a = glm::dot(a, along) / ra, sin_b = glm::dot(b, along) / rb;
  const double sc = sin_b * cos_b - sin_a * cos_a, ca2 = cos_a * cos_a, cb2 = cos_b * cos_b;
  const double cos2 = 0.5 * (angle + sc), sin_cos = 0.5 * (ca2 - cb2);
  const double cos4 = 0.25 * (sin_b * cos_b * cb2 - sin_a * cos_a * ca2) + 0.75 * cos2;
  const double cos3_sin = 0.25 * (ca2 * ca2 - cb2 * cb2), cos2_sin2 = cos2 - cos4;

  const double phi = angle / area, q = c.z;
  const double first = 2 / (area * h), second = 1 / (area * h * h);
  const dvec3 grad = first * (cos2 * foot + sin_cos * along);
  const auto hess = [&](int i, int j) {
    return second * (8 * (cos4 * foot[i] * foot[j] + cos3_sin * (foot[i] * along[j] + along[i] * foot[j]) +
                          cos2_sin2 * along[i] * along[j]) -
                     (i == j ? 2 * cos2 : 0));
  };
  const double qx = -e.y, qy = e.x;  // q's own derivatives: n x e
  return {phi * q,
          grad.x * q + phi * qx,
          grad.y * q + phi * qy,
          {hess(0, 0) * q + 2 * grad.x * qx, hess(0, 1) * q + grad.x * qy + grad.y * qx, hess(1, 1) * q + 2 * grad.y * qy}};
}

MeshDerivatives occlusion_derivatives(const HemisphereStrata& strata, std::span<const HemisphereSample> samples,
                                      const Frame& frame) {
  CHECK_EQ(static_cast<int>(samples.size()), strata.count());
  dvec3 value(0), x(0), y(0);
  TangentMatrix hessian;
  HemisphereMesh(strata, samples, frame).for_edges([&](const dvec3& a, const dvec3& b, const dvec3& step) {
    if (step == dvec3(0)) return;
    const EdgeDerivatives edge = edge_derivatives(a, b);
    value += 0.5 * edge.value * step;
    x += 0.5 * edge.x * step;
    y += 0.5 * edge.y * step;
    hessian += edge.hessian * (0.5 * static_cast<double>(luminance(Rgb(step))));
  });
  MeshDerivatives out{Rgb(value), mat3(0), hessian};
  for (int c = 0; c < 3; ++c)
    out.translation[c] = static_cast<float>(x[c]) * frame.tangent + static_cast<float>(y[c]) * frame.bitangent;
  return out;
}

}  // namespace etendue
