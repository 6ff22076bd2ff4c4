#include "experiments/kinds/animation/animation_report.h"

#include "experiments/report/report_text.h"
#include "experiments/statistics/statistics.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

namespace etendue {
namespace {

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
// As a policy's own time for the same rays; 0 where no policy rebuilds.
double trace_ratio(const AnimationRecord& r, const PolicyRecord& p, std::size_t f) {
  for (const PolicyRecord& other : r.policies)
    if (other.policy == "rebuild" && other.trace_s[f] > 0) return p.trace_s[f] / other.trace_s[f];
  return 0;
}

// A figure of one policy at a frame, for each seed.
std::vector<double> over_seeds(const AnimationData& animation, std::size_t policy, std::size_t frame, FrameFigure figure) {
  std::vector<double> values;
  for (const AnimationRecord* record : animation.seeds) values.push_back(figure(*record, record->policies[policy], frame));
  return values;
}

// Its mean over seeds and frames [begin, end).
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
  Chart chart;
  chart.x = {"frame", Scale::linear, std::nullopt};
  double low = infinity, high = 0;
  for (std::size_t p = 0; p < animation.policy_count(); ++p) {
    ChartSeries series;
    series.key = series.label = animation.seeds.front()->policies[p].policy;
    series.colour = p % chart_colours;
    series.marker = p % chart_markers;
    series.dash = p / chart_colours % chart_dashes;
    for (std::size_t f = 1; f < animation.frames; ++f) {
      std::vector<double> values = over_seeds(animation, p, f, figure);
      const auto [least, most] = std::minmax_element(values.begin(), values.end());
      series.points.push_back({static_cast<double>(f), unit * mean(values), unit * *least, unit * *most});
      low = std::min(low, series.points.back().y);
      high = std::max(high, series.points.back().y);
    }
    chart.series.push_back(std::move(series));
  }
  chart.y = {axis, low > 0 && high > 4 * low ? Scale::log : Scale::linear, std::nullopt};
  Figure result{fmt::format("{}-{}", stem, animation.file_stem), animation.name, title, {std::move(chart)}, {}};
  if (animation.seeds.size() > 1)
    result.notes.push_back(fmt::format("Lines: mean over {} seeds; bands: both extremes.", animation.seeds.size()));
  return result;
}

std::string times(double ratio) { return fmt::format("{:.{}f}×", ratio, ratio < 10 ? 2 : 0); }

}  // namespace

