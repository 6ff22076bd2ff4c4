#include "experiments/kinds/record_kind.h"
#include "experiments/kinds/stress/stress_config.h"
#include "experiments/kinds/stress/stress_record.h"
#include "experiments/kinds/stress/stress_report.h"
#include "experiments/kinds/stress/structure_hazard.h"
#include "experiments/report/report_text.h"
#include "experiments/run/recipe.h"
#include "experiments/run/run_reference.h"
#include "experiments/statistics/statistics.h"
#include "framework/core/check.h"
#include "framework/image/metrics.h"
#include "framework/io/image/png.h"
#include "framework/io/load_scene.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

namespace etendue {

void list_fields(auto& f, FieldsOf<StressPoint> auto& r) {
  FIELDS(t, x, values, bias, bias_error, peak);
  MAYBE_FIELDS(tails, sane_iterations, sane_s, beyond_stated);
}

void list_fields(auto& f, FieldsOf<StressRecord> auto& r) {
  f("id", r.id);
  f.cell(r.cell, "cell", "trial");
  list_ending(f, r);
  FIELDS(hazard, failure, source, parameter, unit);
  f("from", r.range.from);
  f("to", r.range.to);
  f("whole", r.range.whole);
  FIELDS(figure, figure_text);
  f.end("holds_low", r.holds.low, -endless);
  f.end("holds_high", r.holds.high, endless);
  FIELDS(column, remedy, method);
  f.maybe("parameters", r.parameters);
  FIELDS(inapplicable, of_structure, is_expected);
  MAYBE_FIELDS(expected_low, expected_high, second, second_unit, y);
  FIELDS(points, before, after, disagreements, picture);
  f.stamp("picture", r.picture_stamp);
  MAYBE_FIELDS(references);
}
std::string StressRecord::line() const { return line_of(type, *this); }

namespace {

// Images side by side, exposed so that all but a hundredth of the first one's pixels are within the range of a screen.
Image side_by_side(const std::vector<const Image*>& images) {
  const ivec2 size = images.front()->size;
  std::vector<double> values;
  for (const dvec3& pixel : images.front()->pixels) values.push_back(std::max({pixel.x, pixel.y, pixel.z}));
  const double bright = quantile(values, 0.99), exposure = bright > 0 ? 0.85 / bright : 1;
  constexpr int gap = 2;
  const int count = static_cast<int>(images.size());
  Image strip({count * size.x + (count - 1) * gap, size.y});
  std::fill(strip.pixels.begin(), strip.pixels.end(), dvec3(1));
  for (int i = 0; i < count; ++i)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x)
        strip.at(i * (size.x + gap) + x, y) = exposure * images[static_cast<std::size_t>(i)]->at(x, y);
  return strip;
}

double brightest(const Image& image) {
  double most = 0;
  for (const dvec3& pixel : image.pixels) most = std::max({most, pixel.x, pixel.y, pixel.z});
  return most;
}

// A scene of the lattice, with what methods are measured against there.
struct StressPlace : ScenePlace {
  StressPlace(const std::string& scene_name, const RunPlan& plan, RunDirectory& directory, RunObserver& observer)
      : ScenePlace(load_scene(scene_name, {plan.config.path}, plan.reading), plan) {
    ReferenceChoice choice = plan.config.reference;
    if (scene.closed_form) choice = {};
    const Reference made =
        make_run_reference(directory, {scene, needs, scene_name, resolution, choice, plan.threads, &observer},
                           ReferenceCache::standard(plan.config.path));
    failure = made.failure;
    reference = made.rendered.image;
  }

