#include "integrators/progressive.h"

namespace etendue {

namespace {

constexpr std::uint64_t pilot_key = 0xffffffffffffffffull;

float median(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

ProgressivePasses::ProgressivePasses(const ProgressiveParams& params, VisiblePoints points)
    : params_(params),
      points_(points),
      sampler_(parse_sampler(params.sampler)),
      kernel_(kernel_from_name(params.kernel)),
      sample_direct_(params.direct == "sample"),
      gathered_(sample_direct_ ? photon_caustic | photon_indirect : photon_any) {}

void ProgressivePasses::prepare(const RenderContext& context) {
  max_depth_ = context.max_depth(params_.max_depth);
  receivers_ = std::make_unique<Receivers>(context.scene, params_.carry_below);
  if (params_.photons == 0) params_.photons = std::max(20000, 3 * context.resolution.x * context.resolution.y);
}

PhotonMap ProgressivePasses::trace_map(const RenderContext& context, std::uint32_t pass) const {
  return trace_map(context, std::uint64_t{pass});
}

PhotonMap ProgressivePasses::trace_map(const RenderContext& context, std::uint64_t key) const {
  Photons photons;
  {
    const auto timed = context.phases.measure("emit");
    // The event at which a photon is gathered counts too.
    photons = trace_photons(context, *receivers_,
                            {static_cast<std::uint32_t>(params_.photons), key, max_depth_ - 1, gathered_, sampler_});
  }
  const auto timed = context.phases.measure("build");
  PhotonMap map;
  map.build(std::move(photons), context.make_points(params_.structure), {0, 1, kernel_, params_.side_test});
  return map;
}

InitialRadii ProgressivePasses::pilot(const RenderContext& context) const {
  const std::size_t pixels = static_cast<std::size_t>(context.resolution.x) * context.resolution.y;
  if (params_.radius > 0) return InitialRadii(pixels * points_.per_pixel(), params_.radius);
  const PhotonMap map = trace_map(context, pilot_key);
  const float widest = glm::length(context.scene.bounds().diagonal());
  constexpr float unknown = -1;
  InitialRadii radii(pixels * points_.per_pixel(), unknown);
  parallel_pixels(context.resolution, [&](ivec2 pixel) {
    for (std::uint32_t i = 0; i < points_.per_pixel(); ++i) {
      float& r = radii[points_.slot(static_cast<std::size_t>(pixel.y) * context.resolution.x + pixel.x, i)];
      camera(context, pixel, i, [&](const GatherPoint& at, const Rgb&) {
        if (r == unknown) r = map.distance_to(params_.neighbours, at, widest);
      });
    }
  });
  std::vector<float> known;
  for (const float r : radii)
    if (r > 0 && r < widest) known.push_back(r);
  const float usual = known.empty() ? 0.01f * widest : median(known);
  for (float& r : radii) r = r > 0 ? std::min(r, 4 * usual) : usual;
  return radii;
}

}  // namespace etendue
