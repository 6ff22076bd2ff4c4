// Experiments on loading: how long scenes take to read, and what they hold.
//
//   [loading]
//   repetitions   of reading each scene; default 5
#pragma once

#include "experiments/config/config_keys.h"
#include "experiments/kinds/record_kind.h"
#include "experiments/kinds/timing.h"
#include "framework/core/units.h"
#include "framework/io/load_scene.h"

namespace etendue {

struct LoadingChoice final : KindChoice {
  int repetitions = 5;
};

struct LoadingRecord final : KindRecord {
  static constexpr const char* type = "loading";

  std::uint64_t triangles = 0;
  Measured load_s;

  std::string line() const override;
};

void list_fields(auto& f, FieldsOf<LoadingRecord> auto& r) {
  f.cell(r.cell);
  list_ending(f, r);
  f("triangles", r.triangles);
  f.measured("load_s", r.load_s);
}

inline std::string LoadingRecord::line() const { return line_of(type, *this); }

class LoadingWork final : public RecordWork {
 public:
  LoadingWork(const RunPlan& plan, RunObserver&) : plan_(plan) {}

  std::unique_ptr<KindRecord> begin(const Cell&) override { return std::make_unique<LoadingRecord>(); }

  void fill(const Cell& cell, KindRecord& filled, RunDirectory&, const Progress& progress) override {
    auto& record = static_cast<LoadingRecord&>(filled);
    const SceneChoice& scene = plan_.config.scenes[cell.scene];
    std::vector<double> times;
    for (int i = choice_of<LoadingChoice>(plan_.config).repetitions; i > 0; --i) {
      times.push_back(seconds_of([&] { record.triangles = load_scene(scene.path, scene.where).triangle_count(); }));
      progress(1.0 / i, times.size());
    }
    record.load_s = summarise(times);
  }

 private:
  const RunPlan& plan_;
};

class LoadingKind final : public RecordKind<LoadingRecord, LoadingWork> {
 public:
  LoadingKind() : RecordKind({"accels", "budget"}) {}

  std::vector<std::string> keys() const override { return {"loading"}; }
  std::string beside() const override { return "[loading], which renders nothing"; }

  void read(const ConfigNode& root, ExperimentConfig& config) const override {
    auto choice = std::make_shared<LoadingChoice>();
    TableReader reader(*find_key(root, "loading"), "loading");
    reader.whole("repetitions", choice->repetitions, 1, 1000);
    reader.finish();
    config.choice = choice;
    require_scenes(config);
  }

  std::vector<Cell> cells(const ExperimentConfig& config) const override { return make_matrix(config, {{"load", {}, {}}}); }

  KindReport report(const RunLog& log) const override {
    Table table{"loading", "Scenes as they are read", {}, {}, {}, failed_cells<LoadingRecord>(log)};
    table.columns = {{"scene", "scene", false}, {"triangles", "triangles"}, {"load_s", "time"}};
    for (const LoadingRecord* record : done_records_of<LoadingRecord>(log))
      table.rows.push_back(
          {record->cell.scene, record->triangles, TableCell(record->load_s.median, format_seconds(record->load_s.median))});
    return {.tables = {table}};
  }
};

}  // namespace etendue