  Image reference;
  std::string failure;  // why it has none
};

// The options by which the scenes were read, each after a space.
std::string reading_options(const SceneReading& reading) {
  return (reading.pixel_filter.empty() ? "" : " --pixel-filter " + shell_word(reading.pixel_filter)) +
         (reading.approximate ? " --approximate" : "");
}

std::string render_command(const std::string& scene, const Method& method, ivec2 resolution, std::uint64_t samples,
                           std::uint64_t seed) {
  std::string command = fmt::format("etendue render {} --integrator {}", shell_word(scene), method.name);
  for (const auto& [key, value] : method.params) command += fmt::format(" -p {}", shell_word(key + "=" + to_text(value)));
  return fmt::format("{} --resolution {}x{} --spp {} --seed {}", command, resolution.x, resolution.y, samples, seed);
}

void note_first_sane(const CellResult& result, StressPoint& point) {
  const auto found = std::ranges::find_if(
      result.checkpoints, [](const CheckpointRecord& c) { return find_value(c.metrics, "relmse").value_or(1) < sane_relmse; });
  const bool any = found != result.checkpoints.end();
  const CheckpointRecord& at = any ? *found : result.checkpoints.back();
  point.sane_iterations.push_back((any ? 1 : -1) * static_cast<double>(at.iterations));
  point.sane_s.push_back((any ? 1 : -1) * at.time_s);
}

std::string trial_name(const StressTrial& trial) {
  if (trial.y) return fmt::format("{}: y={:g}", trial.method, *trial.y);
  return trial.method + (trial.remedy.empty() ? "" : ": " + trial.remedy);
}

class StressWork final : public RecordWork {
 public:
  StressWork(const RunPlan& plan, RunObserver& observer)
      : plan_(plan), observer_(observer), choice_(choice_of<StressChoice>(plan.config)) {}

  std::optional<SceneState> scene(const Cell& cell) override {
    return SceneState{cell.name.scene, cell.name.scene, load_scene(cell.name.scene, {plan_.config.path}, plan_.reading).hash()};
  }

  void refer(const std::string& scene, RunDirectory& directory) override { StressPlace(scene, plan_, directory, observer_); }

  std::unique_ptr<KindRecord> begin(const Cell& cell) override {
    const StressHazard& hazard = choice_.hazards[cell.scene];
    const StressTrial& trial = hazard.trials[cell.integrator];
    auto record = std::make_unique<StressRecord>();
    static_cast<HazardText&>(*record) = hazard;
    record->figure = hazard.figure->name;
    record->figure_text = hazard.figure->text;
    record->column = trial.method;
    record->remedy = trial.remedy;
    record->inapplicable = trial.inapplicable;
    record->of_structure = hazard.of_structures();
    record->y = trial.y;
    record->is_expected = trial.expected.has_value();
    if (trial.expected && std::isfinite(trial.expected->low)) record->expected_low = trial.expected->low;
    if (trial.expected && std::isfinite(trial.expected->high)) record->expected_high = trial.expected->high;
    return record;
  }

  void fill(const Cell& cell, KindRecord& filled, RunDirectory& directory, const Progress& progress) override {
    auto& record = static_cast<StressRecord&>(filled);
    const StressHazard& hazard = choice_.hazards[cell.scene];
    const StressTrial& trial = hazard.trials[cell.integrator];
    if (!record.inapplicable.empty()) return;
    directory_ = &directory;
    const Method harmless = method_at(hazard, trial, hazard.range.from);
    record.method = harmless.label();
    record.parameters = parameters_of(harmless);
    std::map<double, StressPoint> measured;  // by x
    std::map<double, Image> images;          // of the first seed
    const auto curve = sweep(hazard.range, choice_.factor, hazard.holds, [&](double x) {
      if (!measured.contains(x))
        measured[x] =
            hazard.of_structures() ? measure_structure(hazard, trial, x, record) : measure(hazard, trial, x, images[x]);
      progress(std::min(0.99, static_cast<double>(measured.size()) / 10), measured.size());
      return measured.at(x).values;
    });
    for (const SweepPoint& point : curve) {
      record.points.push_back(measured.at(point.x));
      record.points.back().t = point.t;
      record.points.back().x = point.x;
      if (!hazard.of_structures()) index_in(record.references, with_variable(trial.scene, point.x));
    }
    const Threshold threshold = threshold_of(curve, hazard.holds);
    const double held = hazard.range.at(threshold.held), failed = hazard.range.at(threshold.failed);
    record.before = command(hazard, trial, held);
    if (held != failed) record.after = command(hazard, trial, failed);
    if (hazard.of_structures()) return;
    std::vector<const Image*> strip;
    for (const double x : {held, failed}) {
      if (!strip.empty() && held == failed) break;
      strip.push_back(&place(hazard, trial, x).reference);
      strip.push_back(&images.at(x));
    }
    record.picture = fmt::format("pictures/{}-{}.png", cell.name.accel, slug(cell.name.integrator));
    const std::filesystem::path picture = std::filesystem::path(directory.path()) / record.picture;
    make_folders(picture.parent_path().string());
    record.picture_stamp = write_png(picture.string(), side_by_side(strip));
  }

