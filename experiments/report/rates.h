// Exponents measured from a log: of each configuration, and those that an experiment predicts, whose points are collected by
// region, method and metric, fitted, and held against theory.
#pragma once

#include "experiments/report/charts/charts.h"
#include "experiments/report/predictions.h"
#include "experiments/report/report_data.h"
#include "experiments/statistics/rate_fit.h"

#include <optional>
#include <string>
#include <vector>

namespace etendue {

struct FittedRate {
  const Prediction* law = nullptr;  // the prediction of an exponent
  std::string scene, method;        // as the law names it, or, where that selects several, as charts do
  std::size_t seeds = 0;
  std::vector<RatePoint> points;  // all that were logged, by x, within the law's window or not
  std::optional<RateFit> fit;
  std::string problem;       // why there is no fit
  bool holds_noise = false;  // of a reference of which it is not known, or not of the region
};

// There is one for each law, scene and configuration, in the order of the laws. They keep pointers into the log.
std::vector<FittedRate> fit_rates(const ReportData& data);

Predictions exponent_predictions(const std::vector<FittedRate>& rates);

// Slope of the mean squared error over iterations against the declared exponent: over the later half (in log iterations) of the
// iteration counts all seeds share, at least three of them; of mse less the reference's variance, or of relmse where mse was
// not logged. There is none where the mean over seeds is not above that variance at each of them.
struct MeasuredRate {
  RateFit fit;
  std::size_t replicates = 0;
  std::string metric;
};
std::optional<MeasuredRate> measured_rate(const Configuration& configuration, const ReferenceRecord* reference);

// One a scene, region, metric and abscissa: the points of each method with their band, the fit as a thin line over its window,
// and beside it a triangle of theory's slope.
std::vector<Figure> rate_figures(const std::vector<FittedRate>& rates);

}  // namespace etendue
