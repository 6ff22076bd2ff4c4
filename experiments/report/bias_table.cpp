// Whether methods keep what they declare of their bias: on scenes with a closed form, over several seeds.
#include "experiments/report/report_text.h"
#include "experiments/report/tables.h"
#include "experiments/statistics/statistics.h"

#include <fmt/format.h>

#include <cmath>

namespace etendue {

namespace {

constexpr std::size_t fewest_seeds = 3;  // that give a standard error worth the name
constexpr double sigmas = 4;

std::string declared(const CellRecord& cell) {
  const std::string bound = cell.bias_bound > 0 ? ", at most " + figure_text(FigureKind::share, cell.bias_bound) : "";
  return fmt::format("declared by the method: {}{}", cell.bias, bound);
}

}  // namespace

Predictions bias_predictions(const ReportData& data) {
  Predictions predictions;
  for (const SceneData& scene : data.scenes) {
    if (scene.reference == nullptr || scene.reference->mse_floor > 0) continue;
    for (const Configuration& configuration : scene.configurations) {
      const std::vector<double> biases = final_values(configuration, "bias");
      if (biases.size() < fewest_seeds) continue;
      const double centre = mean(biases), error = sample_sd(biases) / std::sqrt(static_cast<double>(biases.size()));
      const CellRecord& cell = *configuration.any_cell();
      JudgedPrediction row{.scene = configuration.scene,
                           .method = configuration.integrator,
                           .structure = configuration.accel,
                           .quantity = "bias of the mean",
                           .source = declared(cell),
                           .kind = FigureKind::share,
                           .expected = Expected{0 - cell.bias_bound, cell.bias_bound}};
      row.measure(centre, Interval{centre - sigmas * error, centre + sigmas * error});
      const double least = std::max(0.0, std::abs(centre) - sigmas * error);
      row.verdict = judge(least, {least, least}, *row.expected, {});
      row.details = {{"seeds", biases.size()},
                     {"iterations", configuration.replicates.front().last()->iterations},
                     {"standard_error", TableCell(error, figure_text(FigureKind::share, error))}};
      predictions.rows.push_back(std::move(row));
    }
  }
  if (!predictions.rows.empty())
    predictions.notes.push_back(fmt::format(
        "Bias: on scenes with a closed form, {} seeds or more, with {:g} standard errors over the seeds on either side, of "
        "which "
        "the least bias is judged; a consistent method that declares no figure has none to spare, however few its iterations.",
        fewest_seeds, sigmas));
  return predictions;
}

}  // namespace etendue