  std::uint64_t disagreements() const override { return disagreements_; }

 private:
  std::string command(const StressHazard& hazard, const StressTrial& trial, double x) {
    const Method method = method_at(hazard, trial, x);
    const std::string reading = reading_options(plan_.reading);
    if (hazard.of_structures()) {
      std::string structure = method.name;
      for (const auto& [key, value] : method.params) structure += fmt::format(":{}={}", key, to_text(value));
      return fmt::format("etendue accel {} --structures {}{}", shell_word(with_variable(trial.scene, x)), shell_word(structure),
                         reading);
    }
    return render_command(with_variable(trial.scene, x), method, place(hazard, trial, x).resolution, trial.samples,
                          plan_.config.seeds.front()) +
           reading;
  }

  // Cells of a hazard follow each other, so only its places are kept.
  const StressPlace& place(const StressHazard& hazard, const StressTrial& trial, double x) {
    if (hazard.id != places_of_) places_.clear();
    places_of_ = hazard.id;
    const std::string name = with_variable(trial.scene, x);
    auto found = places_.find(name);
    if (found == places_.end()) found = places_.try_emplace(name, name, plan_, *directory_, observer_).first;
    if (!found->second.failure.empty()) throw Error(found->second.failure);
    return found->second;
  }

  StressPoint measure(const StressHazard& hazard, const StressTrial& trial, double x, Image& first) {
    const StressPlace& at = place(hazard, trial, x);
    const Method method = method_at(hazard, trial, x), accel = default_accel();
    const Budget budget{.samples = trial.samples, .checkpoints = plan_.config.budget.checkpoints};
    StressPoint point;
    std::vector<double> biases, beyond;
    std::vector<Image> images;
    const double bright = brightest(at.reference);
    for (const std::uint64_t seed : plan_.config.seeds) {
      CellTask task{at.scene, at.needs, accel, method, seed, at.resolution, budget, plan_.threads};
      task.reference = &at.reference;
      task.metrics = {"relmse"};
      task.confidence = true;
      CellResult result = run_cell(task);
      note_first_sane(result, point);
      if (const auto& stated = result.checkpoints.back().confidence; !stated.empty())
        beyond.push_back(1 - stated.at("within_2"));
      const double value = hazard.figure->compute(result.image, at.reference), off = bias(result.image, at.reference);
      point.values.push_back(std::isfinite(value) ? value : 1e30);
      biases.push_back(std::isfinite(off) ? off : 1e30);
      if (bright > 0) point.peak = std::max(point.peak, std::min(1e30, brightest(result.image) / bright));
      images.push_back(std::move(result.image));
    }
    point.tails = image_tails(images, at.reference);
    first = std::move(images.front());
    if (!beyond.empty()) point.beyond_stated = mean(beyond);
    point.bias = mean(biases);
    point.bias_error = sample_sd(biases) / std::sqrt(static_cast<double>(biases.size()));
    return point;
  }

  // Over what the structure does at the harmless end, where a sweep begins. Counts over thousands of rays hardly depend on the
  // seed: the first alone is asked.
  StressPoint measure_structure(const StressHazard& hazard, const StressTrial& trial, double x, StressRecord& record) {
    const Scene scene = load_scene(with_variable(trial.scene, x), {plan_.config.path}, plan_.reading);
    const StructureHazard measured = measure_structure_hazard(scene, method_at(hazard, trial, x), plan_.config.seeds.front());
    const double value = hazard.figure->of_structure(measured);
    if (x == hazard.range.at(0)) harmless_ = value;
    record.disagreements += measured.wrong_answers;
    disagreements_ += measured.wrong_answers;
    StressPoint point;
    point.values = {harmless_ > 0 ? value / harmless_ : 1};
    return point;
  }

