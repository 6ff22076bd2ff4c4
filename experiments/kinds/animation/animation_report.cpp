#include "experiments/kinds/animation/animation.h"

#include "experiments/report/report_text.h"
#include "experiments/report/table_of.h"
#include "experiments/report/verdicts.h"
#include "experiments/statistics/statistics.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

namespace etendue {
namespace {

// Holds one (scene, motion, builder) under all of its seeds.
struct AnimationData {
  std::string scene, motion, builder;
  std::string name = {};       // "builtin:mesh · twist turns=2", with the builder where the log has several
  std::string file_stem = {};  // unique
  std::vector<const AnimationRecord*> seeds = {};  // done
  std::size_t frames = 0;                          // that all of them have, the rest position included

  std::size_t policy_count() const { return seeds.front()->policies.size(); }
  const std::string& policy(std::size_t index) const { return seeds.front()->policies[index].policy; }
};

using FrameFigure = double (*)(const AnimationRecord&, const PolicyRecord&, std::size_t frame);

double frame_s(const AnimationRecord&, const PolicyRecord& p, std::size_t f) { return p.update_s[f] + p.trace_s[f]; }
double update_s(const AnimationRecord&, const PolicyRecord& p, std::size_t f) { return p.update_s[f]; }
double rebuilt(const AnimationRecord&, const PolicyRecord& p, std::size_t f) { return p.rebuilt[f]; }
double relative_cost(const AnimationRecord& r, const PolicyRecord& p, std::size_t f) {
  return r.rebuilt_sah_cost[f] > 0 ? p.sah_cost[f] / r.rebuilt_sah_cost[f] : 1;
}
double mrays_per_s(const AnimationRecord& r, const PolicyRecord& p, std::size_t f) {
  return p.trace_s[f] > 0 ? 1e-6 * r.rays[f] / p.trace_s[f] : 0;
}
// The time over that of the policy that rebuilds, for the same rays, is 0 where no policy does.
double trace_ratio(const AnimationRecord& r, const PolicyRecord& p, std::size_t f) {
  for (const PolicyRecord& other : r.policies)
    if (other.policy == "rebuild" && other.trace_s[f] > 0) return p.trace_s[f] / other.trace_s[f];
  return 0;
}

// Gives a figure of one policy at a frame, for each seed.
std::vector<double> over_seeds(const AnimationData& animation, std::size_t policy, std::size_t frame, FrameFigure figure) {
  return mapped(animation.seeds, [&](const AnimationRecord* of) { return figure(*of, of->policies[policy], frame); });
}

// Averages it over seeds and over the frames from `begin` on.
double mean_over(const AnimationData& animation, std::size_t policy, std::size_t begin, FrameFigure figure) {
  std::vector<double> values;
  for (std::size_t f = begin; f < animation.frames; ++f) values.push_back(mean(over_seeds(animation, policy, f, figure)));
  return mean(values);
}

double largest(const AnimationData& animation, std::size_t policy, FrameFigure figure) {
  double most = 0;
  for (std::size_t f = 1; f < animation.frames; ++f)
    for (const double value : over_seeds(animation, policy, f, figure)) most = std::max(most, value);
  return most;
}

// The last tenth of the frames: what it has come to, free of one frame's noise.
std::size_t last_frames(const AnimationData& animation) {
  return animation.frames - std::max<std::size_t>(1, animation.frames / 10);
}

bool same_policies(const AnimationRecord& a, const AnimationRecord& b) {
  return std::equal(a.policies.begin(), a.policies.end(), b.policies.begin(), b.policies.end(),
                    [](const PolicyRecord& x, const PolicyRecord& y) { return x.policy == y.policy; });
}

Figure policy_figure(const AnimationData& animation, const char* stem, const char* title, const char* axis, FrameFigure figure,
                     double unit) {
  Chart chart{.x = {"frame", Scale::linear}};
  double low = infinity, high = 0;
  for (std::size_t p = 0; p < animation.policy_count(); ++p) {
    ChartSeries series{.key = animation.policy(p), .label = animation.policy(p)};
    series.style(p);
    for (std::size_t f = 1; f < animation.frames; ++f) {
      const std::vector<double> values = over_seeds(animation, p, f, figure);
      const auto [least, most] = std::ranges::minmax_element(values);
      series.points.emplace_back(static_cast<double>(f), unit * mean(values), unit * *least, unit * *most);
      low = std::min(low, series.points.back().y);
      high = std::max(high, series.points.back().y);
    }
    chart.series.push_back(std::move(series));
  }
  chart.y = {axis, low > 0 && high > 4 * low ? Scale::log : Scale::linear};
  Figure result{fmt::format("{}-{}", stem, animation.file_stem), animation.name, title, {std::move(chart)}};
  if (animation.seeds.size() > 1)
    result.notes.push_back(fmt::format("Lines: mean over {} seeds; bands: both extremes.", animation.seeds.size()));
  return result;
}

std::string times(double ratio) { return fmt::format("{:.{}f}×", ratio, ratio < 10 ? 2 : 0); }

// Those that finished, in order of first appearance; keeps pointers into `log`.
std::vector<AnimationData> arrange_animations(const RunLog& log) {
  std::vector<AnimationData> animations;
  std::set<std::string> builders;
  for (const AnimationRecord* logged : done_records_of<AnimationRecord>(log)) {
    const AnimationRecord& record = *logged;
    if (record.policies.empty()) continue;
    builders.insert(record.cell.accel);
    const auto same = [&](const AnimationData& a) {
      return a.scene == record.cell.scene && a.motion == record.cell.integrator && a.builder == record.cell.accel &&
             same_policies(*a.seeds.front(), record);
    };
    AnimationData& found = find_or_add(animations, same,
                                       {.scene = record.cell.scene,
                                        .motion = record.cell.integrator,
                                        .builder = record.cell.accel,
                                        .frames = record.changed.size()});
    found.frames = std::min(found.frames, record.changed.size());
    found.seeds.push_back(&record);
  }
  std::erase_if(animations, [](const AnimationData& a) { return a.frames < 2; });
  std::map<std::string, int> used;
  for (AnimationData& animation : animations) {
    animation.name = animation.scene + " · " + animation.motion;
    if (builders.size() > 1) animation.name += " · " + animation.builder;
    animation.file_stem = slug(animation.scene) + "-" + slug(animation.motion);
    if (builders.size() > 1) animation.file_stem += "-" + slug(animation.builder);
    if (const int count = ++used[animation.file_stem]; count > 1) animation.file_stem += fmt::format("-{}", count);
  }
  return animations;
}

Table animations_table(const RunLog& log) {
  struct Row {
    const AnimationData* animation;
    std::size_t policy;

    double mean_of(FrameFigure figure, std::size_t begin = 1) const { return mean_over(*animation, policy, begin, figure); }
    double last_mean_of(FrameFigure figure) const { return mean_of(figure, last_frames(*animation)); }
  };
  const std::vector<AnimationData> animations = arrange_animations(log);
  std::vector<Row> rows;
  for (const AnimationData& animation : animations)
    for (std::size_t p = 0; p < animation.policy_count(); ++p) rows.push_back({&animation, p});
  const auto time = [](double s) { return TableCell(s, format_seconds); };
  const auto ratio = [](double x) { return TableCell::positive(x, times); };
  TableOf<Row> table("animations", "Change over time", rows);
  table.column("scene", "scene", [](const Row& row) { return row.animation->scene; });
  table.column("motion", "motion", [](const Row& row) { return row.animation->motion; });
  table.column("builder", "builder", [](const Row& row) { return row.animation->builder; });
  table.column("policy", "policy", [](const Row& row) { return row.animation->policy(row.policy); });
  table.group("Time");
  table.column("frame_s", "frame", [&](const Row& row) { return time(row.mean_of(frame_s)); });
  table.column("update_s", "update", [&](const Row& row) { return time(row.mean_of(update_s)); });
  table.column("worst_update_s", "worst update",
               [&](const Row& row) { return time(largest(*row.animation, row.policy, update_s)); });
  table.column("rebuilt", "rebuilt", [](const Row& row) {
    const double share = row.mean_of(rebuilt);
    return TableCell(share, fmt::format("{:.1f} %", 100 * share));
  });
  table.group("Quality");
  table.column("mrays_per_s", "Mrays/s", [](const Row& row) { return row.mean_of(mrays_per_s); });
  table.column("relative_cost", "SAH cost", [&](const Row& row) { return ratio(row.mean_of(relative_cost)); });
  table.column("last_relative_cost", "at last", [&](const Row& row) { return ratio(row.last_mean_of(relative_cost)); });
  table.column("last_relative_trace", "tracing at last", [&](const Row& row) { return ratio(row.last_mean_of(trace_ratio)); });
  table.column("disagreements", "disagreements", [](const Row& row) {
    std::uint64_t disagreements = 0;
    for (const AnimationRecord* record : row.animation->seeds) disagreements += record->policies[row.policy].disagreements;
    return disagreements;
  });
  table.note(
      "Means over frames and seeds. A frame: bringing the tree up to date, and tracing. Rebuilt: what went to the builder, as "
      "a share of the primitives. SAH cost: relative to a tree built anew. At last: over the last tenth of the frames; tracing "
      "relative to the policy that rebuilds. Disagreements: hits that differ from those of a tree built anew.");
  return table.take(failed_cells<AnimationRecord>(log));
}

std::vector<Figure> animation_figures(const AnimationData& animation) {
  return {policy_figure(animation, "frame-time", "time per frame", "update and tracing [ms]", frame_s, 1e3),
          policy_figure(animation, "update-time", "of which the update", "update [ms]", update_s, 1e3),
          policy_figure(animation, "tree-quality", "tree quality", "SAH cost, relative to a tree built anew", relative_cost, 1),
          policy_figure(animation, "trace-speed", "speed of tracing", "Mrays/s", mrays_per_s, 1)};
}

// Policies by their mean time a frame, the least first.
std::vector<std::pair<double, std::size_t>> by_time(const AnimationData& animation) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t p = 0; p < animation.policy_count(); ++p) order.emplace_back(mean_over(animation, p, 1, frame_s), p);
  std::ranges::sort(order);
  return order;
}

