#include "experiments/report/confidence.h"

#include "experiments/report/report_data.h"
#include "experiments/statistics/statistics.h"
#include "framework/core/check.h"

#include <fmt/format.h>

#include <cmath>

namespace etendue {

namespace {

constexpr double rounded_by = 1e-6;  // of the radiance: what single precision leaves of pixels that have no noise

struct Coverage {
  const char *name, *text;
  double least;  // of normal errors
};
constexpr Coverage coverages[] = {{"within_1", "pixels within 1 standard error", 0.683},
                                  {"within_2", "pixels within 2 standard errors", 0.954}};

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

Predictions confidence_predictions(const ReportData& data) {
  Predictions predictions;
  for (const SceneData& scene : data.scenes) {
    if (scene.reference == nullptr || scene.reference->mse_floor > 0) continue;
    for (const Configuration& configuration : scene.configurations) {
      if (final_confidence(configuration, "within_1").empty()) continue;
      for (const Coverage& coverage : coverages) {
        const std::vector<double> shares = final_confidence(configuration, coverage.name);
        JudgedPrediction row{.scene = configuration.scene,
                             .method = configuration.integrator,
                             .structure = configuration.accel,
                             .quantity = coverage.text,
                             .source = "normal errors that are stated rightly",
                             .kind = FigureKind::share,
                             .expected = Expected{coverage.least, 1}};
        row.measure(median(shares), Interval{quantile(shares, 0.25), quantile(shares, 0.75)});
        row.details = {{"seeds", shares.size()}, {"iterations", configuration.replicates.front().last()->iterations}};
        for (const char* error : {"stated", "true"}) {
          const double value = median(final_confidence(configuration, error));
          row.details.emplace_back(error, TableCell(value, fmt::format("{:.3g}", value)));
        }
        predictions.rows.push_back(std::move(row));
      }
    }
  }
  if (!predictions.rows.empty())
    predictions.notes.push_back(
        "Pixels within standard errors: on scenes with a closed form; medians over seeds, with their quartiles. The share of "
        "pixels whose error in luminance is at most one and two of the standard errors that the method states for each pixel "
        "by "
        "itself. A larger share than that of normal errors says that the method states too much, a smaller one, too little.");
  return predictions;
}

}  // namespace etendue
