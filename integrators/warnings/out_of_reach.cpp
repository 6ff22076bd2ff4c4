#include "integrators/warnings/out_of_reach.h"

#include "framework/transport/ray_tools.h"
#include "integrators/choice/choose.h"
#include "integrators/photons/photon_maps.h"
#include "integrators/pilot/caustic_need.h"
#include "integrators/warnings/methods.h"
#include "integrators/warnings/seen_pixels.h"

#include <limits>

namespace etendue {

namespace {

constexpr double few_photons = 1 / 200.0;  // of those emitted, that leave small things out

// Is a light so far from what is seen that of photons it sends everywhere one in 14,000 gets there?
bool has_distant_light(const RenderContext& context) {
  constexpr float far = 30;  // times the extent of what is seen
  const Scene& scene = context.scene;
  std::vector<Bounds> of_pixel(asked_pixels);
  for_asked_pixels(context, [&](const Ray& ray, std::size_t pixel) {
    const Hit hit = trace(context, ray);
    if (hit && scene.surface_at(ray, hit).light == no_id) of_pixel[pixel].extend(ray.at(hit.t));
  });
  Bounds seen;
  for (const Bounds& b : of_pixel)
    if (!b.empty()) seen.extend(b);
  if (seen.empty()) return false;
  return std::ranges::any_of(scene.lights, [&](const Light& light) {
    const auto* area = std::get_if<AreaLight>(&light);
    const auto* point = std::get_if<PointLight>(&light);
    if (!area && !point) return false;
    const vec3 at = area ? scene.objects[0].geometry.primitive_bounds(area->primitive).centre() : point->position;
    return glm::length(at - seen.centre()) > far * glm::length(seen.diagonal());
  });
}

// Do mirrors or glass show light that came by way of others, whose lights the pilot's paths met too seldom, or never? A
// bidirectional path cannot be joined between two specular surfaces.
bool hides_caustics(const PilotFindings& found) {
  constexpr double seldom = 0.01;  // rays that meet such a light, over its share of all light
  return found.caustic_photons >= fewest_caustics && found.by_specular * found.caustic_light >= least_caustic_light &&
         (found.caustic_hits < seldom * found.caustic_light || found.unmet_caustics >= least_caustic_light);
}

// The share of all light that comes by way of frosted glass that is nearly smooth: what fewer photons bring as caustics where
// they follow delta lobes alone.
double frosted_caustics(const RenderContext& context, const PilotFindings& found) {
  return has_nearly_smooth_glass(context.scene) ? found.caustic_light - run_pilot(context, 0).caustic_light : 0;
}

}  // namespace

std::string light_out_of_reach(const RenderContext& context, const std::string& method, const ParamMap& params) {
  constexpr std::array by_chance{"path", "guided"};
  constexpr std::array by_light_paths{"light-trace", "vcm"};
  constexpr std::array by_photons{"photon-map", "ppm", "sppm", "ppm-memoryless", "appm", "cppm", "photon-cache"};
  const bool guided = is_among(by_photons, method) && params.contains("emission") && !is_set(params, "emission", "power");
  const bool by_paths = is_among(by_light_paths, method) && !is_bdpt(context, method, params);
  if (by_paths || is_among(by_photons, method)) {
    const PilotFindings found = run_pilot(context);
    // Emission is guided by photons that landed where they are seen.
    const double enough = guided ? std::numeric_limits<double>::min() : few_photons;
    if (context.lights.empty() || found.surface == 0 || found.photons_seen >= enough) return "";
    const std::string share = found.photons_seen > 0 ? fmt::format("one photon in {:.0f} lands", 1 / found.photons_seen)
                                                     : "no photon of a pilot lands";
    const bool may_guide = is_among(by_photons, method) && !guided;
    return fmt::format("{}: {} where the camera sees it, too few for light and shadow of what is small; {}bdpt needs none",
                       method, share, may_guide ? "emission = \"visibility\" may guide them there, and " : "");
  }
  if (!may_cast_caustics(context)) return "";
  // A map takes photons from mirrors and glass alone.
  const bool without = is_among(by_caustic_map, method) &&
                       (!context.needs.caustic_map || is_set(params, "caustic_map", name_of(CausticMap::off)));
  const bool by_either = method == "bdpt" || (is_among(by_caustic_map, method) && !without);
  if (by_either) {
    const PilotFindings found = run_pilot(context);
    if (method == "bdpt" && hides_caustics(found))
      return fmt::format("{}: caustics that are seen by way of specular surfaces are left out, or noise; vcm brings them",
                         method);
    const std::string caustics = method != "bdpt" ? caustics_out_of_reach(context, found, method) : "";
    if (!caustics.empty() && frosted_caustics(context, found) >= least_caustic_light)
      return caustics + " (a caustic map takes no photons from frosted glass)";
    if (context.lights.empty() || found.photons_seen > 0 || !(found.path_error > 0) || !has_distant_light(context)) return "";
    return fmt::format(
        "{}: no photon of a pilot lands where the camera sees it: light that comes by way of specular surfaces is noise, or "
        "left out; a light at infinity in the place of a distant one sends its photons to the scene",
        method);
  }
  if (!(is_among(by_chance, method) || without)) return "";
  return caustics_out_of_reach(context, run_pilot(context), method);
}

}  // namespace etendue
