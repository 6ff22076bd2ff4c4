#include "experiments/report/tables.h"

#include "experiments/log/products.h"
#include "experiments/report/report_text.h"
#include "experiments/report/verdicts.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace etendue {
namespace {

using Cells = std::vector<TableCell>;

// Scene, integrator and structure: for readers only where there is more than one.
void add_name_columns(Table& table, const ReportData& data) {
  const auto audience = [](std::size_t count) { return count > 1 ? Audience::everyone : Audience::machines; };
  table.columns.push_back({"scene", "scene", false, audience(data.scenes.size())});
  table.columns.push_back({"integrator", "integrator", false});
  table.columns.push_back({"structure", "structure", false, audience(data.accels.size())});
}

void add_names(Cells& cells, const Configuration& configuration) {
  cells.push_back(TableCell::words(configuration.scene));
  cells.push_back(TableCell::words(configuration.integrator));
  cells.push_back(TableCell::words(configuration.accel));
}

void name_the_only(Table& table, const ReportData& data) {
  if (data.scenes.size() == 1 && !table.rows.empty()) table.notes.push_back("Scene: " + data.scenes.front().name + ".");
  if (data.accels.size() == 1 && !table.rows.empty()) table.notes.push_back("Structure: " + data.accels.front() + ".");
}

template <class Value>
std::vector<double> last_values(const Configuration& configuration, const Value& value) {
  std::vector<double> values;
  for (const Replicate& replicate : configuration.replicates) values.push_back(static_cast<double>(value(*replicate.last())));
  return values;
}

TableCell number_or_none(const std::vector<double>& values, double p, std::string (*format)(double) = format_figure) {
  if (values.empty()) return {};
  const double value = quantile(values, p);
  return TableCell::number(value, format(value));
}

// A reader's "median (P5–P95)" and a program's three columns.
void add_spread_columns(Table& table, const std::string& key, const std::string& title, std::size_t group) {
  table.columns.push_back({"", title, true, Audience::people, group});
  for (const char* part : {"median", "p5", "p95"})
    table.columns.push_back({fmt::format("{}_{}", key, part), "", true, Audience::machines, group});
}

void add_spread(Cells& cells, const std::vector<double>& values) {
  TableCell text = number_or_none(values, 0.5);
  if (values.size() > 1) text.text += " (" + format_interval(quantile(values, 0.05), quantile(values, 0.95)) + ")";
  cells.push_back(text);
  for (const double p : {0.5, 0.05, 0.95}) cells.push_back(number_or_none(values, p));
}

// --- final ---

std::optional<Estimate> error_then(const ReportData& data, const SceneData& scene, const Configuration& configuration) {
  if (data.empty() || scene.common_time_s <= 0) return std::nullopt;
  return estimate_at(configuration, data.main_metric(), scene.common_time_s, data.is_signed(data.main_metric()));
}

void add_equal_time_columns(Table& table, const ReportData& data) {
  const std::string metric = data.empty() ? "error" : data.main_metric();
  table.columns.push_back({"seeds", "seeds", true, Audience::everyone, 1});
  table.columns.push_back({"common_time_s", "at time", true, Audience::everyone, 1});
  table.columns.push_back({"", metric + " then", true, Audience::people, 1});
  for (const char* part : {"mean", "low", "high", "interval"})
    table.columns.push_back({fmt::format("{}_at_common_time_{}", metric, part), "", true, Audience::machines, 1});
  table.columns.push_back({"efficiency_per_s", "1/(relmse·time)", true, Audience::everyone, 1});
  table.columns.push_back({"target_" + metric, "target", true, Audience::everyone, 1});
  table.columns.push_back({"", "time to target", true, Audience::people, 1});
  for (const char* part : {"time_to_target_s", "time_to_target_censoring", "time_to_target_arrived"})
    table.columns.push_back({part, "", true, Audience::machines, 1});
}

void add_equal_time(Cells& cells, const ReportData& data, const SceneData& scene, const Configuration& configuration) {
  cells.push_back(TableCell::count(configuration.replicates.size()));
  cells.push_back(scene.common_time_s > 0 ? TableCell::number(scene.common_time_s, format_seconds(scene.common_time_s))
                                          : TableCell{});
  const auto estimate = error_then(data, scene, configuration);
  if (estimate) {
    TableCell text = TableCell::number(estimate->centre);
    if (estimate->spread != Spread::none)
      text.text += " (" + format_interval(estimate->interval.low, estimate->interval.high) + ")";
    constexpr const char* spreads[] = {"none", "min-max", "t95"};
    cells.push_back(text);
    cells.push_back(TableCell::number(estimate->centre));
    cells.push_back(TableCell::number(estimate->interval.low));
    cells.push_back(TableCell::number(estimate->interval.high));
    cells.push_back(TableCell::words(spreads[static_cast<int>(estimate->spread)]));
  } else {
    cells.insert(cells.end(), 5, TableCell{});
  }
  std::vector<double> efficiencies;
  for (const Replicate& replicate : configuration.replicates) {
    const auto found = replicate.last()->metrics.find("relmse");
    if (found != replicate.last()->metrics.end() && found->second > 0 && replicate.last()->time_s > 0)
      efficiencies.push_back(1 / (found->second * replicate.last()->time_s));
  }
  cells.push_back(number_or_none(efficiencies, 0.5));
  const auto arrival = data.empty() ? std::nullopt : arrival_of(configuration, data.main_metric(), scene.target_error);
  cells.push_back(scene.target_error > 0 ? TableCell::number(scene.target_error, format_short(scene.target_error))
                                         : TableCell{});
  if (!arrival) {
    cells.insert(cells.end(), 4, TableCell{});
    return;
  }
  TableCell text = TableCell::number(arrival->median.time, describe(*arrival));
  // What never arrives sorts behind every time that was measured.
  if (arrival->median.kind == Arrival::Kind::never) text.order = 1e12 + arrival->median.time;
  constexpr const char* kinds[] = {"none", "left", "right"};
  cells.push_back(text);
  cells.push_back(TableCell::number(arrival->median.time));
  cells.push_back(TableCell::words(kinds[static_cast<int>(arrival->median.kind)]));
  cells.push_back(TableCell::count(arrival->arrived));
}

void add_cost_columns(Table& table) {
  for (const auto& [key, title] : {std::pair{"iterations_median", "iterations"},
                                   {"time_median_s", "time"},
                                   {"cpu_median_s", "CPU time"},
                                   {"peak_memory_median_bytes", "peak memory"},
                                   {"non_finite", "non-finite"}})
    table.columns.push_back({key, title, true, Audience::everyone, 2});
}

void add_cost(Cells& cells, const Configuration& configuration) {
  const auto last = [&](auto value) { return last_values(configuration, value); };
  cells.push_back(number_or_none(last([](const CheckpointRecord& c) { return c.iterations; }), 0.5, format_short));
  cells.push_back(number_or_none(last([](const CheckpointRecord& c) { return c.time_s; }), 0.5, format_seconds));
  cells.push_back(number_or_none(last([](const CheckpointRecord& c) { return c.cpu_s; }), 0.5, format_seconds));
  cells.push_back(number_or_none(last([](const CheckpointRecord& c) { return c.peak_memory_bytes; }), 0.5, format_bytes));
  std::uint64_t non_finite = 0;
  for (const Replicate& replicate : configuration.replicates) non_finite += replicate.last()->non_finite;
  cells.push_back(TableCell::count(non_finite));
}

void add_theory_columns(Table& table) {
  const auto add = [&](const char* key, const char* title, Audience audience, bool right = true) {
    table.columns.push_back({key, title, right, audience, 4});
  };
  add("declared_bias", "declared", Audience::everyone, false);
  add("declared_mse_exponent", "exponent", Audience::everyone);
  add("", "measured", Audience::people);
  for (const char* key : {"measured_mse_exponent", "measured_low", "measured_high", "fit_metric", "fit_from", "fit_to"})
    add(key, "", Audience::machines);
  add("", "over iterations", Audience::people);
  add("", "bias² of images", Audience::people);
  for (const char* key : {"bias_squared", "bias_squared_standard_error"}) add(key, "", Audience::machines);
  add("image_variance", "variance", Audience::everyone);
}

// Of the images at the ends of a configuration's runs, where the log has what it takes.
std::optional<BiasVariance> image_split(const ReportData& data, const SceneData& scene, const Configuration& configuration) {
  const ProductsRecord* record = current_products(*data.log, configuration.any_cell()->cell, "", false);
  if (record == nullptr) return std::nullopt;
  return bias_variance(record->seeds.size(), record->products.front(), scene.reference->mse_floor);
}

void add_theory(Cells& cells, const ReportData& data, const SceneData& scene, const Configuration& configuration) {
  const CellRecord* cell = configuration.any_cell();
  cells.push_back(cell->bias.empty() ? TableCell{} : TableCell::words(cell->bias));
  cells.push_back(TableCell::number(cell->mse_exponent, format_short(cell->mse_exponent)));
  if (const auto rate = measured_rate(configuration, scene.reference)) {
    TableCell text = TableCell::number(rate->fit.slope, fmt::format("{:.2f}", rate->fit.slope));
    if (rate->fit.interval) text.text += fmt::format(" ({:.2f} to {:.2f})", rate->fit.interval->low, rate->fit.interval->high);
    if (rate->replicates < 10) text.text += " †";
    cells.push_back(text);
    cells.push_back(TableCell::number(rate->fit.slope));
    cells.push_back(rate->fit.interval ? TableCell::number(rate->fit.interval->low) : TableCell{});
    cells.push_back(rate->fit.interval ? TableCell::number(rate->fit.interval->high) : TableCell{});
    cells.push_back(TableCell::words(rate->metric));
    cells.push_back(TableCell::number(rate->first_iteration));
    cells.push_back(TableCell::number(rate->last_iteration));
    cells.push_back(TableCell::words(fmt::format("{:.0f}–{:.0f}", rate->first_iteration, rate->last_iteration)));
  } else {
    cells.insert(cells.end(), 8, TableCell{});
  }
  const auto split = image_split(data, scene, configuration);
  if (!split) {
    cells.insert(cells.end(), 4, TableCell{});
    return;
  }
  TableCell text = TableCell::number(split->bias_squared);
  if (split->count > 2) text.text += fmt::format(" ± {}", format_figure(split->standard_error));
  cells.push_back(text);
  cells.push_back(TableCell::number(split->bias_squared));
  cells.push_back(split->count > 2 ? TableCell::number(split->standard_error) : TableCell{});
  cells.push_back(TableCell::number(split->variance));
}

void add_final_notes(Table& table, const ReportData& data) {
  name_the_only(table, data);
  if (data.empty() || table.rows.empty()) return;
  table.notes.push_back(
      "The time at which methods are compared is the latest that every seed of every configuration of the scene reached; each "
      "seed is interpolated there on log axes. The error then is the geometric mean over seeds, in brackets its 95 % Student "
      "interval (from three seeds on; of two the extremes).");
  table.notes.push_back(
      "The target is the error that at least half of the configurations reach by that time, rounded up to 1, 2 or 5; the time "
      "to "
      "it is the median over seeds of the first crossing. \"> t\" has not arrived by t, \"≤ t\" was there at the first "
      "checkpoint.");
  table.notes.push_back(
      "Costs and metrics are medians over seeds at the last checkpoint, in brackets the 5th and 95th percentile.");
  table.notes.push_back(
      "The measured exponent is the slope of the mean squared error over iterations (the reference's variance subtracted), "
      "over "
      "the later half of the ladder in logarithms; the interval is a 95 % percentile bootstrap over seeds. † fewer than ten "
      "seeds.");
  if (!data.log->products.empty())
    table.notes.push_back(
        "bias² of images is the mean of (average over seeds − reference)² less variance/seeds less the reference's variance, ± "
        "its "
        "jackknife standard error; a negative value is below what these seeds can show.");
}

}  // namespace