std::string least_time(const AnimationData& animation) {
  const auto order = by_time(animation);
  std::string text =
      fmt::format("{} takes the least time: {} a frame", animation.policy(order[0].second), format_seconds(order[0].first));
  for (std::size_t i = 1; i < order.size(); ++i)
    text += fmt::format("{} {} takes {}", i == 1 ? ";" : ",", animation.policy(order[i].second),
                        times(order[i].first / order[0].first));
  return text;
}

std::string animations_answer(const std::vector<AnimationData>& animations) {
  if (animations.size() == 1) return least_time(animations.front());
  constexpr double worth = 1.05;  // frames follow each other, so that they tell nothing of noise
  std::vector<Lead> leads;
  std::size_t clear = 0;
  for (const AnimationData& animation : animations) {
    const auto order = by_time(animation);
    leads.push_back({animation.policy(order.front().second), animation.name});
    clear += order.size() > 1 && order[1].first >= worth * order[0].first;
  }
  if (leads.empty()) return {};
  return fmt::format("{}; by 5 % or more on {} of {}", who_leads(leads, "takes the least time a frame", "animations"), clear,
                     leads.size());
}

// Which policy takes the least time, and what refitting costs in the end.
std::string animation_finding(const AnimationData& animation) {
  std::string text = least_time(animation);
  for (std::size_t p = 0; p < animation.policy_count(); ++p) {
    if (animation.policy(p) != "refit") continue;
    text += fmt::format(". After {} frames the refitted tree costs {} one built anew", animation.frames - 1,
                        times(mean_over(animation, p, last_frames(animation), relative_cost)));
    if (const double ratio = mean_over(animation, p, last_frames(animation), trace_ratio); ratio > 0)
      text += fmt::format(", and tracing takes {} the time", times(ratio));
  }
  return text + ".";
}

}  // namespace

std::string animation_summary(const RunLog& log) {
  Table table = animations_table(log);
  std::string out = table.rows.empty() ? "" : to_terminal(table, 1) + "\n" + to_terminal(table, 2) + "\n";
  for (const AnimationData& animation : arrange_animations(log))
    out += fmt::format("{}: {}\n", animation.name, animation_finding(animation));
  for (const std::string& note : table.notes)
    if (note.starts_with("Failed")) out += note + "\n";
  return out;
}

KindReport animation_report(const RunLog& log) {
  if (records_of<AnimationRecord>(log).empty()) return {};
  const std::vector<AnimationData> animations = arrange_animations(log);
  KindReport report{.tables = {animations_table(log)},
                    .answer = animations_answer(animations),
                    .id = "animations",
                    .heading = "Change over time"};
  if (!animations.empty()) report.fact = counted(animations.size(), "animation");
  for (const AnimationData& animation : animations) {
    report.findings.emplace_back(animation.name, animation_finding(animation));
    report.figures.push_back({animation.name, animation_figures(animation)});
  }
  return report;
}

}  // namespace etendue
