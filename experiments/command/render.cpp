// `etendue render`: one scene, one method, one image, through the same loop as every cell of an experiment.
#include "experiments/command/commands.h"
#include "experiments/command/console.h"
#include "experiments/command/preview.h"
#include "experiments/command/render_files.h"
#include "experiments/command/view.h"
#include "experiments/log/json_line.h"
#include "experiments/log/manifest.h"
#include "experiments/report/record_overlay.h"
#include "experiments/report/report_text.h"
#include "experiments/report/surface_images.h"
#include "experiments/run/memory_forecast.h"
#include "experiments/run/recipe.h"
#include "experiments/run/reference.h"
#include "experiments/run/run_cell.h"
#include "framework/core/units.h"
#include "framework/image/metrics.h"
#include "framework/io/image/exr.h"
#include "framework/io/image/png.h"
#include "framework/io/load_scene.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <optional>

namespace etendue {

namespace {

constexpr std::uint64_t default_samples = 64;
const std::string records_aov = "records", standard_error_aov = "standard-error";

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

// The image must be on disk when the time is over: time since the process began counts, and so does writing the file.
void count_from_the_start(Budget& budget, double started) {
  const double gone = now_s() - started;
  const double reserve = std::min(0.05, 0.02 * *budget.time_s);
  budget.time_s = std::max(1e-9, *budget.time_s - gone - reserve);
}

std::string output_path(const RenderCommand& command, const std::string& scene, const std::string& integrator) {
  if (!command.output.empty() || command.json) return command.output;
  if (!command.from.empty()) return std::filesystem::path(command.from).stem().string() + "-again.exr";
  return slug(scene) + "-" + slug(integrator) + ".exr";
}

struct Rendered {
  const RenderCommand& command;
  Method integrator, accel;
  CellResult result = {};
  ivec2 resolution{0};
  int threads = 1;
  std::uint64_t seed = 1;
  std::string scene = {};
  std::string output = {};
  std::string cache_to_load = {}, cache_hash = {};  // bytes of the one to begin with
  bool states_error = false;
  std::uint64_t scene_hash = 0;
  std::string budget = {};
  std::optional<Recipe> recipe = {};  // of the image to repeat,
  Image original = {};                // and itself
  std::optional<bool> repeats = {};   // whether it did, to the bit
  std::string reference = {};         // what the metrics are measured against; "": none
  std::map<std::string, double> metrics = {};
  std::vector<std::string> warnings = {};  // of the scene's reader
  std::string camera = {};                 // as typed
  SceneReading reading = {};
  Tile window = {};  // the pixels that are shown; empty: all

