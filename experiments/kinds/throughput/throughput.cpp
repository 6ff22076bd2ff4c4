// Experiments on throughput, [throughput] (docs/experiment-file.md has the keys): how many camera samples, rays, photons and
// records a second, with each instruction set, and how that changed from commit to commit.
#include "experiments/config/config_keys.h"
#include "experiments/kinds/record_kind.h"
#include "experiments/kinds/throughput/throughput_record.h"
#include "experiments/kinds/timing.h"
#include "experiments/report/report_data.h"
#include "experiments/run/run_cell.h"
#include "framework/core/isa.h"

#include <fmt/format.h>
#include <algorithm>

namespace etendue {

void list_fields(auto& f, FieldsOf<Throughput> auto& r) {
  FIELDS(isa, iterations);
  f.measured("samples_per_s", r.samples_per_s);
  f.measured("rays_per_s", r.rays_per_s);
  f.measured("photons_per_s", r.photons_per_s);
  f.measured("records_per_s", r.records_per_s);
  f("shares", r.shares);
}

void list_fields(auto& f, FieldsOf<ThroughputRecord> auto& r) {
  f.cell(r.cell, "commit");
  list_ending(f, r);
  f.maybe("parameters", r.parameters);
  FIELDS(image_hash, sets);
}

std::string ThroughputRecord::line() const { return line_of(type, *this); }

namespace {

struct ThroughputChoice final : KindChoice {
  std::vector<Isa> isas;
  int repetitions = 5;
  double seconds = 1;
};

// Holds what the repetitions with one instruction set gave.
struct Repetitions {
  Isa isa;
  std::vector<double> samples, rays, photons, records;
  std::map<std::string, double> phases_s = {};  // in all
  double time_s = 0;

  void add(const CheckpointRecord& end, double pixels) {
    const auto counted = [&](const char* name) { return static_cast<double>(find_value(end.counters, name).value_or(0)); };
    const auto phase = [&](const char* name) { return find_value(end.phases_s, name).value_or(0); };
    samples.push_back(pixels * static_cast<double>(end.iterations) / end.time_s);
    rays.push_back((counted("rays") + counted("shadow_rays")) / end.time_s);
    if (phase("emit") > 0) photons.push_back(counted("photons_emitted") / phase("emit"));
    if (counted("records") > 0 && phase("initial_pass") > 0) records.push_back(counted("records") / phase("initial_pass"));
    for (const auto& [name, seconds] : end.phases_s) phases_s[name] += seconds;
    time_s += end.time_s;
  }

  Throughput result(std::uint64_t iterations) const {
    Throughput t{std::string(isa_option(isa)), iterations, summarise(samples), summarise(rays), summarise(photons),
                 summarise(records),           {}};
    for (const auto& [name, seconds] : phases_s) t.shares[name] = seconds / time_s;
    return t;
  }
};

class ThroughputWork final : public SceneWork {
 public:
  ThroughputWork(const RunPlan& plan, RunObserver& observer)
      : SceneWork(plan, observer), choice_(choice_of<ThroughputChoice>(plan.config)) {}

  std::unique_ptr<KindRecord> begin(const Cell&) override { return std::make_unique<ThroughputRecord>(); }

  void fill(const Cell& cell, KindRecord& filled, RunDirectory&, const Progress& progress) override {
    auto& record = static_cast<ThroughputRecord&>(filled);
    record.parameters = parameters_of(plan_.config.integrators[cell.integrator]);
    std::uint64_t iterations = 1;
    for (;;) {
      const double time_s = render(cell, choice_.isas.back(), iterations).checkpoints.back().time_s;
      if (time_s >= choice_.seconds / 2 || iterations == most_iterations) break;
      iterations = std::min(most_iterations, grown(iterations, time_s));
    }
    std::vector<Repetitions> all;
    for (const Isa isa : choice_.isas) all.push_back({isa, {}, {}, {}, {}});
    for (int i = 0; i < choice_.repetitions; ++i)
      for (Repetitions& repetitions : all) {
        const CellResult result = render(cell, repetitions.isa, iterations);
        repetitions.add(result.checkpoints.back(), static_cast<double>(result.image.pixels.size()));
        const std::string hash = fmt::format("{:016x}", result.image_hash);
        if (!record.image_hash.empty() && hash != record.image_hash)
          throw Error(fmt::format("the image is another with {}: {} instead of {}", isa_name(repetitions.isa), hash,
                                  record.image_hash));
        record.image_hash = hash;
        progress((i + 1.0) / choice_.repetitions, iterations);
      }
    for (const Repetitions& repetitions : all) record.sets.push_back(repetitions.result(iterations));
  }

