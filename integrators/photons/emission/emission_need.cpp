#include "integrators/photons/emission/emission_need.h"

#include "integrators/photons/photon_path.h"

namespace etendue {

namespace {

constexpr std::uint32_t paths = 8192, few = paths / 100;
constexpr double pixels = 1024;
constexpr float near = 0.02f;  // what is seen, over the diagonal of the scene

}  // namespace

PhotonEmission emission_by_need(const RenderContext& context, const RoughMaterials& rough_materials, PhotonEmission asked,
                                SeenOptions options) {
  if (asked != PhotonEmission::by_need) return asked;
  if (context.lights.empty() || context.bounds.empty() || options.max_depth < 1) return PhotonEmission::power;
  const auto timed = context.phases.measure("pilot");
  RenderContext small = context;
  small.resolution = reduced(context.resolution, pixels);
  small.window = {};  // which is of the real image's pixels
  small.seed = 0;
  options.samples = 1;
  const auto region = find_seen(small, rough_materials, options, near * glm::length(small.bounds.diagonal()));
  const PhotonPass pass{.count = paths, .key = hash_keys(0x6e656564u), .max_scatterings = options.max_depth - 1};
  const PathNumbers of_pass(small.seed, pass, pass.key);
  PhotonTracer tracer(small, rough_materials, pass);
  Photons photons;  // these light nothing, and are not among those that are counted
  std::uint32_t seen = 0;
  for (std::uint32_t path = 0; path < paths && seen < few; ++path) {
    SampledNumbers numbers(of_pass, path);
    photons.clear();
    tracer.trace(numbers, 1, photons);
    for (std::size_t i = 0; i < photons.size(); ++i)
      seen += region->contains(photons.position[i], photons.side[i].normal()) ? 1 : 0;
  }
  return seen > 0 && seen < few ? PhotonEmission::visibility : PhotonEmission::power;
}

}  // namespace etendue
