#include "integrators/photons/final_gather.h"

#include "framework/transport/direct_light.h"
#include "framework/transport/ray_tools.h"
#include "framework/transport/roulette.h"
#include "integrators/photons/incident_directions.h"

namespace etendue {

namespace {

constexpr int photons_for_directions = 128;

// A direction and f |cos| over its density; black where nothing is reflected.
struct Scattered {
  vec3 wi{0};
  Rgb weight{0};
};

Scattered by_bsdf(const Bsdf& bsdf, const vec3& wo, Sampler& sampler) {
  const float u_lobe = bsdf.is_diffuse() ? 0 : sampler.get_1d();
  const BsdfSample sample = bsdf.sample(wo, u_lobe, sampler.get_2d());
  return !sample || sample.specular ? Scattered{} : Scattered{sample.wi, sample.weight};
}

Scattered by_mixture(const Bsdf& bsdf, const vec3& wo, const IncidentDirections& directions, Sampler& sampler) {
  const vec2 u_choice = sampler.get_2d(), u = sampler.get_2d();
  vec3 wi;
  if (u_choice.x < 0.5f) {
    const BsdfSample sample = bsdf.sample(wo, u_choice.y, u);
    if (!sample || sample.specular) return {};
    wi = sample.wi;
  } else {
    wi = directions.sample(u);
  }
  const float density = 0.5f * (bsdf.pdf(wo, wi) + directions.pdf_solid_angle(wi));
  return density > 0 ? Scattered{wi, bsdf.evaluate(wo, wi) / density} : Scattered{};
}

}  // namespace

Rgb FinalGather::operator()(const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, int depth, std::uint64_t key,
                            std::uint32_t iteration) const {
  std::optional<IncidentDirections> directions;
  if (by_photons) {
    directions.emplace(map, GatherPoint(point, bsdf, wo, photon_indirect, max_depth), photons_for_directions);
    if (directions->empty()) directions.reset();
  }
  Rgb sum(0);
  for (int j = 0; j < rays; ++j) {
    Sampler numbers(sampler, context.seed, Stream::gather, hash_keys(key, depth),
                    iteration * static_cast<std::uint32_t>(rays) + static_cast<std::uint32_t>(j));
    const Scattered to = directions ? by_mixture(bsdf, wo, *directions, numbers) : by_bsdf(bsdf, wo, numbers);
    if (is_black(to.weight)) continue;
    const Ray ray = spawn_ray(point, to.wi);
    sum += to.weight * along(ray, trace(context, ray), depth + 1, numbers);
  }
  return sum / static_cast<float>(rays);
}

Rgb FinalGather::along(Ray ray, Hit hit, int depth, Sampler& numbers, float* photon_footprint) const {
  if (photon_footprint != nullptr) *photon_footprint = 0;
  const int first = depth;
  Rgb radiance(0), throughput(1);
  float eta_scale = 1;
  for (; depth < max_depth && hit; ++depth) {
    const SurfacePoint point = context.scene.surface_at(ray, hit);
    const Bsdf bsdf(context.scene, point);
    const bool rough = rough_materials(point.material);
    const vec3 wo = -ray.direction;
    bool ends = false;
    if (rough) {
      const int remaining = max_depth - depth - 1;
      const PhotonMap::Estimate seen = reflected(point, bsdf, wo, remaining);
      ends = !(follow_near && hit.t < seen.radius);
      if (ends && depth == first && photon_footprint != nullptr) *photon_footprint = seen.photon_footprint;
      radiance += throughput * (ends ? seen.radiance
                                     : direct_light(context, point, bsdf, wo, numbers, MisMode::light) +
                                           map.radiance(context, point, bsdf, wo, photon_caustic, remaining));
    }
    if (ends && !bsdf.has_specular()) break;

    const float u_lobe = numbers.get_1d();
    const BsdfSample scattered = bsdf.sample(wo, u_lobe, numbers.get_2d());
    if (!scattered || (ends && !scattered.specular)) break;
    throughput *= scattered.weight;
    if (scattered.transmitted) eta_scale *= scattered.eta * scattered.eta;
    ray = spawn_ray(point, scattered.wi);
    if (!survives_roulette(throughput, survival_of(throughput, eta_scale), numbers)) break;
    hit = trace(context, ray);
  }
  return radiance;
}

PhotonMap::Estimate FinalGather::reflected(const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo,
                                           int max_scatterings) const {
  if (irradiance && is_flat(point, wo) && bsdf.is_diffuse() && max_scatterings >= irradiance->longest()) {
    const vec3 normal = glm::dot(wo, point.normal) < 0 ? -point.normal : point.normal;
    if (const auto found = irradiance->at(context, point.position, normal, ray_origin(point, normal)))
      return {found->irradiance * bsdf.diffuse_albedo() * inv_pi, found->resolution, found->photon_footprint};
  }
  return map.measure(context, GatherPoint(point, bsdf, wo, photon_any, max_scatterings));
}

}  // namespace etendue