 private:
  static constexpr std::uint64_t most_iterations = 1 << 20;

  // Towards the time of a repetition; by no more than ten times, as the first iterations may take longer.
  std::uint64_t grown(std::uint64_t iterations, double time_s) const {
    const double factor = std::clamp(choice_.seconds / std::max(time_s, 1e-6), 1.0, 10.0);
    return std::max(iterations + 1, static_cast<std::uint64_t>(static_cast<double>(iterations) * factor));
  }

  CellResult render(const Cell& cell, Isa isa, std::uint64_t iterations) const {
    const WithIsa with_isa(isa);
    const ScenePlace& at = place(cell);
    return run_cell({at.scene, at.needs, plan_.config.accels[0], plan_.config.integrators[cell.integrator], cell.name.seed,
                     at.resolution, Budget::of_iterations(iterations), plan_.threads});
  }

  const ThroughputChoice& choice_;
};

class ThroughputKind final : public RecordKind<ThroughputRecord, ThroughputWork> {
 public:
  ThroughputKind() : RecordKind({"accels", "budget"}, {"integrators"}) {}

  std::vector<std::string> keys() const override { return {"throughput"}; }
  std::vector<std::string> measures() const override { return measured_code({"experiments/kinds/throughput"}); }
  std::string beside() const override { return "[throughput], which measures no error"; }

  void read(const ConfigNode& root, ExperimentConfig& config) const override {
    auto choice = std::make_shared<ThroughputChoice>();
    const ConfigNode& table = *find_key(root, "throughput");
    if (config.seeds.size() > 1)
      throw Error(find_key(root, "seeds")->where, "seeds: speed hardly depends on them; expected one beside [throughput]");
    TableReader reader(table, "throughput", "a table { isa, repetitions, time }");
    const std::vector<std::string> all(std::begin(isa_options), std::end(isa_options));
    std::vector<std::string> isas = all;
    reader.names("isa", isas, "instruction set", all);
    reader.whole("repetitions", choice->repetitions, 1, 1000);
    reader.duration("time", choice->seconds);
    reader.finish();
    for (const std::string& name : isas)
      if (is_supported(isa_of_option(name))) choice->isas.push_back(isa_of_option(name));
    if (choice->isas.empty())
      throw Error(table.where, fmt::format("throughput.isa: this machine has none of them; its widest is {}",
                                           isa_name(supported_isas().back())));
    config.choice = choice;
    require_scenes(config);
    const ConfigNode* methods = find_key(root, "integrators");
    if (methods == nullptr) throw Error(table.where, "no integrators; expected [[integrators]] tables beside [throughput]");
    config.integrators = read_integrators(*methods);
  }

  std::vector<std::string> quick(const ConfigNode&) const override {
    return {"resolution=[64, 64]", "throughput.repetitions=2", "throughput.time=0.05s"};
  }

  std::vector<Cell> cells(const ExperimentConfig& config) const override {
    const std::string commit = make_manifest("", "", config.threads.value_or(1)).commit;
    std::vector<Cell> cells = make_matrix(config, config.integrators);
    for (Cell& cell : cells) cell.name.accel = commit;
    return cells;
  }

  std::string effort(const ExperimentConfig& config) const override {
    const auto& choice = choice_of<ThroughputChoice>(config);
    return fmt::format("{} instruction sets, {} repetitions of about {} s", choice.isas.size(), choice.repetitions,
                       choice.seconds);
  }

  KindReport report(const RunLog& log) const override { return throughput_report(log); }
  std::string summary(const RunLog& log) const override { return throughput_summary(log); }
};

}  // namespace

const ExperimentKind& throughput_kind() { return the_kind<ThroughputKind>(); }

}  // namespace etendue
