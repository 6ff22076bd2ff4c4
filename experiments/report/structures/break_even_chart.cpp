#include "experiments/report/structures/structure_figures.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace etendue {
namespace {

constexpr double most_rays = 1e9;
constexpr int points_per_decade = 6;

double build_s(const StructureRecord& r) { return r.build_s.median; }
double ray_s(const StructureRecord& r) { return 1e-9 * ray_cost(r); }
bool is_measured(const StructureRecord& r) { return build_s(r) > 0 && ray_s(r) > 0; }
double total_s(const StructureRecord& r, double rays) { return build_s(r) + ray_s(r) * rays; }

// Writes a number of rays for people: "12 M".
std::string rays_text(double rays) {
  const double digit = std::pow(10.0, std::max(0.0, std::floor(std::log10(rays)) - 1));
  return format_count(std::ceil(rays / digit) * digit);
}

// The straight line, which is curved on logarithmic axes, between two numbers of rays.
std::vector<ChartPoint> cost_line(const StructureRecord& record, double from, double to) {
  std::vector<double> rays{from};
  for (int i = 0; std::pow(10.0, static_cast<double>(i) / points_per_decade) < to; ++i)
    if (const double x = std::pow(10.0, static_cast<double>(i) / points_per_decade); x > from) rays.push_back(x);
  rays.push_back(to);
  return mapped(rays, [&](double x) { return ChartPoint(x, total_s(record, x)); });
}

}  // namespace

std::vector<Choice> cheapest_choices(const std::vector<const StructureRecord*>& records) {
  std::vector<const StructureRecord*> left;
  for (const StructureRecord* r : records)
    if (is_measured(*r)) left.push_back(r);
  if (left.empty()) return {};
  const auto first = std::ranges::min_element(
      left, [](const auto* a, const auto* b) { return std::pair(build_s(*a), ray_s(*a)) < std::pair(build_s(*b), ray_s(*b)); });
  std::vector<Choice> choices{{*first, 0}};
  for (;;) {  // the next is the line of less slope that meets this one first
    const StructureRecord* now = choices.back().record;
    Choice next{nullptr, infinity};
    for (const StructureRecord* r : left) {
      if (ray_s(*r) >= ray_s(*now)) continue;
      const double meets = std::max((build_s(*r) - build_s(*now)) / (ray_s(*now) - ray_s(*r)), choices.back().from_rays);
      if (meets < next.from_rays || (next.record && meets == next.from_rays && ray_s(*r) < ray_s(*next.record)))
        next = {r, meets};
    }
    if (!next.record) return choices;
    choices.push_back(next);
  }
}

Figure break_even_figure(const ReportData& data, const SceneData& scene) {
  std::vector<const StructureRecord*> records;
  for (const StructureRecord& record : data.log->structures)
    if (record.scene == scene.name && is_measured(record)) records.push_back(&record);
  if (records.size() < 2) return {};
  const std::vector<Choice> choices = cheapest_choices(records);
  Chart chart{.x = {"rays traced"}, .y = {"building and tracing, one thread [s]"}};
  const double highest = 30 * total_s(*choices.back().record, most_rays);  // brute force would stretch the axis
  for (const StructureRecord* record : records) {
    ChartSeries line{.draw = ChartSeries::Draw::context, .points = cost_line(*record, 1, most_rays)};
    std::erase_if(line.points, [&](const ChartPoint& p) { return p.y > highest; });
    chart.series.push_back(std::move(line));
  }
  std::string text = "To pick:";
  for (std::size_t i = 0; i < choices.size(); ++i) {
    const StructureRecord& record = *choices[i].record;
    const std::string since = choices[i].from_rays > 1 ? fmt::format(" from {} rays", rays_text(choices[i].from_rays)) : "";
    text += fmt::format("{} {}{}", i > 0 ? ";" : "", structure_name(record), since);
    const double from = std::clamp(choices[i].from_rays, 1.0, most_rays);
    const double to = i + 1 < choices.size() ? std::clamp(choices[i + 1].from_rays, 1.0, most_rays) : most_rays;
    if (!(to > from)) continue;
    ChartSeries series{
        .key = structure_name(record), .label = structure_name(record) + since, .points = cost_line(record, from, to)};
    style_structure(series, data, record);
    const ChartPoint middle = series.points[series.points.size() / 2];
    chart.labels.push_back({middle.x, middle.y, structure_name(record)});
    chart.series.push_back(std::move(series));
  }
  return {
      "break-even-" + scene.file_stem,
      scene.name,
      "the structure to pick for N rays",
      {std::move(chart)},
      {text + ".", "Built once, then as many diffuse rays traced. Grey: every structure; coloured: where nothing costs less."}};
}

}  // namespace etendue
