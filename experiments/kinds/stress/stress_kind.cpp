#include "experiments/kinds/claims/claim_fields.h"
#include "experiments/kinds/record_kind.h"
#include "experiments/kinds/stress/stress_config.h"
#include "experiments/kinds/stress/stress_report.h"
#include "experiments/kinds/timing.h"
#include "experiments/run/reference.h"
#include "experiments/statistics/statistics.h"
#include "framework/core/check.h"
#include "framework/io/image/png.h"
#include "framework/io/load_scene.h"

#include <fmt/format.h>

#include <filesystem>

namespace etendue {

void list_fields(auto& f, FieldsOf<StressRecord> auto& r) {
  list_claim_fields(f, r);
  f("methods", r.methods);
  f("picture", r.picture);
  f.stamp("picture", r.picture_stamp);
  f.end("holds_low", r.holds.low, -endless);
  f.end("holds_high", r.holds.high, endless);
}
std::string StressRecord::line() const { return line_of(type, *this); }

namespace {

// Images side by side, exposed so that all but a hundredth of the first one's pixels are within the range of a screen.
Image side_by_side(const std::vector<Image>& images) {
  const ivec2 size = images.front().size;
  std::vector<double> values;
  for (const dvec3& pixel : images.front().pixels) values.push_back(std::max(pixel.x, std::max(pixel.y, pixel.z)));
  const double bright = quantile(values, 0.99), exposure = bright > 0 ? 0.85 / bright : 1;
  constexpr int gap = 2;
  const int count = static_cast<int>(images.size());
  Image strip({count * size.x + (count - 1) * gap, size.y});
  std::fill(strip.pixels.begin(), strip.pixels.end(), dvec3(1));
  for (int i = 0; i < count; ++i)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x)
        strip.at(i * (size.x + gap) + x, y) = exposure * images[static_cast<std::size_t>(i)].at(x, y);
  return strip;
}

class StressWork final : public RecordWork {
 public:
  StressWork(const RunPlan& plan, RunObserver& observer) : plan_(plan), observer_(observer) {}

  std::optional<SceneState> scene(const Cell& cell) override {
    const std::string& name = row_of(cell).scene;
    return SceneState{name, name, load_scene(name, {plan_.config.path}).hash()};
  }

  std::unique_ptr<KindRecord> begin(const Cell& cell) override {
    const StressRow& row = row_of(cell);
    auto record = std::make_unique<StressRecord>();
    record->id = row.id;
    record->claim = row.failure;
    record->source = row.source;
    record->claimed = row.figure->text;
    record->holds = row.holds;
    for (const StressTrial& trial : row.trials) record->methods.push_back(trial.method.label());
    return record;
  }

  void fill(const Cell& cell, KindRecord& filled, RunDirectory& directory, const Progress& progress) override {
    auto& record = static_cast<StressRecord&>(filled);
    const StressRow& row = row_of(cell);
    const Scene scene = load_scene(row.scene, {plan_.config.path}, plan_.reading);
    const SceneNeeds needs = scene_needs(scene);
    const ivec2 resolution = plan_.config.resolution.value_or(scene.resolution);
    const Reference reference = make_reference({scene, needs, row.scene, resolution, {}, plan_.threads, &observer_},
                                               ReferenceCache::standard(plan_.config.path));
    if (!reference.failure.empty()) throw Error(reference.failure);
    Budget budget = plan_.config.budget;
    if (row.samples) budget.samples = row.samples;
    budget.checkpoints.linear = 1;
    const Method accel = default_accel();
    std::vector<Image> images{reference.rendered.image};
    const std::size_t seeds = plan_.config.seeds.size();
    for (std::size_t t = 0; t < row.trials.size(); ++t) {
      std::vector<double> values;
      for (const std::uint64_t seed : plan_.config.seeds) {
        const CellResult result =
            run_cell({scene, needs, accel, row.trials[t].method, seed, resolution, budget, plan_.threads});
        values.push_back(row.figure->compute(result.image, reference.rendered.image));
        if (values.size() == 1) images.push_back(result.image);
        const std::size_t done = t * seeds + values.size();
        progress(static_cast<double>(done) / static_cast<double>(row.trials.size() * seeds), done);
      }
      const Expected& expected = t == 0 ? row.fails : row.holds;
      record.figures.push_back(
          {t == 0 ? "as it is" : row.trials[t].name, row.figure->text, FigureKind::plain, summarise(values), true, expected});
    }
    record.picture = fmt::format("pictures/{}.png", cell.name.integrator);
    const std::filesystem::path picture = std::filesystem::path(directory.path()) / record.picture;
    make_folders(picture.parent_path().string());
    record.picture_stamp = write_png(picture.string(), side_by_side(images));
  }

 private:
  const StressRow& row_of(const Cell& cell) const { return choice_of<StressChoice>(plan_.config).rows[cell.integrator]; }

  const RunPlan& plan_;
  RunObserver& observer_;
};

class StressKind final : public RecordKind<StressRecord, StressWork> {
 public:
  StressKind() : RecordKind({"scenes", "accels"}) {}

  std::vector<std::string> keys() const override { return {"stress"}; }
  std::vector<std::string> measures() const override { return measured_code({"experiments/kinds/stress"}); }
  std::string beside() const override { return "[[stress]], which names scenes and methods"; }

  void read(const ConfigNode& root, ExperimentConfig& config) const override {
    const ConfigNode& rows = *find_key(root, "stress");
    config.choice = std::make_shared<StressChoice>(read_stress(rows));
    if (!config.budget.samples || config.budget.time_s || config.budget.error)
      throw Error(rows.key_where, "stress: expected budget = { samples = N } beside it, and no other limit");
  }

  std::vector<std::string> quick(const ConfigNode&) const override { return {"seeds=1", "resolution=[32, 32]"}; }

  // A cell's `integrator` is the row.
  std::vector<Cell> cells(const ExperimentConfig& config) const override {
    const auto& rows = choice_of<StressChoice>(config).rows;
    std::vector<Cell> cells;
    for (std::size_t i = 0; i < rows.size(); ++i)
      cells.push_back({0, 0, i, {rows[i].scene, rows[i].figure->name, fmt::format("stress-{:02}", rows[i].id), 1}});
    return cells;
  }

  std::string effort(const ExperimentConfig& config) const override {
    return fmt::format("a failing method and its remedies under {} seeds", config.seeds.size());
  }

  KindReport report(const RunLog& log) const override { return stress_report(log); }
  std::string summary(const RunLog& log) const override { return stress_summary(log); }
};

}  // namespace

const ExperimentKind& stress_kind() {
  static const StressKind kind;
  return kind;
}

}  // namespace etendue
