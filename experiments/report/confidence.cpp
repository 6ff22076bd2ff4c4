#include "experiments/report/confidence.h"

#include "experiments/report/report_data.h"
#include "experiments/statistics/statistics.h"
#include "framework/core/check.h"

#include <fmt/format.h>

#include <cmath>

namespace etendue {

namespace {

constexpr double rounded_by = 1e-6;  // of the radiance: what single precision leaves of pixels that have no noise

double luminance_of(const dvec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

std::vector<double> final_confidence(const Configuration& configuration, const std::string& name) {
  std::vector<double> values;
  for (const Replicate& replicate : configuration.replicates) {
    const auto& confidence = replicate.last()->confidence;
    if (const auto found = confidence.find(name); found != confidence.end()) values.push_back(found->second);
  }
  return values;
}

}  // namespace

std::map<std::string, double> confidence_of(const Image& image, const Image& standard_error, const Image& reference) {
  CHECK(image.size == reference.size && image.size == standard_error.size);
  double within_1 = 0, within_2 = 0, stated = 0, squared_errors = 0;
  const auto n = static_cast<double>(image.pixels.size());
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const double error = std::abs(luminance_of(image.pixels[i] - reference.pixels[i]));
    const double sigma = luminance_of(standard_error.pixels[i]);
    const double rounding = rounded_by * std::abs(luminance_of(reference.pixels[i]));
    within_1 += error <= sigma + rounding;
    within_2 += error <= 2 * sigma + rounding;
    stated += sigma * sigma;
    squared_errors += error * error;
  }
  return {{"within_1", within_1 / n},
          {"within_2", within_2 / n},
          {"stated", std::sqrt(stated / n)},
          {"true", std::sqrt(squared_errors / n)}};
}

Table confidence_table(const ReportData& data) {
  Table table{"confidence", "Does the method know its error?", {}, {}, {}, {}};
  table.columns = {{"scene", "scene", false},
                   {"integrator", "integrator", false},
                   {"structure", "", false, Audience::machines},
                   {"seeds", "seeds"},
                   {"iterations", "iterations"},
                   {"within_1", "pixels within 1 s.e."},
                   {"within_2", "within 2 s.e."},
                   {"stated", "stated error (RMS)"},
                   {"true", "true error (RMS)"}};
  for (const SceneData& scene : data.scenes) {
    if (scene.reference == nullptr || scene.reference->mse_floor > 0) continue;
    for (const Configuration& configuration : scene.configurations) {
      const std::size_t seeds = final_confidence(configuration, "within_1").size();
      if (seeds == 0) continue;
      std::vector<TableCell> row{TableCell::words(configuration.scene), TableCell::words(configuration.integrator),
                                 TableCell::words(configuration.accel), TableCell::count(seeds),
                                 TableCell::count(configuration.replicates.front().last()->iterations)};
      for (const char* share : {"within_1", "within_2"}) {
        const double value = median(final_confidence(configuration, share));
        row.push_back(TableCell::number(value, fmt::format("{:.1f} %", 100 * value)));
      }
      for (const char* error : {"stated", "true"}) {
        const double value = median(final_confidence(configuration, error));
        row.push_back(TableCell::number(value, fmt::format("{:.3g}", value)));
      }
      table.rows.push_back(std::move(row));
    }
  }
  if (!table.rows.empty())
    table.notes.push_back(
        "Scenes with a closed form; medians over seeds. The share of pixels whose error in luminance is at most one and two of "
        "the "
        "standard errors that the method states for each pixel by itself. Normal errors stated rightly: 68.3 % and 95.4 %; "
        "more, "
        "the method states too much; less, too little.");
  return table;
}

}  // namespace etendue
