// The images of a report's page: tone-mapped pictures and error maps as PNG.
#pragma once

#include "experiments/report/report_data.h"
#include "framework/core/vec.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace etendue {

struct PageImage {
  std::string label, detail;
  std::string png;                    // base64, sRGB
  std::string error_png;              // base64; "" for the reference, and where there is none to compare with
  std::optional<double> relmse = {};  // of the whole image, where it is known
};

struct SceneImages {
  std::string scene;
  ivec2 shown{0};                             // pixels, after averaging
  int lowest_decade = 0, highest_decade = 0;  // of the error maps' colours
  std::vector<PageImage> images;              // the reference first, where its image was kept
  std::vector<std::string> notes;
};

// One image for each scene and integrator: the lowest seed's, of the first structure that kept one (structures change only the
// time). Large images are averaged down until all of them together stay below about `budget_bytes` of page.
std::vector<SceneImages> page_images(const ReportData& data, std::size_t budget_bytes);

// Gives viridis ([Smith2015]) at t in [0, 1] as "#rrggbb"; it is perceptually uniform, and readable in grey and by the
// colour-blind.
std::string viridis_css(double t);
// Gives its colours at every tenth, for a gradient of the page's style.
std::string viridis_stops();

}  // namespace etendue