  const RunPlan& plan_;
  RunObserver& observer_;
  const StressChoice& choice_;
  RunDirectory* directory_ = nullptr;  // of the cell that is being filled
  double harmless_ = 0;
  std::uint64_t disagreements_ = 0;
  std::map<std::string, StressPlace> places_;
  int places_of_ = 0;
};

// A reference file shows one scene.
void require_one_scene(const StressChoice& choice, const ReferenceChoice& reference) {
  const std::string& scene = choice.hazards.front().trials.front().scene;
  bool is_one = reference.files.size() == 1 && with_variable(scene, 1) == with_variable(scene, 2);
  for (const StressHazard& hazard : choice.hazards)
    for (const StressTrial& trial : hazard.trials) is_one = is_one && trial.scene == scene;
  if (!is_one)
    throw Error(reference.where,
                "reference: [[stress]] renders a scene for each x, which files cannot stand for; expected \"auto\" or "
                "{ samples = N }");
}

class StressKind final : public RecordKind<StressRecord, StressWork> {
 public:
  StressKind() : RecordKind({"scenes", "accels"}, {"integrators", "reference"}) {}

  std::vector<std::string> keys() const override { return {"stress"}; }
  std::vector<std::string> companions() const override { return {"sweep"}; }
  std::vector<std::string> measures() const override { return measured_code({"experiments/kinds/stress"}); }
  std::string beside() const override { return "[[stress]], which names scenes"; }

  void read(const ConfigNode& root, ExperimentConfig& config) const override {
    const ConfigNode& rows = *find_key(root, "stress");
    const ConfigNode* methods = find_key(root, "integrators");
    if (!methods) throw Error(rows.key_where, "no integrators; expected integrators = [\"path\", …] beside [[stress]]");
    if (!config.budget.samples || config.budget.time_s || config.budget.error)
      throw Error(rows.key_where, "stress: expected budget = { samples = N } beside it, and no other limit");
    auto choice = std::make_shared<StressChoice>(read_stress(rows, find_key(root, "sweep"), *methods, *config.budget.samples));
    if (config.reference.kind == ReferenceChoice::Kind::file) require_one_scene(*choice, config.reference);
    config.choice = choice;
  }

  std::vector<std::string> quick(const ConfigNode&) const override { return {"seeds=2", "resolution=[16, 16]"}; }

  // A cell's `scene` is the hazard, its `integrator` the trial.
  std::vector<Cell> cells(const ExperimentConfig& config) const override {
    const auto& hazards = choice_of<StressChoice>(config).hazards;
    std::vector<Cell> cells;
    for (std::size_t i = 0; i < hazards.size(); ++i)
      for (std::size_t t = 0; t < hazards[i].trials.size(); ++t) {
        const StressTrial& trial = hazards[i].trials[t];
        const std::string scene = with_variable(trial.scene, hazards[i].range.from);
        cells.push_back({i, 0, t, {scene, fmt::format("stress-{:02}", hazards[i].id), trial_name(trial), 1}});
      }
    return cells;
  }

  std::string effort(const ExperimentConfig& config) const override {
    return fmt::format("a method along a hazard, about eight points under {} seeds", config.seeds.size());
  }

  std::vector<std::string> resolved(const ExperimentConfig& config) const override {
    std::vector<std::string> texts;
    for (const StressHazard& hazard : choice_of<StressChoice>(config).hazards)
      for (const StressTrial& trial : hazard.trials) {
        if (!trial.inapplicable.empty()) continue;
        const Method method = method_at(hazard, trial, hazard.range.from);
        texts.push_back(hazard.of_structures() ? resolved_accel(method) : resolved_integrator(method));
      }
    return texts;
  }

  KindReport report(const RunLog& log) const override { return stress_report(log); }
  std::string summary(const RunLog& log) const override { return stress_summary(log); }
};

}  // namespace

const ExperimentKind& stress_kind() { return the_kind<StressKind>(); }

}  // namespace etendue
