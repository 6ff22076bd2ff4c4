// The images of a report's page: tone-mapped pictures and error maps as PNG, and what images of several seeds tell of bias.
#pragma once

#include "experiments/report/report_data.h"
#include "experiments/report/tables.h"

#include <cstddef>
#include <string>
#include <vector>

namespace etendue {

struct PageImage {
  std::string label, detail;
  std::string png;        // base64, sRGB
  std::string error_png;  // base64; "" for the reference, and where there is none to compare with
  double relmse = -1;     // of the whole image; below zero where it is not known
};

struct SceneImages {
  std::string scene;
  ivec2 original{0}, shown{0};
  double exposure = 1;                        // what linear radiance was multiplied by
  int lowest_decade = 0, highest_decade = 0;  // of the error maps' colours
  std::vector<PageImage> images;              // the reference first, where its image was kept
  bool has_reference = false;
  std::vector<std::string> notes;
};

// One image for each scene and integrator: the lowest seed's, of the first structure that kept one (structures change only the
// time). Large images are averaged down until all of them together stay below about `budget_bytes` of page.
std::vector<SceneImages> page_images(const ReportData& data, std::size_t budget_bytes);

// viridis ([Smith2015]) at t in [0, 1] as "#rrggbb": perceptually uniform, and readable in grey and by the colour-blind.
std::string viridis_css(double t);

}  // namespace etendue
