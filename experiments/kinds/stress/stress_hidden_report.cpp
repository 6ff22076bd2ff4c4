// A table of what a mean hides, by method and hazard: the tail of an image's pixels, how often an interval that seeds or the
// method itself state does not hold the right value, and when the first image comes that is not nonsense.
#include "experiments/kinds/stress/stress_report.h"
#include "experiments/report/report_text.h"
#include "experiments/report/table_of.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace etendue {

namespace {

// A mean that is right may be off by so much, for single precision and the bound on a path's length.
constexpr double indifference = 5e-4;

// A share has what was seen of it, and where it may lie.
struct Share {
  std::size_t count = 0, of = 0;  // of > 0
  double seen() const { return static_cast<double>(count) / static_cast<double>(of); }
  Interval interval() const { return share_interval(count, of); }
  std::string text() const {
    const auto [low, high] = interval();
    return fmt::format("{} of {} ({:.0f}–{:.0f} %)", count, of, 100 * low, 100 * high);
  }
};

const StressPoint& harmful_end(const StressCell& cell) { return cell.record->points.back(); }

// At how many points of the curve the reference's mean lies outside the 95 % Student interval of the seeds' means.
Share missed(const StressCell& cell) {
  Share share;
  for (const StressPoint& point : cell.record->points) {
    if (point.values.size() < 2) continue;
    ++share.of;
    const double half = student_t_quantile(0.975, static_cast<double>(point.values.size() - 1)) * point.bias_error;
    share.count += std::abs(point.bias) > half + indifference;
  }
  return share;
}

std::vector<TableCell> tail_cells(const StressCell& cell) {
  const std::vector<double>& tails = harmful_end(cell).tails;
  if (tails.empty()) return {};
  const Estimate estimate = signed_estimate(tails);
  const double low = std::max(0.0, estimate.interval.low), high = std::min(lightest_tail, estimate.interval.high);
  std::string text = format_figure(estimate.centre, 2);
  if (estimate.spread != Spread::none) text += fmt::format(" ({}–{})", format_figure(low, 2), format_figure(high, 2));
  return {{estimate.centre, text}, estimate.centre, low, high};
}

std::vector<TableCell> missed_cells(const StressCell& cell) {
  const Share share = missed(cell);
  if (share.of == 0) return {};
  const auto [low, high] = share.interval();
  return {{share.seen(), share.text()}, share.count, share.of, share.seen(), low, high};
}

std::vector<TableCell> sane_cells(const std::vector<double>& values, std::string (*format)(double)) {
  if (values.empty()) return {};
  const ArrivalMedian found = median_arrival(mapped(values, [](double v) {
    return Arrival{v < 0 ? Arrival::Kind::never : Arrival::Kind::at, std::abs(v)};
  }));
  const bool never = found.median.kind == Arrival::Kind::never;
  std::string text = (never ? "> " : "") + format(found.median.time);
  if (found.arrived > 0 && found.arrived < found.count) text += fmt::format(" ({} of {})", found.arrived, found.count);
  TableCell shown(found.median.time, text);
  if (never) shown.order = 1e12 + found.median.time;
  return {shown, found.median.time, never ? "right" : "none", found.arrived};
}

std::vector<StressCell> measured_cells(const StressMap& map) {
  std::vector<StressCell> cells;
  for (const StressRow& row : map.rows)
    for (const StressCell& cell : row.cells)
      if (cell.threshold && !cell.record->of_structure) cells.push_back(cell);
  return cells;
}

// Lists methods by their share over all points, the most first: "sppm 46 % (27–67)".
std::string shares_missed(const std::vector<StressCell>& cells) {
  std::vector<std::pair<std::string, Share>> by_method;
  for (const StressCell& cell : cells) {
    const Share share = missed(cell);
    if (share.of == 0) continue;
    const auto same = [&](const auto& entry) { return entry.first == cell.record->column; };
    Share& sum = find_or_add(by_method, same, std::pair{cell.record->column, Share{}}).second;
    sum.count += share.count;
    sum.of += share.of;
  }
  std::ranges::stable_sort(by_method, std::greater<>(), [](const auto& entry) { return entry.second.seen(); });
  return joined(by_method, ", ", [](const auto& entry) {
    const auto& [method, share] = entry;
    return fmt::format("{} {:.0f} % ({:.0f}–{:.0f})", method, 100 * share.seen(), 100 * share.interval().low,
                       100 * share.interval().high);
  });
}

}  // namespace

