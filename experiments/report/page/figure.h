// A figure in the page.
#pragma once

#include "experiments/report/charts.h"

#include <string>

namespace etendue {

// The title, the panels and the notes; and the buttons that switch its series, where there are several.
std::string stage_html(const Figure& figure);
std::string legend_html(const Figure& figure);

// A figure of one variant, which never changes; "" where there is nothing to draw.
std::string figure_html(const Figure& figure);

}  // namespace etendue
