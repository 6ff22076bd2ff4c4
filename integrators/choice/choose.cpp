#include "integrators/choice/choose.h"

#include "framework/transport/ray_tools.h"
#include "integrators/bidirectional/vcm.h"
#include "integrators/choice/coinciding.h"
#include "integrators/choice/seen_pixels.h"
#include "integrators/photons/photon_maps.h"

#include <algorithm>
#include <array>
#include <limits>

namespace etendue {

namespace {

// Where the lines are drawn comes from ten methods over 33 scenes, most of them at 48 x 48 and 128 x 128 pixels, which are hard
// on caches and kind to them: records serve all pixels, a path one. experiments/auto.toml judges the lines by all methods.
constexpr double default_iterations = 64;
constexpr double rare_hits = 0.03;         // caustic hits over caustic light below which paths find too little of it
constexpr double rare_photons = 0.02;      // of those emitted, that land on what is seen
constexpr double few_photons = 1 / 250.0;  // that they leave small things out
constexpr double certain = 10;             // so much more noise than all else, where few photons tell of them
constexpr double even_caustics = 1.5, minor_caustics = 0.3, many_rays = 1500;
constexpr double entirely_even = 1.05;  // contrast of light that ends at borders alone
constexpr double noisy_direct = 3;      // noise of direct light, sampled at lights, over that of paths, which meet them as well
constexpr double long_time = 4000;      // rays a pixel after which what radii lose at borders is more than bdpt's noise
constexpr double much_direct = 0.6;     // of the light: there is little to share,
constexpr double all_direct_noise = 0.8;  // if this share of what paths leave is the noise of direct light
constexpr double little_noise = 0.2;      // of a path, below which records' own error outweighs it
constexpr double no_noise = 1e-6;         // of an image: less than what stored light is off by
constexpr double fewest_diffuse = 0.3;
constexpr double mostly_caustic = 0.5;  // of the light: then what records gather over a hemisphere is worth more than sharing
constexpr double hidden_light = 9;      // path error over direct error from which indirect light is hard to find,
constexpr double known_well = 2e-4;     // unless there is time for records to know it as well as this
constexpr double far_hidden = 16;       // the same, from which photons find it sooner if one or more of each path
constexpr double photons_in_view = 1;   // land in view
constexpr double rays_per_record = 4000;
constexpr double most_fill = 0.6;     // of the budget for records: beyond it hash-cache errs less,
constexpr double fair_noise = 0.065;  // where paths leave no more than this

double pixels_of(ivec2 resolution) { return static_cast<double>(resolution.x) * resolution.y; }

class Chooser {
 public:
  Chooser(const RenderContext& context, const PilotFindings& findings, BiasAllowed bias)
      : context_(context), found_(findings), bias_(bias), rays_(rays_a_pixel(context.effort, context.resolution, findings)) {}

  MethodChoice choose() const {
    if (context_.lights.empty() || found_.surface == 0)
      return {
          "path", {}, "no light reaches a rough surface that the camera sees, so that there is nothing to cache or to gather"};
    if (caustics_are_hard() || caustics_are_unmet()) return for_caustics();
    if (noise_of_paths() < no_noise)
      return {"path", {}, "paths leave so little noise that nothing stored between them could have less error"};
    if ((found_.direct_light >= much_direct || found_.photons_seen == 0 || photons_are_blind()) &&
        found_.direct_error >= all_direct_noise * found_.path_error)
      return {"path", {}, "the noise of direct light is all that paths leave, and no method samples that better"};
    if (found_.diffuse < fewest_diffuse)
      return {
          "path", {}, fmt::format("{} of what is seen is diffuse, which is all that caches serve", percent(found_.diffuse))};
    return for_indirect_light();
  }

  std::string out_of_reach(const std::string& method) const {
    if (!caustics_are_hard() && !caustics_are_unmet()) return "";
    const bool noisy = found_.caustic_hits > 0 && !caustics_are_unmet();
    return fmt::format("{}: {} leaves it {}; cppm brings it", caustics(), method, noisy ? "noisy" : "out");
  }

 private:
  // This is what paths leave at the end of the budget, at one ray's time for each of theirs.
  double noise_of_paths() const { return found_.path_error * std::max(1.0, found_.rays_per_path) / rays_; }

  // A record would be off by this if all of the budget were paths from the records.
  double noise_of_records() const { return noise_of_paths() * found_.records / pixels_of(context_.resolution); }

  // So many rays a pixel fill a cache.
  double fill() const { return found_.records * rays_per_record / pixels_of(context_.resolution); }

  // Light that arrives by way of specular surfaces, and that paths from the camera meet too seldom to learn its brightness
  // from. What falls on glossy surfaces does not tell: paths follow the lobes that send light on to the camera.
  bool caustics_are_hard() const {
    const double light = found_.caustic_light;
    if (found_.diffuse < fewest_diffuse) return false;
    if (!context_.needs.caustic_map || light < least_caustic_light || found_.caustic_hits >= rare_hits * light) return false;
    // What they leave as noise: one path in 1 / hits brings the light of as many, and where it falls it is so much denser.
    const double noise = light * light * found_.caustic_contrast / std::max(found_.caustic_hits, 1.0 / 16384);
    if (photons_are_blind()) return false;
    return noise >= (found_.caustic_photons >= fewest_caustics ? 1 : certain) * found_.path_error;
  }

