#include "integrators/choice/choose.h"

#include "framework/core/elementary.h"
#include "framework/core/units.h"
#include "integrators/pilot/caustic_need.h"

#include <algorithm>
#include <limits>

namespace etendue {

namespace {

// The thresholds come from ten methods over 33 scenes, most of them at 48 x 48 and at 128 x 128 pixels. The former are hard on
// caches and the latter kind to them, since records serve all pixels and a path one. experiments/auto.toml judges the
// thresholds by all methods.
constexpr double default_iterations = 64;
constexpr double rare_hits = 0.03;          // caustic hits over caustic light below which paths find too little of it,
constexpr double rare_rough_hits = 0.01;    // and where it comes by rough metals alone, where light samples find it as well
constexpr double rare_photons = 0.02;       // of those emitted, that land on what is seen
constexpr double half_a_hit = 1.0 / 16384;  // of the rays of a whole pilot
constexpr double certain = 10;              // so much more noise than all else, where few photons tell of them
constexpr double even_caustics = 1.5, minor_caustics = 0.3, many_rays = 1500;
constexpr double smooth_caustics = 0.9;            // contrast of light with hardly a border,
constexpr double few_rays = 150, fair_rays = 700;  // a pixel, from which a map knows it: alone, and beside other light
constexpr double no_other_light = 1e-3;            // noise of a path: what it finds then leaves none that would count
constexpr double entirely_even = 1.05;             // contrast of light that ends at borders alone
constexpr double noisy_direct = 3;   // noise of direct light, sampled at lights, over that of paths, which meet them as well
constexpr double long_time = 2500;   // rays a pixel after which what radii lose at borders is more than bdpt's noise
constexpr double much_direct = 0.6;  // of the light: there is little to share,
constexpr double all_direct_noise = 0.8;  // if this share of what paths leave is the noise of direct light
constexpr double little_noise = 0.2;      // of a path, below which records' own error outweighs it,
constexpr double mostly_diffuse = 0.95;   // unless what is seen is all theirs and there is time to refine them
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
      : context_(context),
        found_(findings),
        bias_(bias),
        rays_(rays_a_pixel(context.scene, context.effort, context.resolution, findings)) {}

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
      return {"path",
              {},
              fmt::format("{} of what is seen is diffuse, which is all that caches serve", format_percent(found_.diffuse))};
    return for_indirect_light();
  }

  std::string out_of_reach(const std::string& method) const {
    if (!caustics_are_hard() && !caustics_are_unmet()) return "";
    const char* how = caustics_are_unmet() ? "out" : found_.caustic_hits > 0 ? "noisy" : "noisy, or out";
    return fmt::format("{}: {} leaves it {}; cppm brings it", caustics(), method, how);
  }

 private:
  // This is what paths leave at the end of the budget, at one ray's time for each of theirs.
  double noise_of_paths() const {
    return found_.path_error > 0 ? found_.path_error * std::max(1.0, found_.rays_per_path) / rays_ : 0;
  }

  // A record would be off by this if all of the budget were paths from the records.
  double noise_of_records() const { return noise_of_paths() * found_.records / pixels_of(context_.resolution); }

  // So many rays a pixel fill a cache.
  double fill() const { return found_.records * rays_per_record / pixels_of(context_.resolution); }

  // Light that arrives by way of specular surfaces, and that paths from the camera meet too seldom to learn its brightness
  // from. What falls on glossy surfaces tells only where paths never meet it and it is most of the light: they follow the
  // lobes that send light on to the camera.
  bool caustics_are_hard() const {
    const double light = found_.caustic_light;
    const bool others_lead = found_.path_error > 0 && (found_.caustic_photons < fewest_caustics || light < mostly_caustic);
    if (found_.diffuse < fewest_diffuse && (found_.caustic_hits > 0 || others_lead)) return false;
    const double rare = may_cast_caustics(context_) ? rare_hits : rare_rough_hits;
    if (light < least_caustic_light || found_.caustic_hits >= rare * light) return false;
    // What they leave as noise: one path in 1 / hits brings the light of as many, and where it falls it is so much denser.
    const double noise = light * light * found_.caustic_contrast / std::max(found_.caustic_hits, half_a_hit / found_.share);
    if (photons_are_blind()) return false;
    return noise >= (found_.caustic_photons >= fewest_caustics ? 1 : certain) * found_.path_error;
  }