Table final_table(const ReportData& data) {
  Table table{
      "final", "Results", {}, {}, {"Error at equal time", "Cost", "Metrics at the last checkpoint", "Theory and measurement"},
      {}};
  add_name_columns(table, data);
  add_equal_time_columns(table, data);
  add_cost_columns(table);
  for (const std::string& metric : data.metrics) add_spread_columns(table, metric, metric, 3);
  add_theory_columns(table);
  for (const SceneData& scene : data.scenes) {
    std::vector<std::pair<double, Cells>> rows;
    for (const Configuration& configuration : scene.configurations) {
      if (configuration.replicates.empty()) continue;
      Cells cells;
      add_names(cells, configuration);
      add_equal_time(cells, data, scene, configuration);
      add_cost(cells, configuration);
      for (const std::string& metric : data.metrics) add_spread(cells, final_values(configuration, metric));
      add_theory(cells, data, scene, configuration);
      const auto error = error_then(data, scene, configuration);
      rows.emplace_back(error ? error->centre : std::numeric_limits<double>::infinity(), std::move(cells));
    }
    std::stable_sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (auto& [error, cells] : rows) table.rows.push_back(std::move(cells));
  }
  add_final_notes(table, data);
  return table;
}

Table phases_table(const ReportData& data) {
  Table table{"phases", "Where the time went", {}, {}, {}, {}};
  add_name_columns(table, data);
  table.columns.push_back({"time_s", "time"});
  for (const std::string& phase : data.phases) table.columns.push_back({phase + "_s", phase});
  for (const SceneData& scene : data.scenes)
    for (const Configuration& configuration : scene.configurations) {
      if (configuration.replicates.empty()) continue;
      Cells cells;
      add_names(cells, configuration);
      const double total = median(last_values(configuration, [](const CheckpointRecord& c) { return c.time_s; }));
      cells.push_back(TableCell::number(total, format_seconds(total)));
      for (const std::string& phase : data.phases) {
        const double time = median(last_values(configuration, [&](const CheckpointRecord& c) {
          const auto found = c.phases_s.find(phase);
          return found == c.phases_s.end() ? 0.0 : found->second;
        }));
        if (time == 0) {
          cells.push_back({"–", "0", 0.0});
          continue;
        }
        const double share = total > 0 ? 100 * time / total : 0;
        const std::string percent = share < 0.05 ? "< 0.1" : fmt::format("{:.{}f}", share, share < 0.95 ? 1 : 0);
        cells.push_back(TableCell::number(time, fmt::format("{} ({} %)", format_seconds(time), percent)));
      }
      table.rows.push_back(std::move(cells));
    }
  name_the_only(table, data);
  if (!table.rows.empty())
    table.notes.push_back("Medians over seeds of wall time up to the last checkpoint, in brackets the share of the whole.");
  return table;
}