std::vector<AnimationData> arrange_animations(const RunLog& log) {
  std::vector<AnimationData> animations;
  std::set<std::string> builders;
  for (const AnimationRecord* logged : records_of<AnimationRecord>(log)) {
    const AnimationRecord& record = *logged;
    if (record.status != "done" || record.policies.empty()) continue;
    builders.insert(record.cell.accel);
    const auto same = [&](const AnimationData& a) {
      return a.scene == record.cell.scene && a.motion == record.cell.integrator && a.builder == record.cell.accel &&
             same_policies(*a.seeds.front(), record);
    };
    auto found = std::find_if(animations.begin(), animations.end(), same);
    if (found == animations.end()) {
      found =
          animations.insert(found, AnimationData{record.cell.scene, record.cell.integrator, record.cell.accel, {}, {}, {}, 0});
      found->frames = record.changed.size();
    }
    found->frames = std::min(found->frames, record.changed.size());
    found->seeds.push_back(&record);
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
  Table table{"animations", "Change over time", {}, {}, {"Time", "Quality"}, {}};
  table.columns = {{"scene", "scene", false},
                   {"motion", "motion", false},
                   {"builder", "builder", false},
                   {"policy", "policy", false},
                   {"frame_s", "frame", true, Audience::everyone, 1},
                   {"update_s", "update", true, Audience::everyone, 1},
                   {"worst_update_s", "worst update", true, Audience::everyone, 1},
                   {"rebuilt", "rebuilt", true, Audience::everyone, 1},
                   {"mrays_per_s", "Mrays/s", true, Audience::everyone, 2},
                   {"relative_cost", "SAH cost", true, Audience::everyone, 2},
                   {"last_relative_cost", "at last", true, Audience::everyone, 2},
                   {"last_relative_trace", "tracing at last", true, Audience::everyone, 2},
                   {"disagreements", "disagreements", true, Audience::everyone, 2}};
  const auto time = [](double s) { return TableCell::number(s, format_seconds(s)); };
  const auto ratio = [](double x) { return x > 0 ? TableCell::number(x, times(x)) : TableCell{}; };
  for (const AnimationData& a : arrange_animations(log))
    for (std::size_t p = 0; p < a.policy_count(); ++p) {
      const double share = mean_over(a, p, 1, rebuilt), speed = mean_over(a, p, 1, mrays_per_s);
      std::uint64_t disagreements = 0;
      for (const AnimationRecord* record : a.seeds) disagreements += record->policies[p].disagreements;
      table.rows.push_back({TableCell::words(a.scene), TableCell::words(a.motion), TableCell::words(a.builder),
                            TableCell::words(a.seeds.front()->policies[p].policy), time(mean_over(a, p, 1, frame_s)),
                            time(mean_over(a, p, 1, update_s)), time(largest(a, p, update_s)),
                            TableCell::number(share, fmt::format("{:.1f} %", 100 * share)),
                            TableCell::number(speed, format_figure(speed)), ratio(mean_over(a, p, 1, relative_cost)),
                            ratio(mean_over(a, p, last_frames(a), relative_cost)),
                            ratio(mean_over(a, p, last_frames(a), trace_ratio)), TableCell::count(disagreements)});
    }
  if (!table.rows.empty())
    table.notes.push_back(
        "Means over frames and seeds. A frame: bringing the tree up to date, and tracing. Rebuilt: what went to the builder, "
        "as a "
        "share of the primitives. SAH cost: relative to a tree built anew. At last: over the last tenth of the frames; tracing "
        "relative to the policy that rebuilds. Disagreements: hits that differ from those of a tree built anew.");
  for (std::string& line : failed_cells<AnimationRecord>(log)) table.notes.push_back(std::move(line));
  return table;
}

std::vector<Figure> animation_figures(const AnimationData& animation) {
  return {policy_figure(animation, "frame-time", "time per frame", "update and tracing [ms]", frame_s, 1e3),
          policy_figure(animation, "update-time", "of which the update", "update [ms]", update_s, 1e3),
          policy_figure(animation, "tree-quality", "tree quality", "SAH cost, relative to a tree built anew", relative_cost, 1),
          policy_figure(animation, "trace-speed", "speed of tracing", "Mrays/s", mrays_per_s, 1)};
}

std::string animation_finding(const AnimationData& animation) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t p = 0; p < animation.policy_count(); ++p) order.emplace_back(mean_over(animation, p, 1, frame_s), p);
  std::sort(order.begin(), order.end());
  const auto& policies = animation.seeds.front()->policies;
  std::string text =
      fmt::format("{} takes the least time: {} a frame", policies[order[0].second].policy, format_seconds(order[0].first));
  for (std::size_t i = 1; i < order.size(); ++i)
    text += fmt::format("{} {} takes {}", i == 1 ? ";" : ",", policies[order[i].second].policy,
                        times(order[i].first / order[0].first));
  for (std::size_t p = 0; p < policies.size(); ++p) {
    if (policies[p].policy != "refit") continue;
    text += fmt::format(". After {} frames the refitted tree costs {} one built anew", animation.frames - 1,
                        times(mean_over(animation, p, last_frames(animation), relative_cost)));
    if (const double ratio = mean_over(animation, p, last_frames(animation), trace_ratio); ratio > 0)
      text += fmt::format(", and tracing takes {} the time", times(ratio));
  }
  return text + ".";
}

std::string animation_summary(const RunLog& log) {
  Table table = animations_table(log);
  if (table.rows.empty() && table.notes.empty()) return "The log holds no finished cell.\n";
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
  KindReport report{.tables = {animations_table(log)}, .id = "animations", .heading = "Change over time"};
  if (!animations.empty())
    report.fact = fmt::format("{} {}", animations.size(), animations.size() == 1 ? "animation" : "animations");
  for (const AnimationData& animation : animations) {
    report.findings.emplace_back(animation.name, animation_finding(animation));
    report.figures.push_back({animation.name, animation_figures(animation)});
  }
  return report;
}

}  // namespace etendue