  ivec2 size() const { return window.end == ivec2(0) ? resolution : window.end - window.begin; }  // of what is shown
  // The part of an image as large as the whole that is shown.
  Image shown(const Image& image) const { return window.end == ivec2(0) ? image : part_of(image, window.begin, window.end); }
};

// "b.exr" and "records" make "b.records.exr". What is no colour has no place in a PNG.
std::string aov_path(const std::string& output, const std::string& aov) {
  return std::filesystem::path(output).replace_extension(aov).string() +
         (is_surface_image(aov) ? ".exr" : std::filesystem::path(output).extension().string());
}

Image draw_aov(const std::string& aov, Integrator& integrator, const RenderContext& context, const Image& image) {
  if (is_surface_image(aov)) return draw_surface_image(aov, context);
  return aov == records_aov ? draw_records(image, context, integrator.cache()->record_shapes())
                            : integrator.cache()->standard_error();
}

std::string to_json(const Rendered& r) {
  const CheckpointRecord& end = r.result.checkpoints.back();
  Json json{
      {"scene", r.scene},
      {"integrator", r.integrator.label()},
      {"accel", r.accel.label()},
      {"seed", r.seed},
      {"width", r.result.image.size.x},
      {"height", r.result.image.size.y},
      {"threads", r.threads},
      {"image", r.output},
      {"image_hash", fmt::format("{:016x}", r.result.image_hash)},
      {"spp", end.iterations},
      {"time_s", end.time_s},
      {"cpu_s", end.cpu_s},
      {"phases_s", end.phases_s},
      {"counters", end.counters},
      {"peak_memory_bytes", end.peak_memory_bytes},
      {"non_finite", end.non_finite},
      {"expectation", {{"bias", bias_name(r.result.expectation.bias)}, {"mse_exponent", r.result.expectation.mse_exponent}}}};
  for (const NonFiniteSample& sample : r.result.non_finite)
    json["non_finite_at"].push_back({sample.pixel.x, sample.pixel.y, sample.iteration});
  if (!r.warnings.empty()) json["warnings"] = r.warnings;
  for (const std::string& aov : r.command.aovs) json["aovs"][aov] = aov_path(r.output, aov);
  if (!r.command.save_cache.empty()) json["cache"] = r.command.save_cache;
  if (!r.result.fallback.empty()) json["fallback"] = r.result.fallback;
  if (!r.result.out_of_reach.empty()) json["out_of_reach"] = r.result.out_of_reach;
  if (r.result.chosen) json["chosen"] = {{"integrator", r.result.chosen->label()}, {"why", r.result.why}};
  if (r.result.chosen_accel) json["chosen_accel"] = {{"accel", r.result.chosen_accel->label()}, {"why", r.result.accel_why}};
  if (r.result.stopped) json["interrupted"] = true;
  if (r.repeats) json["repeats"] = {{"image", r.command.from}, {"to_the_bit", *r.repeats}};
  if (!r.reference.empty()) json["reference"] = r.reference;
  for (const auto& [name, value] : r.metrics) json[name] = value;
  return dump(json, 2);
}

std::string to_lines(const Rendered& r) {
  const CheckpointRecord& end = r.result.checkpoints.back();
  std::string text = fmt::format("image       {}\n", r.output);
  for (const std::string& aov : r.command.aovs) text += fmt::format("aov         {}\n", aov_path(r.output, aov));
  if (!r.command.save_cache.empty()) text += fmt::format("cache       {}\n", r.command.save_cache);
  if (r.repeats) text += fmt::format("repeats     {}{}\n", r.command.from, *r.repeats ? ", to the bit" : ": no, other bits");
  if (r.result.chosen) text += fmt::format("method      {}\n", r.result.chosen->label());
  if (r.result.chosen_accel) text += fmt::format("structure   {}\n", r.result.chosen_accel->label());
  text += fmt::format("hash        {:016x}\nspp         {}\ntime        {}", r.result.image_hash, end.iterations,
                      format_seconds(end.time_s));
  std::string separator = " (";
  for (const auto& [phase, seconds] : end.phases_s)
    text += std::exchange(separator, ", ") + phase + " " + format_seconds(seconds);
  text += fmt::format(")\nmemory      {} at most\n", format_bytes(static_cast<double>(end.peak_memory_bytes)));
  for (const auto& [name, value] : r.metrics) text += fmt::format("{:<15} {:.4g}\n", name, value);
  if (!r.reference.empty()) text += fmt::format("against     {}\n", r.reference);
  return text;
}

void write_image(const Rendered& r, const CellResult& result, const std::string& path, const Image& image,
                 const std::string& aov = "") {
  if (path.ends_with(".png")) {
    write_png(path, image);
    return;
  }
  auto attributes =
      recipe_attributes({r.scene, r.scene_hash, result.chosen.value_or(r.integrator), result.chosen_accel.value_or(r.accel),
                         r.seed, r.resolution, result.checkpoints.back().iterations, r.budget, r.cache_hash, r.states_error,
                         r.camera, r.reading.pixel_filter, r.window},
                        make_manifest("", "", r.threads));
  attributes["etendue_cell"] = CellName{r.scene, r.accel.label(), r.integrator.label(), r.seed}.key();
  if (!aov.empty()) attributes["etendue_aov"] = aov;
  write_exr(path, image, attributes);
}

// The image first, since it must be there in time; all else is off the clock. A file that fails does not stop the others.
void write_outputs(const Rendered& r, Integrator& integrator, const RenderContext& context, const CellResult& result) {
  std::exception_ptr failure;
  const auto attempt = [&](const auto& write) {
    try {
      write();
    } catch (const std::exception&) {
      if (!failure) failure = std::current_exception();
    }
  };
  if (!r.output.empty()) attempt([&] { write_image(r, result, r.output, result.image); });
  exit_on_interrupt("\ninterrupted\n");
  if (!r.command.save_cache.empty())
    attempt([&] { write_whole_file(r.command.save_cache, integrator.cache()->save(context)); });
  for (const std::string& aov : r.command.aovs)
    attempt([&] {
      write_image(r, result, aov_path(r.output, aov), r.shown(draw_aov(aov, integrator, context, result.image)), aov);
    });
  if (failure) std::rethrow_exception(failure);
}

void check_aovs(const RenderCommand& command, const Rendered& r) {
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
void check_files(const RenderCommand& command, const Rendered& r) {
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

void warn_of_non_finite(const CellResult& result, Console& console) {
  const auto count = result.checkpoints.back().non_finite;
  if (count == 0) return;
  std::string at;
  for (std::size_t i = 0; i < std::min<std::size_t>(result.non_finite.size(), 10); ++i) {
    const NonFiniteSample& sample = result.non_finite[i];
    at +=
        fmt::format("{} pixel ({}, {}) iteration {}", at.empty() ? "" : ",", sample.pixel.x, sample.pixel.y, sample.iteration);
  }
  console.warning(fmt::format("{} non-finite samples were dropped, the first of them at{}", count, at));
}

// What the image to repeat was made of; of what is typed, nothing may say otherwise.
void read_original(const RenderCommand& command, Rendered& r) {
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
void check_cache(const Rendered& r) {
  if (!r.recipe || r.recipe->cache == r.cache_hash) return;
  if (r.recipe->cache.empty())
    throw Error(Location{"--load-cache"}, fmt::format("{} was begun without a cache; expected none", r.command.from));
  throw Error(Location{r.command.from},
              fmt::format("was begun with a saved cache (hash {}); expected it as --load-cache FILE{}", r.recipe->cache,
                          r.cache_hash.empty() ? "" : ", and not one with hash " + r.cache_hash));
}

// Everything typed, checked before a scene is loaded.
Budget read_options(const RenderCommand& command, Rendered& r) {
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

// Where the image named a file that does not lie here, beside the image perhaps.
Scene load_original_scene(const Rendered& r) {
  const std::filesystem::path beside = std::filesystem::path(r.command.from).parent_path() / r.scene;
  std::error_code ignored;
  const bool is_beside = r.command.scene.empty() && !std::filesystem::exists(r.scene, ignored) &&
                         std::filesystem::is_regular_file(beside, ignored);
  Scene scene = load_scene(is_beside ? beside.string() : r.scene, {"command line"}, r.reading);
  if (const std::uint64_t hash = scene.hash(); hash != r.recipe->scene_hash)
    throw Error(Location{r.command.from},
                fmt::format("was made of another scene than {} is now: hash {:016x}, and not {:016x}; expected the scene as it "
                            "was",
                            r.scene, r.recipe->scene_hash, hash));
  return scene;
}

void warn_of_commit(const Rendered& r, Console& console) {
  const std::string commit = make_manifest("", "", r.threads).commit;
  if (r.recipe && r.recipe->commit != commit)
    console.warning(
        fmt::format("{} was made by commit {}, and this is {}: bits may differ", r.command.from, r.recipe->commit, commit));
}

}  // namespace

int render_command(const RenderCommand& command) {
  Console console;
  exit_on_interrupt("\ninterrupted; no image is written\n");
  const Method integrator{command.integrator, {}, {"--integrator"}};
  const Method accel = command.accel.empty() ? default_accel() : Method{command.accel, {}, {"--accel"}};
  Rendered r{command, integrator, accel};
  Budget budget = read_options(command, r);
  r.threads = available_threads(command.threads, console);
  warn_of_commit(r, console);
  Scene scene = r.recipe ? load_original_scene(r) : load_scene(r.scene, {"command line"}, r.reading);
  r.scene_hash = scene.hash();
  if (!r.camera.empty()) set_camera(scene, r.camera);
  const SceneNeeds needs = scene_needs(scene);
  r.warnings = scene.warnings;
  for (const std::string& warning : r.warnings) console.warning(warning);
  if (r.resolution == ivec2(0)) r.resolution = scene.resolution;
  if (!r.recipe) {
    const bool draws_records = std::ranges::find(command.aovs, records_aov) != command.aovs.end();
    r.window = choose_window(command.crop,
                             command.error   ? "--error"
                             : draws_records ? "--aov records"
                                             : nullptr,
                             scene, r.resolution);
  }

  std::optional<Preview> preview;
  if (!command.preview.empty()) preview.emplace(command.preview, r.output.empty() ? r.scene : r.output, r.size());

  refuse_over_memory(r.scene, scene, needs, r.accel, r.integrator, r.resolution);
  // An error target needs the reference before, all else only afterwards, off the user's time.
  std::optional<Reference> reference;
  const auto find_reference = [&] {
    ConsoleRunObserver observer(console);
    reference = make_reference({scene, needs, r.scene, r.resolution, {}, r.threads, &observer}, ReferenceCache::standard(""));
    if (!reference->failure.empty()) throw Error(reference->failure);
  };
  if (budget.error) find_reference();
  const Effort effort = effort_of(budget);  // as typed: what is chosen by it does not depend on how long loading took
  if (!budget.error && budget.time_s) count_from_the_start(budget, command.started);

  LiveFigures live;
  const auto progress = [&](std::uint64_t iterations, double time_s) {
    const double share = budget.progress(iterations, time_s, live.error);
    std::vector<std::string> parts{fmt::format("{:.0f}%", std::floor(100 * share)), time_left(share, time_s)};
    for (std::string& part : live_parts(live)) parts.push_back(std::move(part));
    parts.push_back(counted(iterations, "iteration"));
    console.status(parts);
  };
  const Image* target = reference ? &reference->rendered.image : nullptr;
  CellTask task{scene, needs, r.accel, r.integrator, r.seed, r.resolution, budget, r.threads, target, {}, {}, false, progress};
  if (!command.load_cache.empty())
    task.before_prepare = [&](Integrator& integrator, RenderContext& context) {
      integrator.cache()->load(context, r.cache_to_load, Location{command.load_cache});
      r.cache_to_load = {};
    };
  if (preview) task.preview = [&](const Film& film) { preview->update([&] { return r.shown(film.mean()); }); };
  if (console.interactive()) task.live = [&](const LiveFigures& figures) { live = figures; };
  task.confidence = r.states_error;
  task.effort = effort;
  task.window = r.window;
  task.finished = [&](Integrator& integrator, RenderContext& context, const CellResult& result) {
    console.clear_status();
    if (result.chosen) console.line(fmt::format("-i auto: {}: {}", result.chosen->label(), result.why));
    if (result.chosen_accel) console.line(fmt::format("--accel auto: {}: {}", result.chosen_accel->label(), result.accel_why));
    write_outputs(r, integrator, context, result);
    if (preview) preview->finish(result.image);
  };
  task.stop = interrupted;
  note_interrupt("\ninterrupted: the image is written after this iteration; again to leave without it\n",
                 "\nno image is written\n");
  r.result = run_cell(task);
  if (r.recipe)
    r.repeats = std::equal(r.original.pixels.begin(), r.original.pixels.end(), r.result.image.pixels.begin(),
                           r.result.image.pixels.end(), [](const dvec3& a, const dvec3& b) { return vec3(a) == vec3(b); });
  if (!reference && scene.closed_form) find_reference();
  if (reference) {
    r.reference = reference->rendered.source;
    for (const Metric& metric : metrics())
      if (!metric.on_request())
        r.metrics[std::string(metric.name)] = metric.compute(r.result.image, r.shown(reference->rendered.image));
  }
  fmt::print("{}", command.json ? to_json(r) + "\n" : to_lines(r));
  if (!r.result.out_of_reach.empty()) console.warning(r.result.out_of_reach);
  if (preview && !preview->failure().empty()) console.warning(preview->failure());
  if (!r.result.fallback.empty()) console.warning(fmt::format("{}: {}", r.accel.name, r.result.fallback));
  warn_of_non_finite(r.result, console);
  if (const double spent = r.result.checkpoints.back().time_s; budget.time_s && spent > 1.1 * *budget.time_s)
    console.warning(fmt::format("took {} of {}: the method's preparation and its first iteration cannot be cut short",
                                format_seconds(spent), format_seconds(*budget.time_s)));
  if (r.result.stopped) return 130;
  if (r.repeats && !*r.repeats) {
    console.warning(fmt::format("not the bits of {}", command.from));
    return 1;
  }
  if (!budget.error || r.result.reached_error) return 0;
  console.warning(
      fmt::format("relmse {:g} was not reached within {}", *budget.error, format_seconds(r.result.checkpoints.back().time_s)));
  return 1;
}

}  // namespace etendue
