// The Python module `etendue`: load a scene, render it, run an experiment, read its log, measure errors. Each function is one
// call of the code behind the command of that name, and gives its values as NumPy arrays, dicts and lists; docs/python.md shows
// them.
//
// Input that is refused raises etendue.Error (a ValueError) with the text that the command prints. Ctrl-C ends a render or a
// run after the iteration it is in; an experiment that is run again goes on from there. Python's lock is released while light
// is computed.
#include "experiments/log/log.h"
#include "experiments/report/report.h"
#include "experiments/run/reference.h"
#include "experiments/run/run.h"
#include "framework/core/parallel.h"
#include "framework/core/threads.h"
#include "framework/core/units.h"
#include "framework/image/metrics.h"
#include "framework/io/image/image_file.h"
#include "framework/io/load_scene.h"

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <algorithm>
#include <chrono>
#include <mutex>

namespace etendue {
namespace {

namespace py = pybind11;

using Pixels = py::array_t<double, py::array::c_style | py::array::forcecast>;

// Height x width x 3, linear RGB, row 0 at the top, in the precision of EXR files.
py::array_t<float> array_of(const Image& image) {
  py::array_t<float> array({image.size.y, image.size.x, 3});
  float* to = array.mutable_data();
  for (const dvec3& pixel : image.pixels)
    for (int channel = 0; channel < 3; ++channel) *to++ = static_cast<float>(pixel[channel]);
  return array;
}

void warn(const std::string& text) {
  if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) < 0) throw py::error_already_set();
}

Image image_of(const char* argument, const py::object& value) {
  if (py::isinstance<py::str>(value)) {
    std::vector<std::string> warnings;
    Image image = read_as_image(value.cast<std::string>(), warnings);
    for (const std::string& warning : warnings) warn(warning);
    return image;
  }
  const auto array = Pixels::ensure(value);
  if (!array || array.ndim() != 3 || array.shape(2) != 3)
    throw Error(Location{argument}, "expected an array of height x width x 3, or the path of an image");
  Image image(ivec2(static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0))));
  const double* from = array.data();
  for (dvec3& pixel : image.pixels)
    for (int channel = 0; channel < 3; ++channel) pixel[channel] = *from++;
  return image;
}

py::object parsed(const std::string& json) { return py::module_::import("json").attr("loads")(json); }

// "path", or {"name": "photon-map", "photons": "200k"} as a table of an experiment's file.
Method method_of(const char* argument, const py::object& value) {
  const Location where{argument};
  Method method{"", {}, where};
  if (py::isinstance<py::str>(value)) {
    method.name = value.cast<std::string>();
    return method;
  }
  if (!py::isinstance<py::dict>(value) || !value.contains("name"))
    throw Error(where, "expected a name, or a dict of \"name\" and parameters");
  for (const auto& [key, parameter] : value.cast<py::dict>()) {
    const std::string name = py::str(key);
    if (name == "name") {
      method.name = py::str(parameter);
    } else if (py::isinstance<py::bool_>(parameter)) {
      method.params[name] = {parameter.cast<bool>(), where};
    } else if (py::isinstance<py::int_>(parameter)) {
      method.params[name] = {parameter.cast<std::int64_t>(), where};
    } else if (py::isinstance<py::float_>(parameter)) {
      method.params[name] = {parameter.cast<double>(), where};
    } else {
      method.params[name] = {std::string(py::str(parameter)), where};
    }
  }
  return method;
}

int started_threads(const std::optional<int>& threads) {
  if (threads && (*threads < 1 || *threads > 4096))
    throw Error(Location{"threads"}, fmt::format("{} is out of range; expected 1 .. 4096", *threads));
  return start_threads(threads.value_or(hardware_threads()));
}

// Thrown through a run when Python has taken an interrupt. No std::exception, which would count as the failure of a cell.
struct Interrupted {};

bool interrupted() {
  const py::gil_scoped_acquire lock;
  return PyErr_CheckSignals() != 0;
}

// A scene in memory, with what it is called and what it needs.
struct LoadedScene {
  LoadedScene(const std::string& scene_name, const SceneReading& reading)
      : name(scene_name), scene(load_scene(scene_name, {"load"}, reading)), needs(scene_needs(scene)) {}

