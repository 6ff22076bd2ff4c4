// How errors fall against how theory says they do: a table of exponents with their intervals, and a log-log chart a region.
#pragma once

#include "experiments/report/charts.h"
#include "experiments/report/rates.h"
#include "experiments/report/table_format.h"

#include <string>
#include <vector>

namespace etendue {

Table rates_table(const std::vector<FittedRate>& rates);

// One a scene, region, metric and abscissa: the points of each method with their band, the fit as a thin line over its window,
// and beside it a triangle of theory's slope.
std::vector<Figure> rate_figures(const std::vector<FittedRate>& rates);

// "9 of 10 intervals contain theory's exponent; not: …". Empty without laws.
std::string rates_finding(const std::vector<FittedRate>& rates);

}  // namespace etendue
