// How errors fall against how theory says they do: exponents with their intervals, and a log-log chart a region.
#pragma once

#include "experiments/report/charts.h"
#include "experiments/report/predictions.h"
#include "experiments/report/rates.h"

#include <vector>

namespace etendue {

Predictions exponent_predictions(const std::vector<FittedRate>& rates);

// One a scene, region, metric and abscissa: the points of each method with their band, the fit as a thin line over its window,
// and beside it a triangle of theory's slope.
std::vector<Figure> rate_figures(const std::vector<FittedRate>& rates);

}  // namespace etendue