  std::string name;
  Scene scene;
  SceneNeeds needs;
};

ivec2 resolution_of(const LoadedScene& scene, const std::optional<std::pair<int, int>>& size) {
  if (!size) return scene.scene.resolution;
  const auto [width, height] = *size;
  if (std::min(width, height) < 1 || std::max(width, height) > 16384)
    throw Error(Location{"resolution"}, fmt::format("({}, {}); expected width and height, each in 1 .. 16384", width, height));
  return {width, height};
}

Budget budget_of(const std::optional<std::uint64_t>& samples, const py::object& time) {
  Budget budget;
  budget.checkpoints.linear = 1;
  budget.samples = samples;
  if (!time.is_none())
    budget.time_s = py::isinstance<py::str>(time) ? parse_seconds(time.cast<std::string>()) : time.cast<double>();
  if (budget.time_s && !(*budget.time_s > 0)) throw Error(Location{"time"}, "expected a time above zero");
  constexpr std::uint64_t most = 4'000'000'000;  // as of --spp
  if (budget.samples && (*budget.samples == 0 || *budget.samples > most))
    throw Error(Location{"samples"}, fmt::format("{} is out of range; expected 1 .. {}", *budget.samples, most));
  if (!budget.samples && !budget.time_s) throw Error("render: expected samples or time");
  return budget;
}

// Counters, by which a pilot and `auto` go, are the process's: what several Python threads render takes turns. A listener may
// render within its run's turn.
std::recursive_timed_mutex rendering;

// Waits for a turn, calling `check` now and then. To be called without Python's lock.
template <class Check>
std::unique_lock<std::recursive_timed_mutex> take_turn(const Check& check) {
  std::unique_lock turn(rendering, std::defer_lock);
  while (!turn.try_lock_for(std::chrono::milliseconds(100))) check();
  return turn;
}

py::dict render(const LoadedScene& scene, const py::object& integrator_value, const py::object& accel_value,
                const std::optional<std::uint64_t>& samples, const py::object& time, std::uint64_t seed,
                const std::optional<std::pair<int, int>>& size, const std::optional<int>& thread_count) {
  Method integrator = method_of("integrator", integrator_value);
  Method accel = accel_value.is_none() ? default_accel(integrator.name) : method_of("accel", accel_value);
  validate_integrator(integrator);
  validate_accel(accel);
  const Budget budget = budget_of(samples, time);
  CellTask task{scene.scene, scene.needs, accel, integrator, seed, resolution_of(scene, size), budget};
  task.threads = started_threads(thread_count);
  task.stop = interrupted;
  task.looks_for_left_out = true;
  CellResult result;
  {
    const py::gil_scoped_release unlocked;
    try {
      const auto turn = take_turn([] {
        if (interrupted()) throw Interrupted{};
      });
      result = run_cell(task);
    } catch (const Interrupted&) {
      result.stopped = true;
    }
  }
  if (result.stopped) throw py::error_already_set();
  CheckpointRecord& end = result.checkpoints.back();
  end.cell = {scene.name, accel.label(), integrator.label(), seed};
  py::dict rendered = parsed(to_json_line(end));
  rendered["counters"] = end.counters;  // with those of 0, which the log leaves out
  rendered["image"] = array_of(result.image);
  rendered["image_hash"] = fmt::format("{:016x}", result.image_hash);
  if (result.chosen) rendered["chosen"] = result.chosen->label();
  if (result.chosen_accel) rendered["chosen_accel"] = result.chosen_accel->label();
  if (!result.out_of_reach.empty()) rendered["out_of_reach"] = fmt::format("{}", fmt::join(result.out_of_reach, "\n"));
  if (!result.fallback.empty()) warn(fmt::format("{}: {}", accel.name, result.fallback));
  for (const std::string& missed : result.out_of_reach) warn(missed);
  if (end.non_finite > 0) warn(fmt::format("{} non-finite samples were dropped", end.non_finite));
  return rendered;
}

class PythonObserver final : public RunObserver {
 public:
  explicit PythonObserver(py::object listener) : listener_(std::move(listener)) {}