  // Light by way of specular surfaces that paths leave out however well they meet that of other lights there: from points,
  // spots and directions, and from small lamps.
  bool caustics_are_unmet() const {
    return context_.needs.caustic_map && found_.unmet_caustics >= least_caustic_light && !photons_are_blind();
  }

  // Photons of which hardly any lie in view may all have landed beside it: paths see other light than they tell of.
  bool photons_are_blind() const {
    const double met = found_.caustic_light - found_.unmet_caustics;
    return found_.caustic_photons < fewest_caustics && met >= mostly_caustic && found_.caustic_hits == 0 &&
           found_.path_error > 0;
  }

  std::string caustics() const {
    if (!caustics_are_hard())
      return fmt::format(
          "{} of the light on what is seen comes from points, spots, directions or small lamps by way of specular surfaces, "
          "where no path finds it",
          percent(found_.unmet_caustics));
    return fmt::format("{} of the light on what is seen comes by way of specular surfaces, where {}",
                       percent(found_.caustic_light),
                       found_.caustic_hits > 0 ? "paths seldom find it" : "paths do not find it");
  }

  MethodChoice for_caustics() const {
    const std::string light = caustics();
    if (bias_ == BiasAllowed::none) return {"bdpt", {}, light + ", and bdpt is the unbiased method that finds most of it"};
    if (!caustics_are_hard() && found_.direct_error >= noisy_direct * found_.path_error && found_.path_error > 0)
      return {"bdpt", {}, light + ", and bdpt brings it, and all other light with as little noise as paths"};
    // A few photons do not tell whether it is even.
    const double contrast = found_.caustic_photons >= fewest_caustics ? found_.caustic_contrast : infinity;
    if (contrast < entirely_even && found_.surface < 1) {
      if (found_.path_error == 0 && found_.by_specular == 0 && rays_ >= long_time)
        return {"bdpt", {}, light + ", there is no other, and in the end radii lose more of it at borders than bdpt has noise"};
      return {"sppm", {}, light + ", and it is even up to borders in view, where radii would shrink late by a test"};
    }
    if (bias_ == BiasAllowed::any && contrast < even_caustics && found_.caustic_light < minor_caustics && rays_ >= many_rays)
      return {"photon-cache", {}, light + ", it is even, and there is time for a map and records"};
    return {"cppm", {}, light + ", and photons' radii need shrink only where a test finds it uneven"};
  }

  MethodChoice for_indirect_light() const {
    if (bias_ == BiasAllowed::none)
      return {"path", {}, "no unbiased method is faster where light needs no specular surface to get there"};
    const double hidden = found_.direct_error > 0 ? found_.path_error / found_.direct_error : infinity;
    if (hidden >= far_hidden && found_.photons_seen >= photons_in_view)
      return {"sppm",
              {},
              "indirect light leaves nearly all of the noise that paths have, and of each path of photons one or more land in "
              "view"};
    if (hidden >= hidden_light && found_.caustic_light < mostly_caustic && noise_of_records() >= known_well)
      return {
          "hash-cache",
          {},
          "indirect light leaves nearly all of the noise that paths have, and paths that share it through a hash grid learn "
          "it soonest"};
    if (found_.photons_seen < rare_photons)
      return {"hash-cache",
              {},
              "hardly any of the light that is emitted gets into view, and paths that share it through a hash grid learn it "
              "soonest"};
    if (found_.path_error < little_noise && hidden < hidden_light)
      return {
          "hash-cache", {}, "paths leave so little noise that the error of interpolating between records would outweigh it"};
    if (bias_ == BiasAllowed::vanishing)
      return {"hash-cache", {}, "indirect light on diffuse surfaces can be shared, and of such caches its bias vanishes"};
    const std::string share = fill() < rays_ ? percent(fill() / rays_) : "more than all";
    if (fill() > most_fill * rays_ && noise_of_paths() < fair_noise)
      return {"hash-cache",
              {},
              fmt::format("about {:.0f} records would take {} of the budget, and paths that share light through a hash grid "
                          "need none",
                          found_.records, share)};
    return {"irradiance-cache",
            {},
            fmt::format("indirect light on diffuse surfaces is smooth enough for about {:.0f} records, which take {} of the "
                        "budget",
                        found_.records, share)};
  }

