#include "experiments/report/regret.h"

#include "experiments/config/method.h"
#include "experiments/report/report_text.h"
#include "experiments/report/table_of.h"
#include "framework/core/units.h"
#include "framework/core/vec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace etendue {
namespace {

constexpr int halvings = 6, steps_per_halving = 2;  // of the common time

std::string method_of(const Configuration& configuration) { return words_of(configuration.integrator).front(); }
bool is_default(const Configuration& configuration) { return words_of(configuration.integrator).size() == 1; }

// At a time: the defaults' error over the least of all settings, and which of them has that.
struct Shortfall {
  double time_s = 0, ratio = 1;
  const Configuration* best = nullptr;
};

struct MethodSettings {
  const SceneData* scene = nullptr;
  const Configuration* defaults = nullptr;
  std::vector<const Configuration*> settings = {};  // the defaults among them
  std::vector<Shortfall> shortfalls = {};           // from early to late; none before any setting has an image

  const Shortfall& worst() const { return *std::ranges::max_element(shortfalls, {}, &Shortfall::ratio); }
};

std::optional<Shortfall> shortfall_at(const MethodSettings& method, const std::string& metric, double time_s) {
  Shortfall shortfall{time_s};
  std::optional<double> own;
  double least = infinity;
  for (const Configuration* configuration : method.settings) {
    const auto error = error_at(*method.scene, *configuration, metric, time_s);
    if (!error) continue;
    if (configuration == method.defaults) own = *error;
    if (*error < least) {
      least = *error;
      shortfall.best = configuration;
    }
  }
  if (!shortfall.best) return std::nullopt;
  if (!own)
    shortfall.ratio = infinity;
  else if (*own > least)
    shortfall.ratio = least > 0 ? *own / least : infinity;
  return shortfall;
}

std::vector<MethodSettings> find_methods(const ReportData& data) {
  std::vector<MethodSettings> methods;
  for (const SceneData& scene : data.scenes)
    for (const Configuration* configuration : scene.finished()) {
      const auto same = [&](const MethodSettings& m) {
        return m.scene == &scene && method_of(*m.settings.front()) == method_of(*configuration) &&
               m.settings.front()->accel == configuration->accel;
      };
      MethodSettings& method = find_or_add(methods, same, {.scene = &scene});
      method.settings.push_back(configuration);
      if (is_default(*configuration)) method.defaults = configuration;
    }
  return methods;
}

void find_shortfalls(MethodSettings& method, const std::string& metric) {
  for (int step = halvings * steps_per_halving; step >= 0; --step) {
    const double time_s = method.scene->common_time_s * std::exp2(-static_cast<double>(step) / steps_per_halving);
    if (const auto shortfall = shortfall_at(method, metric, time_s)) method.shortfalls.push_back(*shortfall);
  }
}

Table settings_table(const ReportData& data, const std::vector<MethodSettings>& methods) {
  TableOf<MethodSettings> table("settings", "Error of defaults over the least of all settings", methods);
  table.column("scene", "scene", [](const MethodSettings& m) { return m.scene->name; });
  table.column("method", "method", [](const MethodSettings& m) { return method_of(*m.defaults); });
  table.column("settings", "settings", [](const MethodSettings& m) { return m.settings.size(); });
  table.column("worst", "at worst", [](const MethodSettings& m) { return times_cell(m.worst().ratio); });
  table.column("worst_time_s", "at", [](const MethodSettings& m) { return TableCell(m.worst().time_s, format_seconds); });
  table.column("best_there", "best there",
               [](const MethodSettings& m) { return NameCell(m.worst().best->shown_integrator, m.worst().best->integrator); });
  table.column("at_end", "at the end", [](const MethodSettings& m) { return times_cell(m.shortfalls.back().ratio); });
  table.note(fmt::format("Errors are compared at {} times, from a {}th of the time that all runs had on.",
                         halvings * steps_per_halving + 1, 1 << halvings));
  if (const std::string noise = noise_in_ratios(data); !noise.empty()) table.note(noise);
  return table.take();
}

// A panel a scene, a line a method.
Figure settings_figure(const std::vector<MethodSettings>& methods) {
  Figure figure{.name = "settings", .title = "Error of defaults over the least of all settings"};
  double most = 1.5;
  for (const MethodSettings& method : methods)
    for (const Shortfall& shortfall : method.shortfalls)
      if (std::isfinite(shortfall.ratio)) most = std::max(most, shortfall.ratio);
  const SceneData* scene = nullptr;
  std::vector<std::string> names;  // a method that lacks in one scene keeps its colour in others
  for (const MethodSettings& method : methods) {
    if (method.scene != scene) {
      scene = method.scene;
      figure.panels.push_back({.title = scene->file_stem,
                               .x = {"time [s]", Scale::log},
                               .y = {"error over the least", Scale::linear, Interval{0.9, 1.05 * most}}});
    }
    ChartSeries& line = figure.panels.back().series.emplace_back();
    line.key = line.label = method_of(*method.defaults);
    for (const Shortfall& shortfall : method.shortfalls)
      if (std::isfinite(shortfall.ratio)) line.points.emplace_back(shortfall.time_s, shortfall.ratio);
    line.style(index_in(names, line.label));
  }
  figure.notes = {"No mark: the defaults have no image yet."};
  return figure;
}

}  // namespace

KindReport settings_report(const ReportData& data) {
  if (data.empty() || data.is_signed(data.main_metric())) return {};
  std::vector<MethodSettings> methods = find_methods(data);
  const auto judged = [](const MethodSettings& m) { return m.defaults != nullptr && m.settings.size() > 1; };
  if (methods.empty() || !std::ranges::all_of(methods, judged)) return {};
  for (MethodSettings& method : methods) find_shortfalls(method, data.main_metric());
  std::erase_if(methods, [](const MethodSettings& m) { return m.shortfalls.empty(); });
  if (methods.empty()) return {};
  const auto worst = mapped(methods, [](const MethodSettings& method) { return method.worst().ratio; });
  const MethodSettings& most = methods[static_cast<std::size_t>(std::ranges::max_element(worst) - worst.begin())];
  KindReport report{.id = "settings", .heading = "Defaults against other settings"};
  report.answer = fmt::format(
      "at the times where they lose most, defaults err {:.2f} times as much as the best of their settings at the median, {} at "
      "worst ({} on {} at {}: {}).",
      median(worst), std::isfinite(most.worst().ratio) ? fmt::format("{:.2f} times", most.worst().ratio) : "without limit",
      method_of(*most.defaults), most.scene->name, format_seconds(most.worst().time_s), most.worst().best->shown_integrator);
  report.section = fmt::format("<p>{}</p>\n", escape_html(report.answer));
  report.tables = {settings_table(data, methods)};
  report.figures = {{"Over time", {settings_figure(methods)}}};
  return report;
}

}  // namespace etendue
