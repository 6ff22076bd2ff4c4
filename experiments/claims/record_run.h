// Cells whose outcome is a ClaimRecord: the way from plan to log and report that claims and the catalogue of failures share.
#pragma once

#include "experiments/harness/run.h"
#include "experiments/harness/run_directory.h"

namespace etendue {

// What fills a record whose cell, manifest and status are the execution's. It may throw: the cell has failed then.
class RecordWork {
 public:
  virtual ~RecordWork() = default;
  virtual void remember(const ClaimRecord&) {}  // done by an earlier run
  // What stands in the record whether it fails or not.
  virtual void describe(const Cell& cell, ClaimRecord& record) = 0;
  virtual void fill(const Cell& cell, ClaimRecord& record, RunDirectory& directory,
                    const std::function<void(double share)>& progress) = 0;
  virtual std::string summary(const RunLog& log) const = 0;
};

RunSummary execute_records(const RunPlan& plan, RunObserver& observer, RecordWork& work);

}  // namespace etendue
