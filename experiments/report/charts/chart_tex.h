// Charts for papers: a LaTeX file of its own that draws with pgfplots, and its points as a table beside it.
#pragma once

#include "experiments/report/charts/charts.h"

#include <string>

namespace etendue {

// Writes a document of class `standalone`, which reads `data_file`: pdflatex makes one page of it, and with the package
// `standalone` a paper inputs it as it is. Colours, dashes and marks are those of the SVG.
std::string to_pgfplots(const Figure& figure, const std::string& data_file);
// The points of all series: columns "series x y low high", of which the comments name the series.
std::string pgfplots_data(const Figure& figure);

}  // namespace etendue
