#include "integrators/photons/disc_coverage.h"

#include "framework/core/elementary.h"
#include "framework/transport/ray_tools.h"
#include "integrators/paths/surfaces.h"

namespace etendue {

namespace {

constexpr double least_covered = 0.01;
constexpr float missing = 0.5f;  // of a probe: on surfaces that curve away they are somewhat off 1
constexpr std::uint32_t never = std::numeric_limits<std::uint32_t>::max();
constexpr int most_passed = 8;  // surfaces above one that holds photons

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

DiscCoverage::DiscCoverage(const RoughMaterials& rough_materials, const Rules& rules, ivec2 resolution, std::size_t slots)
    : rough_materials_(rough_materials),
      rules_(rules),
      blocks_((resolution + block_side - 1) / block_side),
      slots_(slots),
      missed_(static_cast<std::size_t>(blocks_.x) * blocks_.y) {
  for (auto& missed : missed_) missed = never;
}

DiscCoverage::Aim DiscCoverage::aim(const GatherPoint& at, float radius, const vec2& u) const {
  const vec3& normal = at.normal();
  const Frame frame = Frame::from_normal(normal);
  const float x = kernel_quantile(rules_.kernel, u.x), distance = radius * std::sqrt(x), angle = 2 * pi * u.y;
  const vec3 flat = distance * (math::cos(angle) * frame.tangent + math::sin(angle) * frame.bitangent);
  const float height = flatness * radius;
  return {{.origin = at.position() + flat + height * normal, .direction = -normal, .t_max = 2 * height}, x};
}

float DiscCoverage::covered(const RenderContext& context, const GatherPoint& at, float radius, const Aim& aim, Hit hit,
                            SurfacePoint point, const NearWalls& walls) const {
  Ray ray = aim.ray;
  float free_from = 0;  // along the ray: beneath what it passed
  const auto sees = [&](const vec3& end) {
    return !walls.may_hide(point.position, [&end] { return end; }) ||
           sees_landed(context, segment(at.origin(), end), point.position);
  };
  // Photons are looked for where they came from, as before_landing has it: half of the way up to what the probe passed, else as
  // far above the surface as they lie apart, which is over what is lower.
  const auto is_hidden = [&] {
    if (walls.none()) return false;
    if (free_from > 0) return !sees(ray.at(0.5f * (free_from + hit.t)));
    if (sees(ray.origin)) return false;
    const vec3 end = point.position + glm::length(point.position - at.position()) * at.normal();
    const bool higher = glm::dot(end - ray.origin, at.normal()) > 0;
    return !(higher && unoccluded(context, segment(ray.origin, end)) && sees(end));
  };
  for (int passed = 0;; ++passed) {
    const bool counts = rough_materials_.stores(point.material) && share_light(point.layer, at.layer());
    const bool sheet = lets_light_through(point.layer);
    const bool clear = sheet || std::holds_alternative<Dielectric>(context.scene.materials[point.material]);
    if ((counts || !clear) && !is_hidden()) {
      if (!counts) return 0;
      break;
    }
    if (passed == most_passed) return 0;
    if (counts || !sheet) free_from = hit.t;
    ray.t_min = std::max(hit.t, std::nextafter(ray.t_min, infinity));
    hit = trace(context, ray);
    if (!hit) return 0;
    point = context.scene.surface_at(ray, hit);
  }
  const float facing = std::abs(glm::dot(point.normal, at.normal()));
  if (facing < (rules_.side_test ? 0.1f : 0.01f)) return 0;
  const float hit_x = aim.x + square((flatness * radius - hit.t) / radius), shape = kernel_shape(rules_.kernel, aim.x);
  if (!(hit_x < 1 && shape > 0)) return 0;
  return kernel_shape(rules_.kernel, hit_x) / (shape * facing * context.stopped_share(hit));  // as photons count there
}

float DiscCoverage::probe(const RenderContext& context, const GatherPoint& at, float radius, const vec2& u,
                          const NearWalls& walls) const {
  const Aim to = aim(at, radius, u);
  const Hit hit = trace(context, to.ray);
  return hit ? covered(context, at, radius, to, hit, context.scene.surface_at(to.ray, hit), walls) : 0;
}

template <class Body>
void DiscCoverage::for_points(const RenderContext& context, const Disc& disc, const Points& points, const Body& body) const {
  const SobolPair sequence(context.seed, Stream::probe, disc.slot, points.dimension);
  for (std::uint32_t i = points.first; i < points.first + points.count; ++i) {
    const auto independent = [&] {
      return Sampler(rules_.sampler, context.seed, Stream::probe, hash_keys(disc.slot, points.dimension), i).get_2d();
    };
    body(rules_.sampler == SamplerKind::sobol ? sequence.point(i) : independent());
  }
}

// Other threads note misses of this iteration meanwhile, which do not count about their blocks yet.
bool DiscCoverage::is_measured(const ivec2& block, std::uint32_t iteration) const {
  if (missed_[index_of(block)].load(std::memory_order_relaxed) <= iteration) return true;
  const ivec2 first = glm::max(block - 1, ivec2(0)), last = glm::min(block + 1, blocks_ - 1);
  for (int y = first.y; y <= last.y; ++y)
    for (int x = first.x; x <= last.x; ++x)
      if (missed_[index_of({x, y})].load(std::memory_order_relaxed) < iteration) return true;
  return false;
}

void DiscCoverage::measure(const RenderContext& context, const PhotonMap& map, std::uint32_t iteration,
                           std::span<const Disc> discs) {
  constexpr std::uint32_t seldom = 16;
  static_assert(block_side * block_side == seldom);
  // body(disc, block) for those that are measured, or for those that are not; many in a row are of one block.
  const auto for_each = [&](bool wanted, const auto& body) {
    ivec2 last(-1);
    bool measured = false;
    for (const Disc& disc : discs) {
      const ivec2 block = disc.pixel / block_side;
      if (block != last) measured = is_measured(block, iteration);
      last = block;
      if (measured == wanted) body(disc, block);
    }
  };
  for_each(false, [&](const Disc& disc, const ivec2& block) {
    const ivec2 place = disc.pixel - block * block_side;
    const std::uint32_t turn = slots_[disc.slot].gathers++;
    if (turn != 0 && (turn + place.y * block_side + place.x) % seldom != 0) return;
    for_points(context, disc, {1, turn, 1}, [&](const vec2& u) {
      if (probe(context, disc.at, disc.radius, u, map.near_walls(disc.at, disc.radius)) < missing)
        missed_[index_of(block)].store(iteration, std::memory_order_relaxed);
    });
  });
  static thread_local Probes probes;
  probes.discs.clear();
  probes.x.clear();
  probes.rays.clear();
  for_each(true, [&](const Disc& disc, const ivec2&) {
    Slot& s = slots_[disc.slot];
    const bool whole = !s.masked && s.covered >= nearly_whole * s.whole;
    if (whole && s.probes >= 32 && s.gathers++ % seldom != 0) return;
    const std::uint32_t count = s.probes == 0 ? 16 : whole ? 1 : s.probes < 64 ? 4 : 2;
    probes.discs.push_back({&disc, count});
    for_points(context, disc, {0, s.probes, count}, [&](const vec2& u) {
      const Aim to = aim(disc.at, disc.radius, u);
      probes.rays.push_back(to.ray);
      probes.x.push_back(to.x);
    });
  });
  trace_together(context, map, probes);
}

void DiscCoverage::trace_together(const RenderContext& context, const PhotonMap& map, Probes& probes) {
  auto& [discs, x, rays, hits, points] = probes;
  hits.resize(rays.size());
  trace(context, rays, hits);
  surfaces_at(context.scene, rays, hits, points);
  std::size_t i = 0;
  for (const auto& [disc, count] : discs) {
    const NearWalls walls = map.near_walls(disc->at, disc->radius);
    float sum = 0;
    Slot& s = slots_[disc->slot];
    for (const std::size_t end = i + count; i < end; ++i) {
      if (!hits[i]) continue;
      sum += covered(context, disc->at, disc->radius, {rays[i], x[i]}, hits[i], points[i], walls);
      s.masked = s.masked || context.stopped_share(hits[i]) < 1;
    }
    s.whole += disc->weight;
    s.covered += disc->weight * (sum / static_cast<float>(count));
    s.probes += count;
  }
}

double DiscCoverage::correction(std::size_t slot) const {
  const Slot& s = slots_[slot];
  return s.whole > 0 ? s.whole / std::max(s.covered, least_covered * s.whole) : 1;
}

}  // namespace etendue