  // Light by way of specular surfaces that paths leave out however well they meet that of other lights there: from points,
  // spots and directions, and from small lamps.
  bool caustics_are_unmet() const {
    return may_cast_caustics(context_) && found_.unmet_caustics >= least_caustic_light && !photons_are_blind();
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
          "{} of the light on what is seen comes from delta lights or small lamps by way of specular surfaces, "
          "where no path finds it",
          format_percent(found_.unmet_caustics));
    return fmt::format("{} of the light on what is seen comes by way of {}specular surfaces, where {}",
                       format_percent(found_.caustic_light), may_cast_caustics(context_) ? "" : "nearly ",
                       found_.caustic_hits > 0 ? "paths seldom find it"
                       : caustics_are_unmet()  ? "paths do not find it"
                                               : "none of a pilot's paths finds it");
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
    const bool minor = contrast < even_caustics && found_.caustic_light < minor_caustics && rays_ >= many_rays;
    const double soon = found_.path_error > 0 ? fair_rays : few_rays;
    const bool alone = contrast < smooth_caustics && found_.path_error < no_other_light && rays_ >= soon;
    if (bias_ == BiasAllowed::any && (minor || alone))
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
    const bool refined = found_.diffuse >= mostly_diffuse && rays_ >= long_time;
    if (found_.path_error < little_noise && hidden < hidden_light && !refined) {
      if (bias_ == BiasAllowed::any && found_.photons_seen >= photons_in_view)
        return {
            "photon-cache",
            {},
            "paths leave little noise, and gather rays into a map leave less, as of each path of photons one or more land in "
            "view"};
      return {
          "hash-cache", {}, "paths leave so little noise that the error of interpolating between records would outweigh it"};
    }
    if (bias_ == BiasAllowed::vanishing)
      return {"hash-cache", {}, "indirect light on diffuse surfaces can be shared, and of such caches its bias vanishes"};
    const std::string share = fill() < rays_ ? format_percent(fill() / rays_) : "more than all";
    if (fill() > most_fill * rays_ && noise_of_paths() < fair_noise)
      return {"hash-cache",
              {},
              fmt::format("about {:.0f} records would take {} of the budget, and paths that share light through a hash grid "
                          "need none",
                          found_.records, share)};
    if (fill() >= rays_)
      return {"irradiance-cache",
              {},
              fmt::format("indirect light on diffuse surfaces is smooth, though the budget ends before its {:.0f} records are "
                          "made",
                          found_.records)};
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

double rays_a_pixel(const Scene& scene, const Effort& effort, ivec2 resolution, const PilotFindings& findings) {
  const double rays_per_path = std::max(1.0, findings.rays_per_path);
  double rays = infinity;
  if (effort.error > 0) rays = 0.1 * rays_per_path * findings.path_error / effort.error;
  if (effort.iterations > 0) rays = std::min(rays, rays_per_path * static_cast<double>(effort.iterations));
  if (effort.seconds > 0) {
    double triangles = 0;
    for (const Object& object : scene.objects) triangles += static_cast<double>(object.geometry.triangles.size());
    const double left = std::max(0.1 * effort.seconds, effort.seconds - build_seconds * triangles);
    const double slower = 1 + 0.25 * math::log2(1 + triangles / 1000);
    rays = std::min(rays, left * rays_per_second / (slower * pixels_of(resolution)));
  }
  return rays < infinity ? rays : rays_per_path * default_iterations;
}

double usual_rays_per_path(const Scene& scene) {
  const double whole = scene.bounds().half_area();
  if (!scene.planes.empty() || !(whole > 0)) return most_usual_rays;
  std::vector<Bounds> bounds(scene.objects.size());
  std::vector<double> boxes;  // those a line meets in an object's bounds, in the mean
  for (std::size_t o = 0; o < bounds.size(); ++o) {
    const Geometry& geometry = scene.objects[o].geometry;
    double area = 0;
    for (std::uint32_t i = 0; i < geometry.primitive_count(); ++i) {
      if (!geometry.is_valid(i)) continue;
      const Bounds box = geometry.primitive_bounds(i);
      bounds[o].extend(box);
      area += box.half_area();
    }
    boxes.push_back(bounds[o].half_area() > 0 ? area / bounds[o].half_area() : 1);
  }
  double crossed = 0;
  for (const Instance& instance : scene.instances)
    crossed += boxes[instance.object] * instance.to_world.bounds(bounds[instance.object]).half_area() / whole;
  return 1 + (most_usual_rays - 1) * std::min(crossed, 1.0);
}

double rays_before_paths(const Scene& scene, const Effort& effort, ivec2 resolution) {
  const bool by_time = effort.seconds > 0 && effort.iterations == 0;
  return rays_a_pixel(scene, effort, resolution,
                      {.path_error = 10, .rays_per_path = by_time ? most_usual_rays : usual_rays_per_path(scene)});
}

PilotFindings run_pilot_within_effort(const RenderContext& context) {
  constexpr double of_photons = 50000, of_the_rest = 150000, share_of_effort = 1.0 / 12;
  const double rays = pixels_of(context.resolution) * rays_before_paths(context.scene, context.effort, context.resolution);
  return run_pilot(context, 0.25f, std::clamp((share_of_effort * rays - of_photons) / of_the_rest, least_pilot, 1.0));
}

std::string caustics_out_of_reach(const RenderContext& context, const PilotFindings& findings, const std::string& method) {
  return Chooser(context, findings, BiasAllowed::any).out_of_reach(method);
}

MethodChoice choose_method(const RenderContext& context, const PilotFindings& findings, BiasAllowed bias) {
  return Chooser(context, findings, bias).choose();
}

}  // namespace etendue
