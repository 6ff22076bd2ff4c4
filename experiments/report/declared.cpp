#include "experiments/report/declared.h"

#include "experiments/report/report_data.h"
#include "experiments/statistics/statistics.h"
#include "framework/core/check.h"

#include <fmt/format.h>

#include <cmath>

namespace etendue {

namespace {

constexpr std::size_t fewest_seeds = 3;  // that give a standard error worth the name
constexpr double sigmas = 4;

std::string declaration_of(const CellRecord& cell) {
  const std::string bound = cell.bias_bound > 0 ? ", at most " + figure_text(FigureKind::share, cell.bias_bound) : "";
  return fmt::format("declared by the method: {}{}", cell.bias, bound);
}

// Those whose reference is exact.
std::vector<const Configuration*> exactly_measured(const ReportData& data) {
  std::vector<const Configuration*> configurations;
  for (const SceneData& scene : data.scenes)
    if (scene.reference != nullptr && is_exact(*scene.reference))
      for (const Configuration* configuration : scene.finished()) configurations.push_back(configuration);
  return configurations;
}

struct Coverage {
  const char *name, *text;
  double least;  // of normal errors
};
constexpr Coverage coverages[] = {{"within_1", "pixels within 1 standard error", 0.683},
                                  {"within_2", "pixels within 2 standard errors", 0.954}};

double luminance_of(const dvec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

// Shows the image that is farthest from what is expected, and judges it.
JudgedPrediction judged_images(const Prediction& prediction, const Configuration& configuration) {
  JudgedPrediction row{.scene = configuration.scene,
                       .method = configuration.shown_integrator,
                       .structure = configuration.shown_accel,
                       .quantity = "bias of each image",
                       .source = prediction.source,
                       .kind = FigureKind::share,
                       .expected = prediction.expected};
  const std::vector<double> biases = final_values(configuration, "bias");
  if (biases.empty()) {
    row.problem = "no image";
    return row;
  }
  const auto beyond = [&](double bias) { return std::max(row.expected->low - bias, bias - row.expected->high); };
  const double farthest = *std::ranges::max_element(biases, {}, beyond);
  const auto [least, most] = std::ranges::minmax(biases);
  row.measure(farthest, Interval{least, most});
  row.verdict = judge(farthest, {farthest, farthest}, *row.expected, {});
  // A seed that failed, or whose bias is not finite, may be the one that is off: without it the others can only refute.
  const bool lacks_images = biases.size() < configuration.replicates.size() + configuration.failures.size();
  if (lacks_images && row.verdict == Verdict::confirmed) row.verdict = Verdict::undecided;
  row.details = {{"seeds", biases.size()}, {"iterations", configuration.replicates.front().last()->iterations}};
  return row;
}

std::vector<double> final_confidence(const Configuration& configuration, const std::string& name) {
  std::vector<double> values;
  for (const Replicate& replicate : configuration.replicates)
    if (const auto value = find_value(replicate.last()->confidence, name)) values.push_back(*value);
  return values;
}

}  // namespace

bool is_exact(const ReferenceRecord& reference) { return reference.source.starts_with("closed form"); }
bool knows_variance(const ReferenceRecord& reference) { return !reference.checks.starts_with("none"); }

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

Predictions bias_predictions(const ReportData& data) {
  Predictions predictions;
  for (const Configuration* measured : exactly_measured(data)) {
    const Configuration& configuration = *measured;
    const std::vector<double> biases = final_values(configuration, "bias");
    if (biases.size() < fewest_seeds) continue;
    const double centre = mean(biases), error = sample_sd(biases) / std::sqrt(static_cast<double>(biases.size()));
    const CellRecord& cell = *configuration.any_cell();
    JudgedPrediction row{.scene = configuration.scene,
                         .method = configuration.shown_integrator,
                         .structure = configuration.shown_accel,
                         .quantity = "bias of the mean",
                         .source = declaration_of(cell),
                         .kind = FigureKind::share,
                         .expected = Expected{0 - cell.bias_bound, cell.bias_bound}};
    row.measure(centre, Interval{centre - sigmas * error, centre + sigmas * error});
    const double least = std::max(0.0, std::abs(centre) - sigmas * error - rounded_by);
    row.verdict = judge(least, {least, least}, *row.expected, {});
    row.details = {{"seeds", biases.size()},
                   {"iterations", configuration.replicates.front().last()->iterations},
                   {"standard_error", TableCell(error, figure_text(FigureKind::share, error))}};
    predictions.rows.push_back(std::move(row));
  }
  if (!predictions.rows.empty())
    predictions.notes.push_back(fmt::format(
        "Bias: on scenes with a closed form, {} seeds or more, with {:g} standard errors over the seeds on either side, of "
        "which the least bias is judged, less {:g} of rounding; noise alone is beyond them once in 18 rows of three seeds, and "
        "once in 300 of ten. A consistent method that declares no figure has none to spare, however few its iterations.",
        fewest_seeds, sigmas, rounded_by));
  return predictions;
}

Predictions image_bias_predictions(const ReportData& data) {
  Predictions predictions;
  for (const Prediction& prediction : data.log->stated.predictions)
    for (const SceneData& scene : data.scenes)
      if (prediction.quantity == Prediction::Quantity::bias && data.log->stated.concerns(prediction, scene.name))
        for (const Configuration* configuration : selected(scene, prediction.method, false))
          predictions.rows.push_back(judged_images(prediction, *configuration));
  if (!predictions.rows.empty())
    predictions.notes.push_back(
        "Bias of each image: of the seed whose mean is farthest from what is expected, which all are to keep, with the range "
        "over seeds; the noise of the reference is within it.");
  return predictions;
}

Predictions confidence_predictions(const ReportData& data) {
  Predictions predictions;
  for (const Configuration* measured : exactly_measured(data)) {
    const Configuration& configuration = *measured;
    if (final_confidence(configuration, "within_1").empty()) continue;
    for (const Coverage& coverage : coverages) {
      const std::vector<double> shares = final_confidence(configuration, coverage.name);
      JudgedPrediction row{.scene = configuration.scene,
                           .method = configuration.shown_integrator,
                           .structure = configuration.shown_accel,
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
  if (!predictions.rows.empty())
    predictions.notes.push_back(
        "Pixels within standard errors: on scenes with a closed form; medians over seeds, with their quartiles. The share of "
        "pixels whose error in luminance is at most one and two of the standard errors that the method states for each pixel "
        "by itself. A larger share than that of normal errors says that the method states too much, a smaller one, too "
        "little.");
  return predictions;
}

}  // namespace etendue
