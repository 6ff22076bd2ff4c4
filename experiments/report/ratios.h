// The ratios that an experiment asks for, measured from its log: RMSE of one method over another's at the ends of their runs,
// with the reference's own noise subtracted, and 95 % bootstrap intervals over the seeds that both have.
#pragma once

#include "experiments/report/predictions.h"
#include "experiments/report/report_data.h"

#include <optional>
#include <string>
#include <vector>

namespace etendue {

struct FoundRatio {
  const Prediction* prediction = nullptr;
  std::string scene, method, over;  // as the log names them
  std::size_t seeds = 0;
  double rmse = 0, ratio = 0;
  std::optional<Interval> rmse_interval, ratio_interval;
  std::string problem;  // why there is no figure
};

// There is one for each prediction, scene and configuration, in the order of the predictions. They keep pointers into the log.
std::vector<FoundRatio> find_ratios(const ReportData& data);

// Methods are named by the parameters in which they differ. `order` says how many pairs of methods are in the order expected.
Predictions ratio_predictions(const std::vector<FoundRatio>& ratios);

}  // namespace etendue