  void narrate(const std::string& line) override { tell(line); }
  void status(const std::string&) override { check(); }
  void cell_started(const CellName&, std::size_t, std::size_t) override { check(); }
  void cell_progress(double, std::uint64_t, double) override { check(); }
  void cell_finished(const CellRecord& cell, const CheckpointRecord*) override {
    tell(cell.cell.key() + ": " + cell.status + (cell.error.empty() ? "" : ", " + cell.error));
  }

  std::optional<py::error_already_set> raised;  // by the listener, or an interrupt

  void check() {
    if (interrupted()) stop();
  }

 private:
  void tell(const std::string& line) {
    check();
    if (listener_.is_none()) return;
    const py::gil_scoped_acquire lock;
    try {
      listener_(line);
    } catch (py::error_already_set& error) {
      raised.emplace(std::move(error));
      throw Interrupted{};
    }
  }
  void stop() {
    const py::gil_scoped_acquire lock;
    raised.emplace();
    throw Interrupted{};
  }

  py::object listener_;
};

// Does `work` without Python's lock and answers what it gives. Throws what the listener, or an interrupt, raised in Python.
template <class Work>
auto unlocked(PythonObserver& observer, const Work& work) {
  {
    const py::gil_scoped_release released;
    try {
      const auto turn = take_turn([&] { observer.check(); });
      return work();
    } catch (const Interrupted&) {
    }
  }
  throw py::error_already_set(std::move(*observer.raised));
}

// A listener that makes Python's warnings of warnings.
py::object warner() {
  return py::cpp_function([](const std::string& line) {
    constexpr std::string_view mark = "warning: ";
    if (line.starts_with(mark)) warn(line.substr(mark.size()));
  });
}

py::array_t<float> reference(const LoadedScene& scene, const std::optional<std::uint64_t>& samples,
                             const std::optional<std::pair<int, int>>& size, const std::optional<int>& thread_count) {
  ReferenceRequest request{scene.scene, scene.needs, scene.name, resolution_of(scene, size), {}};
  constexpr std::uint64_t least = 16, most = 1'000'000'000;  // as in an experiment's file
  if (samples && (*samples < least || *samples > most))
    throw Error(Location{"samples"}, fmt::format("{} is out of range; expected {} .. {}", *samples, least, most));
  if (samples) request.choice = {ReferenceChoice::Kind::samples, *samples, {}, {"samples"}};
  request.threads = started_threads(thread_count);
  PythonObserver observer(warner());
  request.observer = &observer;
  const Reference made = unlocked(observer, [&] { return make_reference(request, ReferenceCache::standard("")); });
  if (!made.failure.empty()) throw Error(made.failure);
  return array_of(made.rendered.image);
}

py::dict compare(const py::object& image_value, const py::object& reference_value) {
  const Image image = image_of("image", image_value), truth = image_of("reference", reference_value);
  if (image.size != truth.size)
    throw Error(Location{"image"}, fmt::format("{} x {} pixels; expected {} x {} as in the reference", image.size.x,
                                               image.size.y, truth.size.x, truth.size.y));
  py::dict values;
  for (const Metric& metric : metrics()) values[std::string(metric.name).c_str()] = metric.compute(image, truth);
  return values;
}

py::dict run(const RunOptions& options, const py::object& listener) {
  RunPlan plan = plan_run(options);
  plan.threads = started_threads(plan.threads);
  PythonObserver observer(listener);
  const RunSummary summary = unlocked(observer, [&] { return execute_run(plan, observer); });
  py::dict told;
  told["directory"] = plan.directory;
  told["done"] = summary.done;
  told["failed"] = summary.failed;
  told["skipped"] = summary.skipped;
  told["disagreements"] = summary.disagreements;
  told["files"] = summary.report_files;
  told["findings"] = summary.findings;
  told["notes"] = summary.notes;
  return told;
}

template <class Record>
void add_lines(py::dict& log, const std::vector<Record>& records) {
  py::list lines;
  for (const Record& record : records) lines.append(parsed(to_json_line(record)));
  log[Record::line_type] = lines;
}

