// `etendue render`: one scene, one method, one image, through the same loop as every cell of an experiment.
#include "experiments/command/console.h"
#include "experiments/command/preview.h"
#include "experiments/command/rendering.h"
#include "experiments/report/report_text.h"
#include "experiments/run/memory_forecast.h"
#include "experiments/run/reference.h"
#include "experiments/run/suspension.h"
#include "framework/core/units.h"
#include "framework/image/metrics.h"
#include "framework/io/load_scene.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

namespace etendue {

namespace {

// The image must be on disk when the time is over: time since the process began counts, and so does writing the file.
// Returns what had gone.
double count_from_the_start(Budget& budget, double started) {
  const double gone = now_s() - started;
  const double reserve = std::min(0.05, 0.02 * *budget.time_s);
  budget.time_s = std::max(1e-9, *budget.time_s - gone - reserve);
  return gone;
}

// Looks beside the image, too, where it names a file that does not lie here.
Scene load_original_scene(const Rendering& r) {
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

void warn_of_commit(const Rendering& r, Console& console) {
  const std::string commit = make_manifest("", "", r.threads).commit;
  if (r.recipe && r.recipe->commit != commit)
    console.warning(
        fmt::format("{} was made by commit {}, and this is {}: bits may differ", r.command.from, r.recipe->commit, commit));
}

void warn_of_non_finite(const CellResult& result, Console& console) {
  const auto count = result.checkpoints.back().non_finite;
  if (count == 0) return;
  const std::string at = joined(result.non_finite | std::views::take(10), ", ", [](const NonFiniteSample& sample) {
    return fmt::format("pixel ({}, {}) iteration {}", sample.pixel.x, sample.pixel.y, sample.iteration);
  });
  console.warning(fmt::format("{} non-finite samples were dropped, the first of them at {}", count, at));
}

// Loads the scene, warns of what its reader said, and settles view, resolution and window.
Scene load_view(Rendering& r, Console& console) {
  Scene scene = r.recipe ? load_original_scene(r) : load_scene(r.scene, {"command line"}, r.reading);
  r.scene_hash = scene.hash();
  if (!r.camera.empty()) set_camera(scene, r.camera);
  r.warnings = scene.warnings;
  for (const std::string& warning : r.warnings) console.warning(warning);
  if (r.resolution == ivec2(0)) r.resolution = scene.resolution;
  if (r.recipe) return scene;
  const bool draws_records = contains(r.command.aovs, records_aov);
  const char* needs_whole = r.command.error ? "--error" : draws_records ? "--aov records" : nullptr;
  r.window = choose_window(r.command.crop, needs_whole, scene, r.resolution);
  return scene;
}

Reference find_reference(const Rendering& r, const Scene& scene, const SceneNeeds& needs, Console& console) {
  ConsoleRunObserver observer(console);
  Reference reference =
      make_reference({scene, needs, r.scene, r.resolution, {}, r.threads, &observer}, ReferenceCache::standard(""));
  if (!reference.failure.empty()) throw Error(reference.failure);
  return reference;
}

// Runs the task, which holds what any cell does, with what a person at a terminal sees and keeps of it.
void run_at_terminal(CellTask task, Rendering& r, Console& console) {
  LiveFigures live;
  task.progress = [&](std::uint64_t iterations, double time_s) {
    const double share = task.budget.progress(iterations, time_s, live.error);
    std::vector<std::string> parts{fmt::format("{:.0f}%", std::floor(100 * share)), time_left(share, time_s)};
    for (std::string& part : live_parts(live)) parts.push_back(std::move(part));
    parts.push_back(counted(iterations, "iteration"));
    console.status(parts);
  };
  if (console.interactive()) task.live = [&](const LiveFigures& figures) { live = figures; };
  if (!r.command.load_cache.empty())
    task.before_prepare = [&](Integrator& integrator, RenderContext& context) {
      integrator.cache()->load(context, r.cache_to_load, Location{r.command.load_cache});
      r.cache_to_load = {};
    };
  std::optional<Preview> preview;
  if (!r.command.preview.empty()) preview.emplace(r.command.preview, r.output.empty() ? r.scene : r.output, r.size());
  if (preview) task.preview = [&](const Film& film) { preview->update([&] { return r.shown(film.mean()); }); };
  task.finished = [&](Integrator& integrator, RenderContext& context, const CellResult& result) {
    console.clear_status();
    if (result.chosen) console.line(fmt::format("-i auto: {}: {}", result.chosen->label(), result.why));
    if (result.chosen_accel) console.line(fmt::format("--accel auto: {}: {}", result.chosen_accel->label(), result.accel_why));
    write_outputs(r, integrator, context, result);
    if (preview) preview->finish(result.image);
  };
  task.stop = interrupted;
  task.looks_for_left_out = true;
  note_interrupt("\ninterrupted: the image is written after this iteration; again to leave without it\n",
                 "\nno image is written\n");
  r.result = run_cell(task);
  if (preview) r.preview_failure = preview->failure();
}

void measure_against(const Reference& reference, Rendering& r) {
  r.reference = reference.rendered.source;
  for (const Metric& metric : metrics())
    if (!metric.on_request())
      r.metrics[std::string(metric.name)] = metric.compute(r.result.image, r.shown(reference.rendered.image));
}

// Warns of what fell short of what was `asked`, `gone_s` having gone before the method's own time; returns the exit code.
int judge(const Rendering& r, const Budget& asked, double gone_s, Console& console) {
  const CellResult& result = r.result;
  const CheckpointRecord& end = result.checkpoints.back();
  for (const std::string& missed : result.out_of_reach) console.warning(missed);
  if (!r.preview_failure.empty()) console.warning(r.preview_failure);
  if (!result.fallback.empty()) console.warning(fmt::format("{}: {}", r.accel.name, result.fallback));
  warn_of_non_finite(result, console);
  if (asked.time_s && gone_s + end.time_s > 1.1 * *asked.time_s)
    console.warning(fmt::format("took {} of {}: {}", format_seconds(gone_s + end.time_s), format_seconds(*asked.time_s),
                                suspensions() > 0 ? "the process was suspended, and the clock ran on"
                                                  : "reading, preparation and a first iteration cannot be cut short"));
  if (result.stopped) return 130;
  if (r.repeats && !*r.repeats) {
    console.warning(fmt::format("not the bits of {}", r.command.from));
    return 1;
  }
  if (!asked.error || result.reached_error) return 0;
  console.warning(fmt::format("relmse {:g} was not reached within {} and {}", *asked.error,
                              counted(end.iterations, "iteration"), format_seconds(end.time_s)));
  return 1;
}

}  // namespace

int render_command(const RenderCommand& command) {
  Console console;
  exit_on_interrupt("\ninterrupted; no image is written\n");
  Rendering r{{}, command};
  Budget budget = read_options(command, r);
  r.threads = available_threads(command.threads, console);
  warn_of_commit(r, console);
  const Scene scene = load_view(r, console);
  const SceneNeeds needs = scene_needs(scene);
  refuse_over_memory(r.scene, scene, needs, r.accel, r.integrator, r.resolution);

  // An error target needs the reference before, all else only afterwards, off the user's time.
  std::optional<Reference> reference;
  if (budget.error) reference = find_reference(r, scene, needs, console);
  const Effort effort = effort_of(budget);  // as typed: what is chosen by it does not depend on how long loading took
  const Budget asked = budget;
  const double gone_s = !asked.error && asked.time_s ? count_from_the_start(budget, command.started) : 0;
  CellTask task{scene, needs, r.accel, r.integrator, r.seed, r.resolution, budget, r.threads};
  task.reference = reference ? &reference->rendered.image : nullptr;
  task.confidence = r.states_error;
  task.effort = effort;
  task.window = r.window;
  run_at_terminal(std::move(task), r, console);

  if (r.recipe)
    r.repeats = std::ranges::equal(r.original.pixels, r.result.image.pixels,
                                   [](const dvec3& a, const dvec3& b) { return vec3(a) == vec3(b); });
  if (!reference && scene.closed_form) reference = find_reference(r, scene, needs, console);
  if (reference) measure_against(*reference, r);
  fmt::print("{}", command.json ? to_json(r) + "\n" : to_lines(r));
  return judge(r, asked, gone_s, console);
}

}  // namespace etendue
