// Whether methods keep what they declare of their bias: on scenes with a closed form, over several seeds.
#include "experiments/report/report_text.h"
#include "experiments/report/tables.h"
#include "experiments/statistics/statistics.h"

#include <fmt/format.h>

#include <cmath>
#include <numeric>

namespace etendue {

namespace {

constexpr std::size_t fewest_seeds = 3;  // that give a standard error worth the name
constexpr double sigmas = 4;

std::string percent(double share) { return fmt::format("{:.3g} %", 100 * share); }

std::string declared(const CellRecord& cell) {
  return cell.bias_bound > 0 ? fmt::format("{}, at most {}", cell.bias, percent(cell.bias_bound)) : cell.bias;
}

}  // namespace

Table bias_table(const ReportData& data) {
  Table table{"bias", "Bias against what is declared", {}, {}, {}, {}};
  table.columns = {{"scene", "scene", false},
                   {"integrator", "integrator", false},
                   {"structure", "", false, Audience::machines},
                   {"declared", "declared", false},
                   {"seeds", "seeds"},
                   {"iterations", "iterations"},
                   {"bias", "bias of the mean"},
                   {"standard_error", "standard error"},
                   {"limit", "limit"},
                   {"kept", "kept", false}};
  for (const SceneData& scene : data.scenes) {
    if (scene.reference == nullptr || scene.reference->mse_floor > 0) continue;
    for (const Configuration& configuration : scene.configurations) {
      const std::vector<double> biases = final_values(configuration, "bias");
      if (biases.size() < fewest_seeds) continue;
      const auto n = static_cast<double>(biases.size());
      const double mean = std::accumulate(biases.begin(), biases.end(), 0.0) / n;
      double squares = 0;
      for (const double bias : biases) squares += (bias - mean) * (bias - mean);
      const double error = std::sqrt(squares / (n * (n - 1)));
      const CellRecord& cell = *configuration.any_cell();
      const double limit = cell.bias_bound + sigmas * error;
      const bool kept = std::abs(mean) <= limit;
      table.rows.push_back({TableCell::words(configuration.scene), TableCell::words(configuration.integrator),
                            TableCell::words(configuration.accel), TableCell::words(declared(cell)),
                            TableCell::count(biases.size()),
                            TableCell::count(configuration.replicates.front().last()->iterations),
                            TableCell::number(mean, percent(mean)), TableCell::number(error, percent(error)),
                            TableCell::number(limit, percent(limit)), TableCell::words(kept ? "yes" : "NO")});
    }
  }
  if (!table.rows.empty())
    table.notes.push_back(fmt::format(
        "Scenes with a closed form, {} seeds or more. The limit is what the method declares plus {:g} standard errors over the "
        "seeds; a consistent method without a figure of its own has none to spare, however few its iterations.",
        fewest_seeds, sigmas));
  return table;
}

}  // namespace etendue