py::dict read_logs(const std::vector<std::string>& directories) {
  const std::vector<RunLog> logs = mapped(directories, read_resolved_log);
  const RunLog log = logs.size() == 1 ? logs.front() : merge_logs(logs);
  py::dict lines;
  add_lines(lines, log.manifests);
  add_lines(lines, log.plans);
  add_lines(lines, log.scenes);
  add_lines(lines, log.references);
  add_lines(lines, log.structures);
  add_lines(lines, log.checkpoints);
  add_lines(lines, log.products);
  add_lines(lines, log.cells);
  for (const std::string& type : kind_record_types()) lines[type.c_str()] = py::list();
  for (const auto& record : log.records) {
    const py::dict line = parsed(record->line());
    lines[line["type"]].cast<py::list>().append(line);
  }
  return lines;
}

std::vector<std::string> one_or_many(const py::object& value) {
  if (py::isinstance<py::str>(value)) return {value.cast<std::string>()};
  return value.cast<std::vector<std::string>>();
}

}  // namespace

PYBIND11_MODULE(etendue, module) {
  module.doc() = "A laboratory for photon mapping and radiance caching. docs/python.md shows each function.";
  py::register_exception<Error>(module, "Error", PyExc_ValueError);

  py::class_<LoadedScene>(module, "Scene", "A scene in memory, as `load` returns it.")
      .def_readonly("name", &LoadedScene::name)
      .def_property_readonly("hash", [](const LoadedScene& s) { return fmt::format("{:016x}", s.scene.hash()); })
      .def_property_readonly("resolution",
                             [](const LoadedScene& s) { return std::pair(s.scene.resolution.x, s.scene.resolution.y); })
      .def_property_readonly("warnings", [](const LoadedScene& s) { return s.scene.warnings; })
      .def("__repr__", [](const LoadedScene& s) { return fmt::format("<etendue.Scene {}>", s.name); });

  using namespace pybind11::literals;
  const py::object none = py::none();
  module.def(
      "load",
      [](const std::string& name, bool approximate, bool confined) {
        auto scene = std::make_unique<LoadedScene>(name, SceneReading{.confined = confined, .approximate = approximate});
        for (const std::string& warning : scene->scene.warnings) warn(warning);
        return scene;
      },
      "Loads a built-in scene (\"builtin:NAME\") or a file.", "name"_a, py::kw_only(), "approximate"_a = false,
      "confined"_a = false);
  module.def(
      "render", render,
      "Renders: a dict with `image` (float32, height x width x 3, linear RGB) and the fields of a checkpoint (docs/log.md). "
      "`integrator` and `accel`: a name, or a dict of \"name\" and parameters. `time`: seconds, or text such as \"30s\".",
      "scene"_a, "integrator"_a = "path", py::kw_only(), "accel"_a = none, "samples"_a = none, "time"_a = none, "seed"_a = 1,
      "resolution"_a = none, "threads"_a = none);
  module.def("reference", reference, "What errors are measured against: the closed form, or a rendered image, which is kept.",
             "scene"_a, py::kw_only(), "samples"_a = none, "resolution"_a = none, "threads"_a = none);
  module.def("compare", compare, "Every metric of docs/metrics.md by name. Images are arrays or paths of image files.",
             "image"_a, "reference"_a);
  module.def(
      "run",
      [](const std::string& experiment, const std::vector<std::string>& overrides, const std::string& out,
         const std::string& filter, const std::string& shard, const std::optional<int>& threads, bool fresh, bool quick,
         const py::object& on_line) {
        return run({experiment, overrides, out, filter, shard, threads, fresh, quick, {}}, on_line);
      },
      "Runs an experiment's file, or goes on with it: a dict of where it is, how many cells are done, and what to doubt. "
      "`on_line` is called with each line of narration.",
      "experiment"_a, py::kw_only(), "overrides"_a = std::vector<std::string>{}, "out"_a = "", "filter"_a = "", "shard"_a = "",
      "threads"_a = none, "fresh"_a = false, "quick"_a = false, "on_line"_a = none);
  module.def(
      "read_log", [](const py::object& directories) { return read_logs(one_or_many(directories)); },
      "The log of a directory, or of several shards: a list of dicts for each type of line (docs/log.md).", "directories"_a);
  module.def(
      "curves", [](const py::object& directories) { return curves_of(one_or_many(directories)); },
      "The text of curves.csv (docs/log.md) for a directory, or for several shards.", "directories"_a);
}

}  // namespace etendue
