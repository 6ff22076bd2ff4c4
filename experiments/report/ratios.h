// The ratios of an experiment, measured from its log: RMSE of one method over another's at the ends of their runs, with the
// reference's own noise subtracted, and 95 % bootstrap intervals over the seeds that both have.
#pragma once

#include "experiments/report/report_data.h"
#include "experiments/report/table_format.h"

#include <optional>
#include <string>
#include <vector>

namespace etendue {

struct FoundRatio {
  const RatioClaim* claim = nullptr;
  std::string scene, method, over;  // as the log names them
  std::size_t seeds = 0;
  double rmse = 0, ratio = 0;
  std::optional<Interval> rmse_interval, ratio_interval;
  std::string problem;  // why there is no figure

  // Whether the better one is as expected; empty where the interval holds 1, there is none, or neither is expected to be.
  std::optional<bool> side_as_expected() const;
};

// One a claim, scene and configuration, in the order of the claims. Keeps pointers into the log.
std::vector<FoundRatio> find_ratios(const ReportData& data);

// Methods are named by the parameters in which they differ.
Table ratios_table(const std::vector<FoundRatio>& ratios);

// How many ratios are on the side of 1 that was expected, how many pairs of methods in the expected order, and the order found.
std::string ratios_finding(const std::vector<FoundRatio>& ratios);

}  // namespace etendue
