// The ratios that an experiment asks for, measured from its log: RMSE of one method over another's at the ends of their runs,
// with the reference's own noise subtracted, and 95 % bootstrap intervals over the seeds that both have.
#pragma once

#include "experiments/report/predictions.h"
#include "experiments/report/report_data.h"

namespace etendue {

// There is a row for each prediction, scene and configuration, in the order of the predictions. Methods are named by the
// parameters in which they differ. `order` says how many pairs of methods are in the order expected.
Predictions ratio_predictions(const ReportData& data);

}  // namespace etendue
