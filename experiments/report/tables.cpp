#include "experiments/report/tables.h"

#include "experiments/log/products.h"
#include "experiments/report/rates.h"
#include "experiments/report/report_text.h"
#include "experiments/report/table_of.h"
#include "experiments/report/verdicts.h"
#include "experiments/statistics/rank_test.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

namespace etendue {
namespace {

using Cells = std::vector<TableCell>;
using Format = std::string (*)(double);

// Scene, integrator and structure of a record's configuration, for readers only where there is more than one.
template <class Record, class Get>
void add_names(TableOf<Record>& table, const ReportData& data, const Get& configuration) {
  using Name = std::string Configuration::*;
  const auto add = [&](const char* title, Name shown, Name name, std::size_t count) {
    const auto cell = [&](const Record& record) { return NameCell(configuration(record).*shown, configuration(record).*name); };
    table.column(title, title, cell, count > 1 ? Audience::everyone : Audience::machines);
  };
  add("scene", &Configuration::scene, &Configuration::scene, data.scenes.size());
  add("integrator", &Configuration::shown_integrator, &Configuration::integrator, 2);
  add("structure", &Configuration::shown_accel, &Configuration::accel, data.accels.size());
  if (data.scenes.size() == 1) table.note("Scene: " + data.scenes.front().name + ".");
  if (data.accels.size() == 1) table.note("Structure: " + data.shown_accels.front() + ".");
}

// Gives the value of each seed's last checkpoint.
template <class Value>
std::vector<double> last_values(const Configuration& configuration, const Value& value) {
  return mapped(configuration.replicates,
                [&](const Replicate& of) { return static_cast<double>(std::invoke(value, *of.last())); });
}

TableCell median_cell(const std::vector<double>& values, Format format = format_figure) {
  return values.empty() ? TableCell() : TableCell(median(values), format);
}

// --- final ---

struct FinalRow {
  const SceneData* scene;
  const Configuration* configuration;
  std::optional<Estimate> error = {};         // at the scene's common time
  std::optional<ArrivalMedian> arrival = {};  // at its target
  std::optional<RankTest> rank = {};          // of the errors then, against those of the scene's first row
  bool has_few = false;                       // too few seeds for that, of either
  std::optional<MeasuredRate> rate = {};
  std::optional<BiasVariance> split = {};  // of the images at the ends of the runs, where the log has what it takes
};
using FinalTable = TableOf<FinalRow>;

// A and B: the seeds' errors at equal time against those of the least error.
void compare_with_first(const ReportData& data, const SceneData& scene, std::span<FinalRow> rows) {
  if (rows.size() < 2 || !rows[0].error || data.is_signed(data.main_metric())) return;
  const auto errors = [&](const FinalRow& row) {
    return values_at(*row.configuration, data.main_metric(), scene.common_time_s);
  };
  const std::vector<double> first = errors(rows[0]);
  for (FinalRow& row : rows.subspan(1)) {
    const std::vector<double> own = errors(row);
    if (!row.error || own.empty()) continue;
    row.rank = rank_test(first, own);
    row.has_few = std::min(first.size(), own.size()) < enough_replicates;
  }
}

// In each scene the least error at equal time comes first; of a metric with a sign, that nearest to zero.
std::vector<FinalRow> final_rows(const ReportData& data) {
  std::vector<FinalRow> rows;
  for (const SceneData& scene : data.scenes) {
    const auto first = static_cast<std::ptrdiff_t>(rows.size());
    for (const Configuration* configuration : scene.finished()) {
      FinalRow& row = rows.emplace_back(FinalRow{&scene, configuration});
      if (!data.empty()) {
        const std::string& metric = data.main_metric();
        if (scene.common_time_s > 0)
          row.error = estimate_at(*configuration, metric, scene.common_time_s, data.is_signed(metric));
        row.arrival = arrival_of(*configuration, metric, scene.target_error);
      }
      row.rate = measured_rate(*configuration, scene.reference);
      if (const auto* products = current_products(*data.log, configuration->any_cell()->cell, "", false))
        row.split = bias_variance(products->seeds.size(), products->products.front(), scene.reference->mse_floor);
    }
    std::stable_sort(rows.begin() + first, rows.end(), [](const FinalRow& a, const FinalRow& b) {
      return a.error && (!b.error || std::abs(a.error->centre) < std::abs(b.error->centre));
    });
    compare_with_first(data, scene, std::span(rows).subspan(static_cast<std::size_t>(first)));
  }
  return rows;
}

TableCell efficiency(const FinalRow& row) {
  std::vector<double> values;
  for (const Replicate& replicate : row.configuration->replicates) {
    const auto relmse = find_value(replicate.last()->metrics, "relmse");
    if (relmse && *relmse > 0 && replicate.last()->time_s > 0) values.push_back(1 / (*relmse * replicate.last()->time_s));
  }
  return median_cell(values);
}

Cells error_then(const FinalRow& row) {
  constexpr const char* spreads[] = {"none", "min-max", "t95"};
  if (!row.error) return {};
  const auto& [centre, interval, spread, count] = *row.error;
  return {spread == Spread::none ? TableCell(centre) : TableCell::interval(centre, interval.low, interval.high), centre,
          interval.low, interval.high, spreads[static_cast<int>(spread)]};
}

// What never arrives sorts behind every time that was measured.
Cells arrival_cells(const Arrival& arrival, const std::string& text) {
  constexpr const char* censorings[] = {"none", "left", "right"};
  TableCell shown(arrival.time, text);
  if (arrival.kind == Arrival::Kind::never) shown.order = 1e12 + arrival.time;
  return {shown, arrival.time, censorings[static_cast<int>(arrival.kind)]};
}

// The time by which 95 % of the seeds arrived has cells only where there are two: one seed has its median alone.
Cells late_time_to_target(const FinalRow& row) {
  if (!row.arrival || row.arrival->count < 2) return {};
  const Arrival& late = row.arrival->late;
  const char* mark = late.kind == Arrival::Kind::never ? "> " : late.kind == Arrival::Kind::before ? "≤ " : "";
  return arrival_cells(late, mark + format_seconds(late.time));
}

Cells compared(const FinalRow& row) {
  if (!row.rank) return {};
  const std::string text = fmt::format("{:.2g}", row.rank->p) + (row.has_few ? " ‡" : "");
  return {{row.rank->p, text}, row.rank->p, row.rank->share};
}

Cells time_to_target(const FinalRow& row) {
  if (!row.arrival) return {};
  Cells cells = arrival_cells(row.arrival->median, describe(*row.arrival));
  cells.emplace_back(row.arrival->arrived);
  return cells;
}

void add_equal_time(FinalTable& table, const ReportData& data) {
  const std::string metric = data.empty() ? "error" : data.main_metric(), then = metric + "_at_common_time_";
  table.group("Error at equal time");
  table.column("seeds", "seeds", [](const FinalRow& row) { return row.configuration->replicates.size(); });
  table.column("common_time_s", "at time",
               [](const FinalRow& row) { return TableCell::positive(row.scene->common_time_s, format_seconds); });
  table.parts(metric + " then", {then + "mean", then + "low", then + "high", then + "interval"}, error_then);
  table.parts("p against the first", {"rank_p", "rank_share"}, compared);
  table.column("efficiency_per_s", "1/(relmse·time)", efficiency);
  table.column("target_" + metric, "target",
               [](const FinalRow& row) { return TableCell::positive(row.scene->target_error, format_short); });
  table.parts("time to target", {"time_to_target_s", "time_to_target_censoring", "time_to_target_arrived"}, time_to_target);
  table.parts("95 % by", {"time_to_target_p95_s", "time_to_target_p95_censoring"}, late_time_to_target);
}

void add_cost(FinalTable& table) {
  const auto add = [&](const char* key, const char* title, auto value, Format format) {
    table.column(key, title, [=](const FinalRow& row) { return median_cell(last_values(*row.configuration, value), format); });
  };
  table.group("Cost");
  add("iterations_median", "iterations", &CheckpointRecord::iterations, format_short);
  add("time_median_s", "time", &CheckpointRecord::time_s, format_seconds);
  add("cpu_median_s", "CPU time", &CheckpointRecord::cpu_s, format_seconds);
  add("peak_memory_median_bytes", "peak memory", &CheckpointRecord::peak_memory_bytes, format_bytes);
  table.column("non_finite", "non-finite", [](const FinalRow& row) {
    std::uint64_t sum = 0;
    for (const Replicate& replicate : row.configuration->replicates) sum += replicate.last()->non_finite;
    return sum;
  });
}

void add_metrics(FinalTable& table, const ReportData& data) {
  table.group("Metrics at the last checkpoint");
  for (const std::string& metric : data.metrics)
    table.parts(metric, {metric + "_median", metric + "_p5", metric + "_p95"}, [&](const FinalRow& row) -> Cells {
      const std::vector<double> values = final_values(*row.configuration, metric);
      if (values.empty()) return {};
      const double middle = median(values), low = quantile(values, 0.05), high = quantile(values, 0.95);
      return {values.size() > 1 ? TableCell::interval(middle, low, high) : middle, middle, low, high};
    });
}

Cells fitted_exponent(const FinalRow& row) {
  if (!row.rate) return {};
  const auto& [fit, replicates, metric] = *row.rate;
  const std::optional<Interval>& interval = fit.exponent_interval;
  std::string text = fmt::format("{:.2f}", fit.exponent);
  if (interval) text += fmt::format(" ({:.2f} to {:.2f})", interval->low, interval->high);
  if (replicates < 10) text += " †";
  const auto end = [&](double Interval::*side) { return interval ? TableCell((*interval).*side) : TableCell(); };
  return {{fit.exponent, text}, fit.exponent, end(&Interval::low), end(&Interval::high), metric, fit.from, fit.to};
}

Cells squared_bias(const FinalRow& row) {
  if (!row.split) return {};
  const auto& [bias_squared, variance, error, count] = *row.split;
  if (count <= 2) return {bias_squared, bias_squared};
  return {{bias_squared, format_figure(bias_squared) + " ± " + format_figure(error)}, bias_squared, error};
}

void add_theory(FinalTable& table) {
  table.group("Theory and measurement");
  table.column("declared_bias", "declared", [](const FinalRow& row) { return row.configuration->any_cell()->bias; });
  table.column("declared_mse_exponent", "exponent",
               [](const FinalRow& row) { return TableCell(row.configuration->any_cell()->mse_exponent, format_short); });
  table.parts("measured", {"measured_mse_exponent", "measured_low", "measured_high", "fit_metric", "fit_from", "fit_to"},
              fitted_exponent);
  table.parts("over iterations", {}, [](const FinalRow& row) -> Cells {
    if (!row.rate) return {};
    const RateFit& fit = row.rate->fit;
    return {TableCell::ordered(fmt::format("{:.0f}–{:.0f}", fit.from, fit.to), fit.from)};
  });
  table.parts("bias² of images", {"bias_squared", "bias_squared_standard_error"}, squared_bias);
  table.column("image_variance", "variance",
               [](const FinalRow& row) { return row.split ? std::optional(row.split->variance) : std::nullopt; });
}

// Adds what the experiment's own labels stand for.
void add_labels(FinalTable& table, const ReportData& data) {
  const auto& labels = data.log->stated.labels;
  const auto meaning = [](const auto& label) { return label.second + " is " + label.first; };
  if (!labels.empty()) table.note(joined(labels, "; ", meaning) + ".");
}

void add_final_notes(FinalTable& table, const ReportData& data) {
  table.note(
      "The time at which methods are compared is the latest that every seed of every configuration of the scene reached; each "
      "seed has the image of its last whole iteration then, whose error is interpolated over iterations between checkpoints. "
      "The figure is the geometric mean over seeds, in brackets its 95 % Student interval (from three seeds on; of two the "
      "extremes).");
  table.note(
      "The target is the error that at least half of the configurations reach by that time, rounded up to 1, 2 or 5; the time "
      "to it is the median over seeds of the first crossing, beside it the time by which 95 % of the seeds had arrived (of "
      "fewer than twenty, all). \"> t\" has not arrived by t, \"≤ t\" was there at the first checkpoint.");
  table.note(
      "p against the first: Mann and Whitney's test by ranks of the seeds' errors then and those of the scene's first row, "
      "two-sided. ‡ fewer than nine seeds of either: the least that p can be is 0.33 for two, 0.1 for three, 0.029 for four of "
      "each, which several comparisons at a time use up.");
  table.note(
      "Costs and metrics are medians over seeds at the last checkpoint, in brackets the 5th and 95th percentile. The peak of "
      "memory is that of the process, with all scenes of the run.");
  table.note(
      "The measured exponent is the slope of the mean squared error over iterations (the reference's variance subtracted), "
      "over the later half of the ladder in logarithms, of weighted least squares; the interval is a 95 % percentile bootstrap "
      "over seeds. There is none where the mean over seeds is not above that variance. † fewer than ten seeds.");
  if (std::ranges::any_of(data.log->checkpoints, [](const CheckpointRecord& r) { return !r.confidence.empty(); }))
    table.note(
        "Methods that state their own error compute it on the clock: their times hold its cost, which other methods do not "
        "pay.");
  if (!data.log->products.empty())
    table.note(
        "bias² of images is the mean of (average over seeds − reference)² less variance/seeds less the reference's variance, ± "
        "its jackknife standard error; a negative value is below what these seeds can show.");
}

// --- phases and counters ---

using ConfigurationTable = TableOf<const Configuration*>;

const Configuration& itself(const Configuration* configuration) { return *configuration; }

// Takes the median over seeds at the last checkpoint.
template <class Value>
double last_median(const Configuration* configuration, const Value& value) {
  return median(last_values(*configuration, value));
}

double count_of(const CheckpointRecord& record, const std::string& counter) {
  return static_cast<double>(find_value(record.counters, counter).value_or(0));
}

}  // namespace

Table final_table(const ReportData& data) {
  FinalTable table("final", "Results", final_rows(data));
  add_names(table, data, [](const FinalRow& row) -> const Configuration& { return *row.configuration; });
  add_equal_time(table, data);
  add_cost(table);
  add_metrics(table, data);
  add_theory(table);
  add_labels(table, data);
  if (!data.empty()) add_final_notes(table, data);
  return table.take();
}

Table phases_table(const ReportData& data) {
  ConfigurationTable table("phases", "Where the time went", data.finished());
  add_names(table, data, itself);
  const auto total = [](const Configuration* c) { return last_median(c, &CheckpointRecord::time_s); };
  table.column("time_s", "time", [&](const Configuration* c) { return TableCell(total(c), format_seconds); });
  for (const std::string& phase : data.phases)
    table.column(phase + "_s", phase, [&](const Configuration* c) {
      const double time = last_median(c, [&](const CheckpointRecord& r) { return find_value(r.phases_s, phase).value_or(0); });
      if (time == 0) return TableCell(time, "–");
      const double share = total(c) > 0 ? 100 * time / total(c) : 0;
      const std::string percent = share < 0.05 ? "< 0.1" : fmt::format("{:.{}f}", share, share < 0.95 ? 1 : 0);
      return TableCell(time, fmt::format("{} ({} %)", format_seconds(time), percent));
    });
  table.note("Medians over seeds of wall time up to the last checkpoint, in brackets the share of the whole.");
  return table.take();
}

Table counters_table(const ReportData& data) {
  ConfigurationTable table("counters", "Work per iteration", data.finished());
  add_names(table, data, itself);
  const auto add = [&](const std::string& key, const std::string& title, bool shown, const auto& value) {
    table.column(
        key, title,
        [&](const Configuration* c) {
          const double count = last_median(c, value);
          return TableCell(count, count == 0 ? "–" : format_count(count));
        },
        shown ? Audience::everyone : Audience::machines);
  };
  for (const std::string& counter : data.counters) {
    const auto& records = data.log->checkpoints;
    const bool used = std::ranges::any_of(records, [&](const auto& r) { return count_of(r, counter) > 0; });
    std::string title = counter;
    std::ranges::replace(title, '_', ' ');
    add(counter + "_per_iteration", title, used, [&](const CheckpointRecord& r) {
      return count_of(r, counter) / static_cast<double>(std::max<std::uint64_t>(1, r.iterations));
    });
  }
  add("rays_per_s", "rays per second", true, [](const CheckpointRecord& r) {
    return r.time_s > 0 ? (count_of(r, "rays") + count_of(r, "shadow_rays")) / r.time_s : 0.0;
  });
  table.note(
      "Medians over seeds at the last checkpoint, of the whole work over all iterations and the whole time: preparation is "
      "included.");
  return table.take();
}

}  // namespace etendue