Table hidden_table(const StressMap& map) {
  TableOf<StressCell> table("hidden", "What a mean hides", measured_cells(map));
  table.column("id", "#", [](const StressCell& c) { return c.record->id; });
  table.column("hazard", "hazard", [](const StressCell& c) { return c.record->hazard; });
  table.column("method", "method", [](const StressCell& c) { return c.record->column; });
  table.parts("tail index", {"tail_index", "tail_low", "tail_high"}, tail_cells);
  table.column("peak", "brightest pixel", [](const StressCell& c) { return harmful_end(c).peak; });
  table.parts("mean outside its interval", {"missed", "missed_of", "missed_share", "missed_share_low", "missed_share_high"},
              missed_cells);
  table.column("beyond_stated", "pixels beyond 2σ stated", [](const StressCell& c) {
    const auto& share = harmful_end(c).beyond_stated;
    return share ? TableCell(*share, fmt::format("{:.0f} %", 100 * *share)) : TableCell();
  });
  table.parts("first sane image after", {"sane_s", "sane_s_censoring", "sane_s_arrived"},
              [](const StressCell& c) { return sane_cells(harmful_end(c).sane_s, format_seconds); });
  table.parts("samples", {"sane_iterations", "sane_iterations_censoring", "sane_iterations_arrived"},
              [](const StressCell& c) { return sane_cells(harmful_end(c).sane_iterations, format_short); });
  table.note(
      "All but 'mean outside its interval' are measured at the harmful end. Tail index: Hill's, of the twentieth of the pixels "
      "that are brightest beside the other seeds', over the reference's; mean over seeds with its 95 % Student interval. Below "
      "2 the variance is infinite and a standard error says nothing; 0: fewer than one pixel in twenty has a thousandth of its "
      "light. Brightest pixel: of any seed, over the reference's brightest.");
  table.note(fmt::format(
      "Mean outside its interval: at how many points of the curve the reference's mean lies outside the 95 % Student interval "
      "of the seeds' image means, beyond {:g} of it; in brackets the 95 % interval of Clopper and Pearson. Of an unbiased "
      "method whose seeds tell its noise it would be 1 in 20, and a little more by the noise of the reference. σ is stated by "
      "caches alone; a normal error leaves 5 % of the pixels beyond 2σ.",
      indifference));
  table.note(
      fmt::format("First sane image: the first checkpoint with relMSE below {:g}, the median over seeds; \"> t\": half of "
                  "the seeds had none by their last, t. In brackets how many had one. Caches compute σ on the clock, which "
                  "other methods do not pay.",
                  sane_relmse));
  return table.take();
}

void add_hidden(const StressMap& map, KindReport& report) {
  const std::vector<StressCell> cells = measured_cells(map);
  const auto count = [&](const auto& is) { return static_cast<std::size_t>(std::ranges::count_if(cells, is)); };
  if (count([](const StressCell& c) { return !harmful_end(c).sane_s.empty(); }) == 0) return;
  report.tables.push_back(hidden_table(map));
  const std::size_t never = count([](const StressCell& c) {
    const std::vector<double>& times = harmful_end(c).sane_s;
    return !times.empty() && std::ranges::all_of(times, [](double s) { return s < 0; });
  });
  std::string text =
      fmt::format("At the harmful end {} of {} never came to a sane image", never, counted(cells.size(), "cell"));
  if (count([](const StressCell& c) { return !harmful_end(c).tails.empty(); }) > 0)
    text +=
        fmt::format(", and the tail index is below 2 in {}, whose standard error says nothing",
                    count([](const StressCell& c) { return !harmful_end(c).tails.empty() && mean(harmful_end(c).tails) < 2; }));
  text += ".";
  if (const std::string shares = shares_missed(cells); !shares.empty())
    text += fmt::format(
        " Over all points the 95 % interval of the seeds' means misses the reference's by {} (in brackets 95 % intervals); 5 % "
        "would be due.",
        shares);
  report.findings.emplace_back("What a mean hides", text);
}

}  // namespace etendue
