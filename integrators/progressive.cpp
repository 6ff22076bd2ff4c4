#include "integrators/progressive.h"

namespace etendue {

namespace {

constexpr std::uint64_t pilot_key = 0xffffffffffffffffull;

float median(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The radius at which the disc must end so that no light leaks from behind a wall on the same floor, where photons hidden from
// the point are more than even light would have there: the distance to the wall's far side, but at least a fifth of the radius,
// or too few photons would be left. Infinity where the light that leaks into the wide disc is less than twice the noise that
// the narrow one would have after 64 passes.
float clear_radius(const RenderContext& context, const PhotonMap& map, const GatherPoint& at, float radius) {
  constexpr float lift = 0.05f;  // above the surface, of the distance: it may curve
  float far_side = radius, seen = 0, hidden = 0;
  map.gather(at, radius, [&](const Rgb&, const vec3& offset, float distance_squared) {
    const float distance = std::sqrt(distance_squared);
    const Ray back{at.position() + offset + lift * distance * at.normal(), 0, -offset / distance, distance};
    const Hit hit = distance > 0 ? context.rays.closest(back) : Hit{};
    ++(hit ? hidden : seen);
    if (hit) far_side = std::min(far_side, distance - hit.t);
  });
  if (hidden == 0) return infinity;
  // Of the disc, behind a straight wall.
  const float x = far_side / radius, share = (std::acos(x) - x * std::sqrt(1 - x * x)) * inv_pi;
  const float even = seen * share / (1 - share);
  const float leaked = (hidden - even - 2 * std::sqrt(even + 1)) / std::max(seen, 1.0f);
  const float narrow = std::max(x, 0.2f), noise = 1 / (narrow * std::sqrt(64 * (seen + 1)));
  return leaked > 2 * noise ? narrow * radius : infinity;
}

// The least value of a pixel and its eight neighbours, for each of the `kinds` values that a pixel has.
std::vector<float> least_around(const std::vector<float>& values, ivec2 resolution, std::size_t kinds) {
  std::vector<float> least = values;
  const auto at = [&](ivec2 pixel) { return (static_cast<std::size_t>(pixel.y) * resolution.x + pixel.x) * kinds; };
  parallel_pixels(resolution, [&](ivec2 pixel) {
    const ivec2 first = glm::max(pixel - 1, ivec2(0)), last = glm::min(pixel + 1, resolution - 1);
    for (ivec2 other = first; other.y <= last.y; ++other.y)
      for (other.x = first.x; other.x <= last.x; ++other.x)
        for (std::size_t kind = 0; kind < kinds; ++kind)
          least[at(pixel) + kind] = std::min(least[at(pixel) + kind], values[at(other) + kind]);
  });
  return least;
}

}  // namespace

ProgressivePasses::ProgressivePasses(const ProgressiveParams& params, VisiblePoints points)
    : params_(params),
      points_(points),
      sampler_(parse_sampler(params.sampler)),
      kernel_(kernel_from_name(params.kernel)),
      sample_direct_(params.direct == "sample"),
      emission_(parse_emission(params.emission)),
      gathered_(sample_direct_ ? photon_caustic | photon_indirect : photon_any) {}

void ProgressivePasses::prepare(const RenderContext& context) {
  max_depth_ = context.max_depth(params_.max_depth);
  receivers_ = std::make_unique<Receivers>(context.scene, params_.carry_below,
                                           params_.flanks == "gathered" ? Flanks::gathered : Flanks::followed);
  const bool diffuse = !context.needs.caustic_map && !context.needs.glossy;
  if (params_.photons_per_pixel == 0) params_.photons_per_pixel = diffuse ? 2.5f : 1;
  if (params_.neighbours == 0) params_.neighbours = diffuse ? 50 : 20;
  if (params_.photons == 0) {
    const double wanted = static_cast<double>(params_.photons_per_pixel) * context.resolution.x * context.resolution.y;
    params_.photons = static_cast<int>(std::clamp(std::round(wanted), 2e4, 2e9));
  }
  if (emission_ == PhotonEmission::power && params_.radius > 0) return;
  widest_ = params_.radius > 0 ? params_.radius : 0.05f * glm::length(context.scene.bounds().diagonal());
  // Half as much again as the radius, for what lies between the samples of a pixel.
  seen_ = find_seen(context, *receivers_, {2, max_depth_, sampler_, params_.side_test}, 1.5f * widest_);
}

PhotonMap ProgressivePasses::trace_map(const RenderContext& context, std::uint32_t pass) const {
  return make_map(context, trace(context, pass), {0, 1, kernel_, params_.side_test});
}

Photons ProgressivePasses::trace(const RenderContext& context, std::uint64_t key) const {
  const auto timed = context.phases.measure("emit");
  // The event at which a photon is gathered counts too.
  return trace_photons(context, *receivers_,
                       {static_cast<std::uint32_t>(params_.photons), key, max_depth_ - 1, gathered_, sampler_, emission_,
                        emission_ == PhotonEmission::power ? nullptr : seen_.get()});
}

PhotonMap ProgressivePasses::make_map(const RenderContext& context, Photons photons, const GatherOptions& options) const {
  const auto timed = context.phases.measure("build");
  PhotonMap map;
  map.build(std::move(photons), context.make_points(params_.structure), options);
  return map;
}

// Photons that nobody sees are left out: behind a thin wall they may be many times as dense as before it.
PhotonMap ProgressivePasses::pilot_map(const RenderContext& context) const {
  const Photons photons = trace(context, pilot_key);
  std::vector<std::uint32_t> seen;
  for (std::uint32_t i = 0; i < photons.size(); ++i)
    if (seen_->contains(photons.position[i], photons.side[i].normal())) seen.push_back(i);
  return make_map(context, photons.reordered(seen), {params_.neighbours, 0, kernel_, params_.side_test});
}

std::unique_ptr<DiscCoverage> ProgressivePasses::make_coverage(const RenderContext& context) const {
  if (params_.edges == "disc") return nullptr;
  return std::make_unique<DiscCoverage>(*receivers_, DiscCoverage::Rules{kernel_, params_.side_test, sampler_},
                                        states(context));
}

InitialRadii ProgressivePasses::pilot(const RenderContext& context) const {
  if (params_.radius > 0) return InitialRadii(states(context), params_.radius);
  const PhotonMap map = pilot_map(context);
  InitialRadii radii(states(context), 0);
  std::vector<float> clear(radii.size(), infinity);
  const int of_flanks = std::max(1, params_.neighbours / 4);
  parallel_pixels(context.resolution, [&](ivec2 pixel) {
    for (std::uint32_t i = 0; i < points_.per_pixel(); ++i)
      camera(context, pixel, i, [&](const GatherPoint& at, const Rgb&) {
        const std::size_t state = first_state(context, pixel, i) + (at.of_flanks() ? 1 : 0);
        if (radii[state] > 0) return;
        radii[state] = map.distance_to(at.of_flanks() ? of_flanks : params_.neighbours, at, widest_);
        if (params_.clear_radius) clear[state] = clear_radius(context, map, at, radii[state]);
      });
  });
  // Later paths see other points of the pixel.
  if (params_.clear_radius && points_.fixed == 0) clear = least_around(clear, context.resolution, kinds());
  for (std::size_t kind = 0; kind < kinds(); ++kind) {
    std::vector<float> known;
    for (std::size_t s = kind; s < radii.size(); s += kinds())
      if (radii[s] > 0) known.push_back(radii[s]);
    const float usual = known.empty() ? widest_ : median(known);
    for (std::size_t s = kind; s < radii.size(); s += kinds())
      radii[s] = std::min(radii[s] > 0 ? std::min(radii[s], 2 * usual) : usual, clear[s]);
  }
  return radii;
}

}  // namespace etendue
