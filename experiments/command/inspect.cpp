// `etendue inspect`: what a scene holds, and what of the machinery it needs.
#include "experiments/command/advice.h"
#include "experiments/command/commands.h"
#include "experiments/command/console.h"
#include "experiments/kinds/claims/measurement.h"
#include "experiments/log/json_line.h"
#include "experiments/run/memory_forecast.h"
#include "framework/core/units.h"
#include "framework/io/load_scene.h"
#include "framework/scene/needs.h"
#include "integrators/registry.h"

#include <fmt/format.h>

namespace etendue {

namespace {

struct Contents {
  std::uint64_t triangles = 0, quadrics = 0, shapes = 0;
  std::uint64_t stored_triangles = 0;  // each object once, however often it stands in the scene
};

Contents count_contents(const Scene& scene) {
  Contents contents;
  contents.triangles = scene.triangle_count();
  for (const Object& object : scene.objects) {
    contents.stored_triangles += object.geometry.triangles.size();
    contents.shapes += object.shapes.size();
  }
  for (const Instance& instance : scene.instances) contents.quadrics += scene.objects[instance.object].geometry.quadrics.size();
  return contents;
}

// Tells what a scene is spared that lacks a thing: time with it over time without, as experiments/contents.toml measures it.
struct Spared {
  std::string name, text;
  Measured factor;
};

std::vector<Spared> measure_spared(const std::string& scene, const Bounds& bounds, const SceneReading& reading) {
  if (bounds.empty()) throw Error("--measure: nothing to time in a scene without shapes of finite extent");
  Console console;
  std::vector<Spared> spared;
  MeasureTask task{.scene = scene, .resolution = 128, .repetitions = 9, .reading = reading};
  for (const char* name : {"contents-in-rays", "contents-in-images"}) {
    const Measurement& measurement = find_measurement(name, {});
    task.progress = [&](double share) { console.status(fmt::format("{} {:.0f} %", measurement.summary, 100 * share)); };
    const MeasureResult result = measurement.run(task);
    if (result.disagreements > 0)
      throw Error(fmt::format("--measure: {} rays are answered otherwise once something is added", result.disagreements));
    for (const auto& [quantity, factor] : result.figures)
      spared.push_back({quantity, measurement.quantity(quantity)->text, factor});
  }
  console.clear_status();
  return spared;
}

// --- advice ---

std::string label_of(const MethodChoice& choice) { return Method{choice.name, choice.params}.label(); }

constexpr double default_advice_s = 4;

// The relMSE whose times are told.
std::vector<double> told_errors(const InspectCommand& command) {
  return command.error ? std::vector{*command.error} : std::vector{1e-2, 1e-3, 1e-4};
}

Json advice_json(const Advice& advice, const InspectCommand& command) {
  const PilotFindings& f = advice.findings;
  Json json{{"budget", advice.budget},
            {"method", label_of(advice.method)},
            {"method_why", advice.method.why},
            {"accel", label_of(advice.structure)},
            {"accel_why", advice.structure.why},
            {"accel_build_s", advice.build_s},
            {"accel_bytes", advice.structure_bytes},
            {"pilot",
             {{"rays", f.rays},
              {"surface", f.surface},
              {"diffuse", f.diffuse},
              {"by_specular", f.by_specular},
              {"path_error", f.path_error},
              {"direct_error", f.direct_error},
              {"rays_per_path", f.rays_per_path},
              {"photons_seen", f.photons_seen},
              {"direct_light", f.direct_light},
              {"caustic_light", f.caustic_light},
              {"unmet_caustics", f.unmet_caustics},
              {"caustic_hits", f.caustic_hits},
              {"caustic_contrast", f.caustic_contrast},
              {"records", f.records}}},
            {"hazards", advice.hazards}};
  if (const auto& noise = advice.noise) {
    json["memory_bytes"] = noise->memory_bytes;
    json["trial"] = {{"relmse", noise->relmse},
                     {"iterations", noise->iterations},
                     {"prepare_s", noise->prepare_s},
                     {"iteration_s", noise->iteration_s}};
    for (const double error : told_errors(command))
      json["expected"].push_back({{"relmse", error}, {"time_s", noise->seconds_to(error)}});
  }
  return json;
}

std::string advice_lines(const Advice& advice, const InspectCommand& command) {
  std::string text = fmt::format("advice for {}\n", advice.budget);
  const auto add = [&](const char* what, const std::string& value) { text += fmt::format("  {:<14}{}\n", what, value); };
  add("method", label_of(advice.method));
  add("", advice.method.why);
  add("structure", fmt::format("{}, {} in {}", label_of(advice.structure),
                               format_bytes(static_cast<double>(advice.structure_bytes)), format_seconds(advice.build_s)));
  add("", advice.structure.why);
  if (const auto& noise = advice.noise) {
    add("time", joined(told_errors(command), ", ", [&](double error) {
          return fmt::format("relmse {:g} after about {}", error, format_seconds(noise->seconds_to(error)));
        }));
    add("", fmt::format("on this machine; by the noise of two trials ({:.2g}), in which no bias shows", noise->relmse));
    add("memory", fmt::format("{} at most in the trials, scene and image included",
                              format_bytes(static_cast<double>(noise->memory_bytes))));
  }
  for (const std::string& hazard : advice.hazards) add("hazard", hazard);
  return text;
}

// --- memory ---

// The memory that is foreseen at the scene's resolution, in the default structure and with the methods' default settings: the
// parts of path tracing, which all of them have, and the sum with each method.
struct ForeseenMemory {
  MemoryForecast common;
  std::vector<std::pair<std::string, double>> methods;  // bytes in all
};

ForeseenMemory foresee_memory(const Scene& scene, const SceneNeeds& needs) {
  const auto with = [&](const std::string& method) {
    return forecast_memory(scene, needs, default_accel(), {method, {}}, scene.resolution);
  };
  ForeseenMemory foreseen{with("path"), {}};
  for (const IntegratorEntry& entry : integrators()) foreseen.methods.emplace_back(entry.name, with(entry.name).bytes());
  return foreseen;
}

std::string memory_lines(const ForeseenMemory& foreseen) {
  constexpr std::size_t columns = 3;
  std::string text = fmt::format("memory (predicted, default settings)\n  {}; in all, with\n", foreseen.common.text());
  for (std::size_t i = 0; i < foreseen.methods.size(); ++i) {
    const auto& [method, bytes] = foreseen.methods[i];
    const bool ends = i % columns == columns - 1 || i + 1 == foreseen.methods.size();
    text += fmt::format("  {:<17}{:>10}{}", method, format_bytes(bytes), ends ? "\n" : "  ");
  }
  return text;
}

Json memory_json(const ForeseenMemory& foreseen) {
  Json json;
  for (const MemoryPart& part : foreseen.common.parts)
    if (part.bytes > 0) json["parts"].push_back({{"what", part.name}, {"bytes", part.bytes}});
  for (const auto& [method, bytes] : foreseen.methods) json["methods"][method] = bytes;
  return json;
}

Json vector_json(const vec3& v) { return Json::array({v.x, v.y, v.z}); }

Bounds bounds_in_file(const Scene& scene) {
  const Bounds bounds = scene.bounds();
  return bounds.empty() ? bounds : Bounds{bounds.lower + scene.origin, bounds.upper + scene.origin};
}

Json to_json(const std::string& name, const Scene& scene, const SceneNeeds& needs, const std::vector<Spared>& spared) {
  const Contents contents = count_contents(scene);
  const Bounds bounds = bounds_in_file(scene);
  Json json{{"scene", name},
            {"hash", fmt::format("{:016x}", scene.hash())},
            {"triangles", contents.triangles},
            {"stored_triangles", contents.stored_triangles},
            {"quadrics", contents.quadrics},
            {"planes", scene.planes.size()},
            {"objects", scene.objects.size() - 1},
            {"instances", scene.instances.size() - 1},
            {"shapes", contents.shapes},
            {"materials", scene.materials.size()},
            {"textures", scene.textures.size()},
            {"lights", scene.lights.size()},
            {"resolution", {scene.resolution.x, scene.resolution.y}}};
  if (!bounds.empty()) json["bounds"] = {{"lower", vector_json(bounds.lower)}, {"upper", vector_json(bounds.upper)}};
  if (scene.max_depth) json["max_depth"] = *scene.max_depth;
  if (scene.closed_form) json["closed_form"] = scene.closed_form->source;
  json["needs"] = Json::array();
  for (const auto& line : needs.lines(scene))
    json["needs"].push_back({{"what", line.what}, {"needed", line.needed}, {"why", line.why}});
  json["memory"] = memory_json(foresee_memory(scene, needs));
  for (const Spared& s : spared)
    json["spared"].push_back(
        {{"what", s.name}, {"factor", s.factor.median}, {"low", s.factor.low}, {"high", s.factor.high}, {"of", s.text}});
  json["warnings"] = scene.warnings;
  return json;
}

std::string to_lines(const std::string& name, const Scene& scene, const SceneNeeds& needs, const std::vector<Spared>& spared) {
  const Contents contents = count_contents(scene);
  const Bounds bounds = bounds_in_file(scene);
  std::string text = fmt::format("{}  ({:016x})\n", name, scene.hash());
  const auto add = [&](const char* what, const std::string& value) { text += fmt::format("  {:<14}{}\n", what, value); };
  add("triangles", contents.stored_triangles == contents.triangles
                       ? format_count(static_cast<double>(contents.triangles))
                       : fmt::format("{} ({} stored)", format_count(static_cast<double>(contents.triangles)),
                                     format_count(static_cast<double>(contents.stored_triangles))));
  add("quadrics", std::to_string(contents.quadrics));
  add("planes", std::to_string(scene.planes.size()));
  // Those that are instanced: the first of either is the world.
  add("objects",
      fmt::format("{}, instances {}, shapes {}", scene.objects.size() - 1, scene.instances.size() - 1, contents.shapes));
  add("materials", fmt::format("{}, textures {}", scene.materials.size(), scene.textures.size()));
  add("lights", std::to_string(scene.lights.size()));
  if (!bounds.empty())
    add("bounds", fmt::format("({:.4g}, {:.4g}, {:.4g}) .. ({:.4g}, {:.4g}, {:.4g}) m", bounds.lower.x, bounds.lower.y,
                              bounds.lower.z, bounds.upper.x, bounds.upper.y, bounds.upper.z));
  add("resolution", fmt::format("{} x {}", scene.resolution.x, scene.resolution.y));
  add("depth",
      scene.max_depth ? fmt::format("{} scattering events", *scene.max_depth) : "64 scattering events (the scene states none)");
  add("reference", scene.closed_form ? "closed form: " + scene.closed_form->source : "none: rendered where one is needed");
  text += "needs\n";
  for (const auto& line : needs.lines(scene))
    text += fmt::format("  {:<4}{:<20} {}\n", line.needed ? "yes" : "no", line.what, line.why);
  text += memory_lines(foresee_memory(scene, needs));
  if (!spared.empty()) text += "spared (CPU time with it over without; median and quartiles)\n";
  for (const Spared& s : spared)
    text +=
        fmt::format("  {:<12} {:.3f}x ({:.3f} to {:.3f})  {}\n", s.name, s.factor.median, s.factor.low, s.factor.high, s.text);
  if (!scene.warnings.empty()) text += "warnings\n";
  for (const std::string& warning : scene.warnings) text += fmt::format("  {}\n", warning);
  return text;
}

}  // namespace

int inspect_command(const InspectCommand& command) {
  if (command.all) return inspect_all(command);
  const Scene scene = load_scene(command.scene, {"command line"}, command.reading);
  const SceneNeeds needs = scene_needs(scene);
  exit_on_interrupt("\ninterrupted\n");
  std::optional<Advice> advice;
  if (command.pilot) {
    Console console;
    Budget budget{.time_s = command.time_s, .error = command.error};
    if (!budget.time_s && !budget.error) budget.time_s = default_advice_s;
    console.status("a pilot and two trials");
    advice = advise(scene, needs, budget, available_threads(command.threads, console));
    console.clear_status();
  } else if (command.time_s || command.error || command.threads) {
    throw Error(Location{command.time_s ? "--time" : command.error ? "--error" : "--threads"}, "of no use without --pilot");
  }
  const std::vector<Spared> spared =
      command.measure ? measure_spared(command.scene, scene.bounds(), command.reading) : std::vector<Spared>{};
  if (command.json) {
    Console console;  // a program that reads the rest may not look at these
    for (const std::string& warning : scene.warnings) console.warning(warning);
    Json json = to_json(command.scene, scene, needs, spared);
    if (advice) json["advice"] = advice_json(*advice, command);
    fmt::print("{}\n", dump(json, 2));
  } else
    fmt::print("{}{}", to_lines(command.scene, scene, needs, spared), advice ? advice_lines(*advice, command) : "");
  return 0;
}

}  // namespace etendue
