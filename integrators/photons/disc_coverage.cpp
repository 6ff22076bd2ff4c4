#include "integrators/photons/disc_coverage.h"

#include "framework/transport/ray_tools.h"

namespace etendue {

namespace {

constexpr double least_share = 0.01;
constexpr int most_passed = 8;  // sheets of glass above a surface that holds photons

// x = (distance / r)^2 within which a share u of the kernel's integral lies.
float kernel_quantile(Kernel kernel, float u) {
  if (kernel == Kernel::box) return u;
  if (kernel == Kernel::epanechnikov) return 1 - std::sqrt(1 - u);
  float low = 0, high = 1;
  for (int i = 0; i < 20; ++i) {
    const float middle = 0.5f * (low + high);
    (kernel_within(kernel, middle) < u ? low : high) = middle;
  }
  return low;
}

}  // namespace

float DiscCoverage::probe(const RenderContext& context, const GatherPoint& at, float radius, const vec2& u,
                          const NearWalls& walls) const {
  const vec3& normal = at.normal();
  const Frame frame = Frame::from_normal(normal);
  const float x = kernel_quantile(rules_.kernel, u.x), distance = radius * std::sqrt(x), angle = 2 * pi * u.y;
  const vec3 flat = distance * (std::cos(angle) * frame.tangent + std::sin(angle) * frame.bitangent);
  const float height = flatness * radius;
  Ray ray{.origin = at.position() + flat + height * normal, .direction = -normal, .t_max = 2 * height};
  Hit hit = trace(context, ray);
  if (!hit) return 0;
  SurfacePoint point = context.scene.surface_at(ray, hit);
  for (int passed = 0; !rough_materials_.stores(point.material); ++passed) {
    if (passed == most_passed || !std::holds_alternative<Dielectric>(context.scene.materials[point.material])) return 0;
    ray.t_min = std::max(hit.t, std::nextafter(ray.t_min, infinity));
    hit = trace(context, ray);
    if (!hit) return 0;
    point = context.scene.surface_at(ray, hit);
  }
  const float facing = std::abs(glm::dot(point.normal, normal));
  if (facing < (rules_.side_test ? 0.1f : 0.01f)) return 0;
  // Behind a wall no photons count.
  if (!walls.none() && walls.may_hide(point.position, [&] { return ray.origin; }) &&
      !unoccluded(context, segment(at.origin(), ray.origin)))
    return 0;
  const float hit_x = x + square((height - hit.t) / radius), shape = kernel_shape(rules_.kernel, x);
  return hit_x < 1 && shape > 0 ? kernel_shape(rules_.kernel, hit_x) / (shape * facing) : 0;
}

void DiscCoverage::measure(const RenderContext& context, std::size_t slot, const PhotonMap& map, const GatherPoint& at,
                           float radius, float weight) {
  Slot& s = slots_[slot];
  const bool whole = s.covered >= nearly_whole * s.whole;
  if (whole && s.probes >= 32 && s.gathers++ % 16 != 0) return;
  const std::uint32_t probes = s.probes == 0 ? 16 : whole ? 1 : s.probes < 64 ? 4 : 2;
  const NearWalls walls = map.near_walls(at, radius);
  double sum = 0;
  if (rules_.sampler == SamplerKind::sobol) {
    const SobolPair points(context.seed, Stream::probe, slot, 0);
    for (std::uint32_t i = 0; i < probes; ++i) sum += probe(context, at, radius, points.point(s.probes + i), walls);
  } else {
    for (std::uint32_t i = 0; i < probes; ++i)
      sum +=
          probe(context, at, radius, Sampler(rules_.sampler, context.seed, Stream::probe, slot, s.probes + i).get_2d(), walls);
  }
  s.probes += probes;
  s.whole += weight;
  s.covered += weight * sum / probes;
}

double DiscCoverage::correction(std::size_t slot) const {
  const Slot& s = slots_[slot];
  return s.whole > 0 ? s.whole / std::max(s.covered, least_share * s.whole) : 1;
}

}  // namespace etendue
