#include "experiments/kind.h"
#include "experiments/log/field_list.h"

namespace etendue {

// Each in the folder of its name.
const ExperimentKind& animation_kind();
const ExperimentKind& claims_kind();
const ExperimentKind& images_kind();
const ExperimentKind& ledger_kind();
const ExperimentKind& search_kind();
const ExperimentKind& stress_kind();
const ExperimentKind& throughput_kind();

namespace {

std::vector<const ExperimentKind*>& kinds() {
  static std::vector<const ExperimentKind*> kinds{&stress_kind(),     &claims_kind(), &search_kind(), &animation_kind(),
                                                  &throughput_kind(), &ledger_kind(), &images_kind()};
  return kinds;
}

}  // namespace

const std::vector<const ExperimentKind*>& experiment_kinds() { return kinds(); }

void add_experiment_kind(const ExperimentKind& kind) { kinds().push_back(&kind); }

std::vector<Field> ExperimentKind::record_fields() const { return {}; }

std::string ExperimentKind::summary(const RunLog& log) const {
  std::string out;
  for (const Table& table : report(log).tables)
    if (!table.rows.empty() || !table.notes.empty()) out += to_terminal(table, 0);
  return out;
}

const ExperimentKind& kind_of(const ConfigNode& root) {
  for (const ExperimentKind* kind : experiment_kinds())
    for (const std::string& key : kind->keys())
      if (find_key(root, key) != nullptr) return *kind;
  return images_kind();
}

std::vector<std::string> measured_code(const std::vector<std::string>& folders) {
  std::vector<std::string> paths{"CMakeLists.txt",
                                 "accel",
                                 "framework",
                                 "integrators",
                                 "experiments/run",
                                 "experiments/config/budget.cpp",
                                 "experiments/log/products.cpp",
                                 "experiments/statistics",
                                 "experiments/kinds/record_kind.cpp",
                                 "experiments/kinds/second_level.cpp",
                                 "experiments/kinds/timing.cpp"};
  paths.insert(paths.end(), folders.begin(), folders.end());
  paths.emplace_back(":(exclude)experiments/kinds/*_report.*");
  return paths;
}

std::vector<std::string> ExperimentKind::measures() const { return measured_code({"experiments/kinds"}); }

std::shared_ptr<KindRecord> read_kind_record(const std::string& type, const Json& json) {
  for (const ExperimentKind* kind : experiment_kinds())
    if (kind->record_type() == type) return kind->read_record(json);
  return nullptr;
}

std::vector<std::string> kind_record_types() {
  std::vector<std::string> types;
  for (const ExperimentKind* kind : experiment_kinds())
    if (!kind->record_type().empty()) types.push_back(kind->record_type());
  return types;
}

}  // namespace etendue
