#include "integrators/photons.h"

#include "framework/core/counters.h"
#include "framework/core/parallel.h"
#include "framework/transport/bsdf.h"
#include "framework/transport/ray_tools.h"

#include <tbb/parallel_sort.h>

namespace etendue {

namespace {

constexpr std::uint32_t chunk_size = 4096;

// Spreads the low 21 bits of x to every third bit.
constexpr std::uint64_t spread_bits(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x001f00000000ffffull;
  x = (x | x << 16) & 0x001f0000ff0000ffull;
  x = (x | x << 8) & 0x100f00f00f00f00full;
  x = (x | x << 4) & 0x10c30c30c30c30c3ull;
  return (x | x << 2) & 0x1249249249249249ull;
}

// The narrowest lobe that is not a delta: 1 for Lambert's.
struct NarrowestAlpha {
  float operator()(const Diffuse&) const { return 1; }
  float operator()(const Conductor& m) const { return std::min(m.alpha.x, m.alpha.y); }
  float operator()(const Dielectric& m) const { return m.alpha; }
  float operator()(const Plastic& m) const { return m.alpha > 0 ? m.alpha : 1; }
};

class PhotonTracer {
 public:
  PhotonTracer(const RenderContext& context, const Receivers& receivers, const PhotonPass& pass)
      : context_(context), receivers_(receivers), pass_(pass) {}

  void trace(std::uint32_t index, Photons& out);
  ~PhotonTracer() { count(Counter::rays, rays_); }

 private:
  bool stores(PhotonHistory history) const { return (pass_.keep & history) != 0; }

  const RenderContext& context_;
  const Receivers& receivers_;
  const PhotonPass& pass_;
  std::uint64_t rays_ = 0;
};

void PhotonTracer::trace(std::uint32_t index, Photons& out) {
  Sampler sampler(pass_.sampler, context_.seed, Stream::light_path, pass_.key, index);
  const float u_light = sampler.get_1d();
  const vec2 u_position = sampler.get_2d(), u_direction = sampler.get_2d();
  const auto emitted = context_.lights.emit(u_light, u_position, u_direction);
  if (!emitted || is_black(emitted->power)) return;
  Ray ray = emitted->ray;
  Rgb power = emitted->power / static_cast<float>(pass_.count);
  PhotonHistory history = photon_direct;
  for (int scatterings = 0;; ++scatterings) {
    ++rays_;
    const Hit hit = context_.rays.closest(ray);
    if (!hit) return;
    const SurfacePoint point = context_.scene.surface_at(ray, hit);
    const vec3 from = -ray.direction;
    const bool receiver = receivers_(point.material);
    if (receiver && stores(history))
      out.add(point.position, power, from, glm::dot(from, point.normal) < 0 ? -point.normal : point.normal, history,
              scatterings);
    if (scatterings >= pass_.max_scatterings) return;

    const Bsdf bsdf(context_.scene, point);
    if (receiver && !bsdf.has_specular() && !stores(photon_indirect)) return;
    const float u_lobe = sampler.get_1d();
    const BsdfSample sample = bsdf.sample(from, u_lobe, sampler.get_2d(), TransportMode::importance);
    if (!sample) return;
    const bool carries = sample.specular || !receiver;
    if (!carries) history = photon_indirect;
    if (carries && history == photon_direct) history = photon_caustic;
    if (history == photon_indirect && !stores(photon_indirect)) return;

    const Rgb scattered = power * sample.weight;
    const float survival = std::min(1.0f, max_component(scattered) / max_component(power));
    if (!(sampler.get_1d() < survival)) return;
    power = scattered / survival;
    ray = spawn_ray(point, sample.wi);
  }
}

}  // namespace

void Photons::add(const vec3& at, const Rgb& watts, const vec3& from, const vec3& normal_from, PhotonHistory history,
                  int events) {
  const auto quantise = [](float x) { return static_cast<std::int8_t>(std::lround(127 * std::clamp(x, -1.0f, 1.0f))); };
  position.push_back(at);
  power.push_back(watts);
  direction.push_back(from);
  side.push_back({quantise(normal_from.x), quantise(normal_from.y), quantise(normal_from.z), history});
  scatterings.push_back(static_cast<std::uint16_t>(std::min(events, 65535)));
}

Photons Photons::reordered(std::span<const std::uint32_t> order) const {
  Photons out;
  const auto gather = [&](const auto& from, auto& to) {
    to.resize(order.size());
    parallel_for(order.size(), chunk_size, [&](std::size_t i) { to[i] = from[order[i]]; });
  };
  gather(position, out.position);
  gather(power, out.power);
  gather(direction, out.direction);
  gather(side, out.side);
  gather(scatterings, out.scatterings);
  return out;
}

std::vector<std::uint32_t> along_curve(std::span<const vec3> points) {
  Bounds bounds;
  for (const vec3& p : points) bounds.extend(p);
  const vec3 scale = 2097151.0f / glm::max(bounds.diagonal(), vec3(std::numeric_limits<float>::min()));
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(points.size());
  parallel_for(points.size(), chunk_size, [&](std::size_t i) {
    const vec3 cell = glm::clamp((points[i] - bounds.lower) * scale, vec3(0), vec3(2097151.0f));
    keys[i] = {spread_bits(static_cast<std::uint64_t>(cell.x)) | spread_bits(static_cast<std::uint64_t>(cell.y)) << 1 |
                   spread_bits(static_cast<std::uint64_t>(cell.z)) << 2,
               static_cast<std::uint32_t>(i)};
  });
  tbb::parallel_sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order(points.size());
  parallel_for(points.size(), chunk_size, [&](std::size_t i) { order[i] = keys[i].second; });
  return order;
}

Receivers::Receivers(const Scene& scene, float narrow) {
  for (const Material& material : scene.materials) {
    const bool carries = has_non_specular(material) && std::visit(NarrowestAlpha{}, material) < narrow;
    narrow_lobes_ |= carries;
    receives_.push_back(has_non_specular(material) && !carries);
  }
}

Photons trace_photons(const RenderContext& context, const Receivers& receivers, const PhotonPass& pass) {
  if (context.lights.empty() || pass.count == 0 || pass.max_scatterings < 0) return {};
  const std::uint32_t chunk_count = (pass.count + chunk_size - 1) / chunk_size;
  std::vector<Photons> chunks(chunk_count);
  parallel_for(chunk_count, 1, [&](std::size_t c) {
    PhotonTracer tracer(context, receivers, pass);
    const auto first = static_cast<std::uint32_t>(c) * chunk_size;
    const std::uint32_t last = std::min(pass.count, first + chunk_size);
    for (std::uint32_t i = first; i < last; ++i) tracer.trace(i, chunks[c]);
  });

  std::vector<std::size_t> offset(chunk_count + 1, 0);
  for (std::uint32_t c = 0; c < chunk_count; ++c) offset[c + 1] = offset[c] + chunks[c].size();
  Photons joined;
  const auto join = [&](auto Photons::*field) {
    (joined.*field).resize(offset.back());
    parallel_for(chunk_count, 1, [&](std::size_t c) {
      std::copy((chunks[c].*field).begin(), (chunks[c].*field).end(),
                (joined.*field).begin() + static_cast<std::ptrdiff_t>(offset[c]));
    });
  };
  join(&Photons::position);
  join(&Photons::power);
  join(&Photons::direction);
  join(&Photons::side);
  join(&Photons::scatterings);
  count(Counter::photons_emitted, pass.count);
  count(Counter::photons_stored, joined.size());
  return joined;
}

}  // namespace etendue