Table counters_table(const ReportData& data) {
  Table table{"counters", "Work per iteration", {}, {}, {}, {}};
  add_name_columns(table, data);
  for (const std::string& counter : data.counters) {
    const bool used =
        std::any_of(data.log->checkpoints.begin(), data.log->checkpoints.end(), [&](const CheckpointRecord& record) {
          const auto found = record.counters.find(counter);
          return found != record.counters.end() && found->second > 0;
        });
    std::string title = counter;
    std::replace(title.begin(), title.end(), '_', ' ');
    table.columns.push_back({counter + "_per_iteration", title, true, used ? Audience::everyone : Audience::machines});
  }
  table.columns.push_back({"rays_per_s", "rays per second"});
  for (const SceneData& scene : data.scenes)
    for (const Configuration& configuration : scene.configurations) {
      if (configuration.replicates.empty()) continue;
      Cells cells;
      add_names(cells, configuration);
      const auto counted = [](const CheckpointRecord& record, const std::string& counter) {
        const auto found = record.counters.find(counter);
        return found == record.counters.end() ? 0.0 : static_cast<double>(found->second);
      };
      for (const std::string& counter : data.counters) {
        const double value = median(last_values(configuration, [&](const CheckpointRecord& c) {
          return counted(c, counter) / static_cast<double>(std::max<std::uint64_t>(1, c.iterations));
        }));
        cells.push_back(TableCell::number(value, value == 0 ? "–" : format_count(value)));
      }
      const double rate = median(last_values(configuration, [&](const CheckpointRecord& c) {
        return c.time_s > 0 ? (counted(c, "rays") + counted(c, "shadow_rays")) / c.time_s : 0.0;
      }));
      cells.push_back(TableCell::number(rate, rate == 0 ? "–" : format_count(rate)));
      table.rows.push_back(std::move(cells));
    }
  name_the_only(table, data);
  if (!table.rows.empty()) table.notes.push_back("Medians over seeds at the last checkpoint.");
  return table;
}

}  // namespace etendue