  const RenderContext& context_;
  const PilotFindings& found_;
  BiasAllowed bias_;
  double rays_;  // a pixel
};

}  // namespace

double rays_a_pixel(const Effort& effort, ivec2 resolution, const PilotFindings& findings) {
  const double rays_per_path = std::max(1.0, findings.rays_per_path);
  double rays = infinity;
  if (effort.error > 0) rays = 0.1 * rays_per_path * findings.path_error / effort.error;
  if (effort.iterations > 0) rays = std::min(rays, rays_per_path * static_cast<double>(effort.iterations));
  if (effort.seconds > 0) rays = std::min(rays, effort.seconds * rays_per_second / pixels_of(resolution));
  return rays < infinity ? rays : rays_per_path * default_iterations;
}

MethodChoice choose_method(const RenderContext& context, const PilotFindings& findings, BiasAllowed bias) {
  return Chooser(context, findings, bias).choose();
}

namespace {

constexpr std::array by_caustic_map{"irradiance-cache", "radiance-cache", "hash-cache"};

bool is_among(std::span<const char* const> names, const std::string& method) {
  return std::ranges::find(names, method) != names.end();
}

bool is_set(const ParamMap& params, const char* name, std::string_view value) {
  const auto param = params.find(name);
  return param != params.end() && to_text(param->second) == value;
}

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

// Does the method do what bdpt does?
bool is_bdpt(const RenderContext& context, const std::string& method, const ParamMap& params) {
  const auto is_given = [&](const char* name) { return params.contains(name) && !is_set(params, name, "0"); };
  const bool asked = is_given("radius") || is_given("neighbours");
  return method == "bdpt" || (method == "vcm" && !asked && neighbours_by_need(context) == 0);
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
  const bool without = is_among(by_caustic_map, method) && is_set(params, "caustic_map", name_of(CausticMap::off));
  if (!context.needs.caustic_map) return "";
  const bool by_either = method == "bdpt" || (is_among(by_caustic_map, method) && !without);
  if (by_either) {
    const PilotFindings found = run_pilot(context);
    if (context.lights.empty() || found.photons_seen > 0 || !(found.path_error > 0) || !has_distant_light(context)) return "";
    return fmt::format(
        "{}: no photon of a pilot lands where the camera sees it: light that comes by way of specular surfaces is noise, or "
        "left out; a light at infinity in the place of a distant one sends its photons to the scene",
        method);
  }
  if (!(is_among(by_chance, method) || without)) return "";
  return Chooser(context, run_pilot(context), BiasAllowed::any).out_of_reach(method);
}

std::string surfaces_mixed(const RenderContext& context, const std::string& method, const ParamMap& params) {
  constexpr std::array keeps_apart{"path", "light-trace", "guided"};
  const bool gathers_caustics = is_set(params, "caustic_map", name_of(CausticMap::on)) ||
                                (context.needs.caustic_map && !is_set(params, "caustic_map", name_of(CausticMap::off)));
  if (!context.needs.masks || is_among(keeps_apart, method) || is_bdpt(context, method, params)) return "";
  if (is_among(by_caustic_map, method) && !gathers_caustics) return "";  // records keep them apart
  const float near = 0.01f * glm::length(context.scene.bounds().diagonal());
  const double share = share_of_pixels(context, [&](const Ray& ray, std::size_t) {
    const Hit seen = trace(context, ray);
    if (!seen) return false;
    const SurfacePoint point = context.scene.surface_at(ray, seen);
    for (const vec3& side : {point.normal, -point.normal}) {
      const Hit other = trace(context, spawn_ray(point, side, near));
      if (!other) continue;
      const Layer layer = context.scene.layer_at(other);
      if (lets_light_through(point.layer | layer) && share_light(point.layer, layer)) return true;
    }
    return false;
  });
  if (share < fewest_pixels) return "";
  return fmt::format(
      "{} of what is seen are surfaces of one shape, less than 1 % of the scene's size apart, that let a part of the light "
      "through: {} may take light on one for light on the other; path keeps them apart",
      percent(share), method);
}

std::string surfaces_coincide(const RenderContext& context) {
  constexpr int most = 8;
  const std::vector<Material>& materials = context.scene.materials;
  const auto is_glass = [](const Material& m) { return std::holds_alternative<Dielectric>(m); };
  const bool has_glass = std::ranges::any_of(materials, is_glass);
  std::vector<std::vector<SurfacePoint>> seen(has_glass ? asked_pixels : 0);
  // Straight on through glass, to what lies beneath.
  double share = share_of_pixels(context, [&](Ray ray, std::size_t pixel) {
    std::optional<SurfacePoint> last;
    for (int met = 0; met < most; ++met) {
      const Hit hit = trace(context, ray);
      if (!hit) return false;
      const SurfacePoint point = context.scene.surface_at(ray, hit);
      const auto height = [&] { return std::abs(glm::dot(point.position - last->position, point.normal)); };
      if (last && last->material != point.material && height() < point.clearance) return true;
      if (last && !is_glass(materials[last->material])) return false;
      if (has_glass) seen[pixel].push_back(point);
      last = point;
      ray.t_min = std::max(hit.t, std::nextafter(ray.t_min, infinity));
    }
    return false;
  });
  if (share < fewest_pixels && has_glass) {
    const std::vector<bool> exactly = coincide_with_others(context.scene, seen);
    share = static_cast<double>(std::ranges::count(exactly, true)) / asked_pixels;
  }
  if (share < fewest_pixels) return "";
  return fmt::format(
      "{} of what is seen are surfaces of different materials in one place, as far as rounding tells: "
      "which of them a ray meets is chance, and light is lost there; move one off the other",
      percent(share));
}

}  // namespace etendue
