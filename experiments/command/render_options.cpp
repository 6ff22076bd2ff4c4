// The options of `etendue render`, and of the image that --from repeats.
#include "experiments/command/render_files.h"
#include "experiments/command/rendering.h"
#include "experiments/report/report_text.h"
#include "experiments/report/surface_images.h"
#include "framework/core/units.h"
#include "framework/io/image/exr.h"

#include <fmt/format.h>
#include <algorithm>
#include <filesystem>

namespace etendue {

namespace {

constexpr std::uint64_t default_samples = 64;
constexpr double default_error_limit_s = 600;  // --error alone: a target out of reach must end some time

// "-p photons=200k" goes to the integrator, "-p accel.bins=32" to the structure.
void read_parameters(const RenderCommand& command, Method& integrator, Method& accel) {
  constexpr std::string_view prefix = "accel.";
  for (const std::string& assignment : command.params) {
    const Location where{"-p " + assignment};
    const auto equals = assignment.find('=');
    if (equals == std::string::npos || equals == 0) throw Error(where, "expected key=value, such as max_depth=8");
    std::string key = assignment.substr(0, equals);
    Method& method = key.starts_with(prefix) ? accel : integrator;
    if (&method == &accel) key.erase(0, prefix.size());
    method.params[key] = parse_param_value(assignment.substr(equals + 1), where);
  }
}

Budget read_budget(const RenderCommand& command) {
  Budget budget;
  budget.checkpoints.linear = 1;
  budget.samples = command.spp;
  budget.time_s = command.time_s;
  budget.error = command.error;
  if (!budget.samples && !budget.time_s) {
    if (budget.error)
      budget.time_s = default_error_limit_s;
    else
      budget.samples = default_samples;
  }
  return budget;
}

std::string output_path(const RenderCommand& command, const std::string& scene, const std::string& integrator) {
  if (!command.output.empty() || command.json) return command.output;
  if (!command.from.empty()) return std::filesystem::path(command.from).stem().string() + "-again.exr";
  return slug(scene) + "-" + slug(integrator) + ".exr";
}

void check_aovs(const RenderCommand& command, const Rendering& r) {
  std::vector<std::string> names{records_aov, standard_error_aov};
  names.insert(names.end(), surface_image_names().begin(), surface_image_names().end());
  for (const std::string& aov : command.aovs) {
    const Location where{"--aov " + aov};
    if (std::ranges::find(names, aov) == names.end()) throw Error(where, unknown_name("aov", aov, names));
    if (r.output.empty()) throw Error(where, "is written beside the image; expected -o as well");
    if (is_surface_image(aov)) continue;
    require_cache(r.integrator, where.file, aov == records_aov ? "has no records to show" : "does not estimate its own error");
  }
}

// Files are tried before the rendering, not after it.
void check_files(const RenderCommand& command, const Rendering& r) {
  std::vector<OutputFile> files;
  if (!r.output.empty()) {
    if (!r.output.ends_with(".exr") && !r.output.ends_with(".png"))
      throw Error(Location{"-o " + r.output}, "unknown image format; expected a name that ends in .exr or .png");
    files.push_back({"-o", r.output});
  }
  if (!command.save_cache.empty()) files.push_back({"--save-cache", command.save_cache});
  for (const std::string& aov : command.aovs) files.push_back({"--aov", aov_path(r.output, aov)});
  check_outputs(files);
}

// What the image to repeat was made of; of what is typed, nothing may say otherwise.
void read_original(const RenderCommand& command, Rendering& r) {
  const std::pair<const char*, bool> typed[] = {{"-i", !command.integrator.empty()},
                                                {"--accel", !command.accel.empty()},
                                                {"--spp", command.spp.has_value()},
                                                {"--time", command.time_s.has_value()},
                                                {"--error", command.error.has_value()},
                                                {"--seed", command.seed.has_value()},
                                                {"-p", !command.params.empty()},
                                                {"--resolution", command.resolution.has_value()},
                                                {"--crop", !command.crop.empty()},
                                                {"--camera", !command.camera.empty()},
                                                {"--pixel-filter", !command.reading.pixel_filter.empty()}};
  for (const auto& [option, is_typed] : typed)
    if (is_typed)
      throw Error(Location{option},
                  fmt::format("of no use beside --from, which takes it from {}; expected one of them", command.from));
  std::map<std::string, std::string> attributes;
  r.original = read_exr(command.from, &attributes);
  if (const auto aov = attributes.find("etendue_aov"); aov != attributes.end())
    throw Error(Location{command.from}, fmt::format("shows {}; expected the image itself", aov->second));
  r.recipe = read_recipe(attributes, command.from);
  r.window = r.recipe->window;
  r.resolution = r.recipe->resolution;
  if (const ivec2 size = r.size(); size != r.original.size)
    throw Error(Location{command.from},
                fmt::format("has {} x {} pixels, and says {} x {}", r.original.size.x, r.original.size.y, size.x, size.y));
  r.camera = r.recipe->camera;
  r.reading.pixel_filter = r.recipe->pixel_filter;
  r.integrator = r.recipe->integrator;
  r.accel = r.recipe->accel;
  r.resolution = r.recipe->resolution;
  r.states_error = r.recipe->states_error;
  if (command.scene.empty()) r.scene = r.recipe->scene;
}

// After the options: a cache that is asked for must be the one that the image began with, and none where there was none.
void check_cache(const Rendering& r) {
  if (!r.recipe || r.recipe->cache == r.cache_hash) return;
  if (r.recipe->cache.empty())
    throw Error(Location{"--load-cache"}, fmt::format("{} was begun without a cache; expected none", r.command.from));
  throw Error(Location{r.command.from},
              fmt::format("was begun with a saved cache (hash {}); expected it as --load-cache FILE{}", r.recipe->cache,
                          r.cache_hash.empty() ? "" : ", and not one with hash " + r.cache_hash));
}

}  // namespace

Budget read_options(const RenderCommand& command, Rendering& r) {
  if (command.scene.empty() && command.from.empty()) throw Error("SCENE is required; see `etendue render --help`");
  r.scene = command.scene;
  r.reading = command.reading;
  r.camera = command.camera;
  if (!command.from.empty()) read_original(command, r);
  read_parameters(command, r.integrator, r.accel);
  if (!command.load_cache.empty()) {
    r.cache_to_load = read_cache_bytes(command.load_cache);
    r.cache_hash = hash_text(r.cache_to_load);
    complete_from_cache(r.cache_to_load, command.load_cache, r.integrator);
    require_savable(r.integrator, "--load-cache");
  } else if (r.integrator.name.empty()) {
    r.integrator.name = "path";
  }
  validate_integrator(r.integrator);
  validate_accel(r.accel);
  if (!command.save_cache.empty()) require_savable(r.integrator, "--save-cache");
  check_cache(r);
  r.output = output_path(command, r.scene, r.integrator.name);
  r.seed = r.recipe ? r.recipe->seed : command.seed.value_or(1);
  if (command.resolution) r.resolution = *command.resolution;
  check_aovs(command, r);
  check_files(command, r);
  if (std::ranges::find(command.aovs, standard_error_aov) != command.aovs.end()) r.states_error = true;
  Budget budget = read_budget(command);
  if (r.recipe) budget.samples = r.recipe->iterations;
  r.budget = r.recipe ? r.recipe->budget : budget.text();
  return budget;
}

}  // namespace etendue
