// A kind of experiment: what it varies and measures. A kind is a folder under kinds/ and a line in kinds/registry.cpp; the
// harness knows this interface and none of the kinds.
//
// The way of an experiment: `read` makes its choice from the keys of the file, `cells` lists what is to run, `run` measures and
// logs, and `report` and `summary` tell what a log holds. A kind whose cells end in one record each runs by execute_records
// (kinds/record_kind.h) and derives its record from KindRecord (log/log.h).
#pragma once

#include "experiments/config/cells.h"
#include "experiments/config/config.h"
#include "experiments/log/log.h"
#include "experiments/report/kind_report.h"
#include "experiments/run/run.h"

#include <memory>
#include <string>
#include <vector>

namespace etendue {

struct Field;  // experiments/log/field_list.h

class ExperimentKind {
 public:
  virtual ~ExperimentKind() = default;

  // Keys of which one makes an experiment one of this kind, and those that may stand beside it.
  virtual std::vector<std::string> keys() const = 0;
  virtual std::vector<std::string> companions() const { return {}; }
  // Keys that would change nothing here, and what a message says they stand beside.
  virtual std::vector<std::string> useless() const { return {}; }
  virtual std::string beside() const { return ""; }
  // Fills in config.choice, and what else the kind reads; any experiment's keys are read already. Throws Error.
  virtual void read(const ConfigNode& root, ExperimentConfig& config) const = 0;
  // The assignments of `--quick` where the file has no [quick].
  virtual std::vector<std::string> quick(const ConfigNode&) const { return {}; }
  // The methods and structures that config.choice names, with all their parameters (run/recipe.h): with other defaults it is
  // another experiment.
  virtual std::vector<std::string> resolved(const ExperimentConfig&) const { return {}; }
  virtual std::vector<Cell> cells(const ExperimentConfig& config) const = 0;
  virtual std::string effort(const ExperimentConfig&) const { return ""; }  // of each cell, in words
  // The paths, from the project's folder, whose code its figures depend on, as git takes them; default: of all kinds.
  virtual std::vector<std::string> measures() const;

  // Throws Error; a cell that fails is logged and counted instead. `compute` renders an image.
  virtual RunSummary run(const RunPlan& plan, RunObserver& observer, const CellFunction& compute) const = 0;

  virtual std::string record_type() const { return ""; }  // of its lines in the log
  virtual std::shared_ptr<KindRecord> read_record(const Json&) const { return nullptr; }
  virtual std::vector<Field> record_fields() const;  // default: none
  virtual KindReport report(const RunLog&) const { return {}; }
  virtual std::string summary(const RunLog& log) const;  // what `etendue run` prints at its end, or ""; default: all tables
};

// Kinds come in the order in which they are looked for; the last, of images, is what an experiment is without any of their
// keys.
const std::vector<const ExperimentKind*>& experiment_kinds();

// The only one of its kind.
template <class Kind>
const ExperimentKind& the_kind() {
  static const Kind kind;
  return kind;
}

// Adds one that comes from elsewhere.
void add_experiment_kind(const ExperimentKind& kind);

// The paths of the code that every kind measures, and the folders of its own; code that only reports is left out.
std::vector<std::string> measured_code(const std::vector<std::string>& folders);

// The kind that a file's keys ask for.
const ExperimentKind& kind_of(const ConfigNode& root);

}  // namespace etendue
