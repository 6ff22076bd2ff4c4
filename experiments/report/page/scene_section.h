// What the page shows of each scene: thumbnails, the error at equal time, charts and the viewer.
#pragma once

#include "experiments/report/charts/charts.h"
#include "experiments/report/page/images.h"
#include "experiments/report/report_data.h"

#include <string>
#include <vector>

namespace etendue {

// A part of the page with a heading that its contents link to; the body is HTML.
struct Section {
  std::string id, heading, body;

  std::string text() const;
  std::string link() const;
};

// Which variants of the charts the page can afford.
struct Variants {
  std::vector<std::string> metrics;
  std::vector<Scale> scales{Scale::log, Scale::linear};
  std::string note;
};
Variants affordable(const ReportData& data, std::size_t budget_bytes);

// The title, the panels and the notes of a figure; and the buttons that switch its series, where there are several.
std::string stage_html(const Figure& figure);
std::string legend_html(const Figure& figure);

Section scene_section(const ReportData& data, const SceneData& scene, const Variants& variants,
                      const std::vector<SceneImages>& images);

// All scenes' thumbnails, each a link to its image in the viewer.
std::string gallery_html(const ReportData& data, const std::vector<SceneImages>& scenes);
// What the viewers read.
std::string images_json(const std::vector<SceneImages>& scenes);

}  // namespace etendue
