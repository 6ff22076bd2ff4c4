#include "experiments/report/regret.h"

#include "experiments/config/method.h"
#include "experiments/report/report_text.h"
#include "experiments/report/table_of.h"
#include "framework/core/units.h"
#include "framework/core/vec.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace etendue {
namespace {

constexpr std::string_view chooser = "auto";
constexpr double time_shares[] = {1.0 / 64, 1.0 / 16, 1.0 / 4, 1};
constexpr double least_error = 1e-8;  // images that are off by 1e-4 are level: rays' offsets alone can cost as much

bool chooses(const Configuration& configuration) { return words_of(configuration.integrator).front() == chooser; }

// One that was told to choose for another time than that of the experiment is judged there alone.
bool chooses_for(const Configuration& configuration, double time_s, double whole_s) {
  if (!chooses(configuration)) return false;
  constexpr double close = 1.05;
  double wanted = whole_s;
  for (const std::string& word : words_of(configuration.integrator))
    if (word.starts_with("seconds=")) wanted = std::stod(word.substr(word.find('=') + 1));
  return wanted < close * time_s && time_s < close * wanted;
}

std::string key_of(const Configuration& configuration) {
  return chooses(configuration) ? std::string(chooser) : configuration.integrator + " " + configuration.accel;
}

// Names what the seeds chose, each once.
std::string choices_of(const Configuration& configuration) {
  std::vector<std::string> choices;
  for (const Replicate& replicate : configuration.replicates) index_in(choices, replicate.cell->chosen);
  return joined(choices, "; ");
}

// Methods compete on a scene, at a time, on one structure: rays that take longer on another are no fault of a choice of method.
struct Contest {
  const SceneData* scene;
  std::string accel;
  double share, time_s;
  std::map<const Configuration*, double> errors = {};  // of those that have an image by then
  const Configuration* best = nullptr;                 // among those that stand for themselves
  const Configuration* chosen = nullptr;               // that chose for this time

  std::optional<double> regret(const Configuration& configuration) const {
    const auto found = errors.find(&configuration);
    if (found == errors.end() || best == nullptr) return std::nullopt;
    return std::max(found->second, least_error) / std::max(errors.at(best), least_error);
  }
};

std::vector<std::string> structures_of(const SceneData& scene) {
  std::vector<std::string> names;
  for (const Configuration& configuration : scene.configurations) index_in(names, configuration.accel);
  return names;
}

std::vector<Contest> find_contests(const ReportData& data) {
  std::vector<Contest> contests;
  const auto add = [&](const SceneData& scene, const std::string& accel) {
    for (const double share : time_shares) {
      Contest contest{&scene, accel, share, share * scene.common_time_s};
      for (const Configuration& configuration : scene.configurations) {  // those that failed have no image
        if (configuration.accel != accel) continue;
        const auto error = error_at(scene, configuration, data.main_metric(), contest.time_s);
        const bool choice = chooses_for(configuration, contest.time_s, scene.common_time_s);
        if (choice) contest.chosen = &configuration;
        if (!error || (chooses(configuration) && !choice)) continue;
        contest.errors[&configuration] = *error;
        if (!choice && (!contest.best || *error < contest.errors.at(contest.best))) contest.best = &configuration;
      }
      if (contest.chosen && contest.best) contests.push_back(std::move(contest));
    }
  };
  for (const SceneData& scene : data.scenes)
    for (const std::string& accel : structures_of(scene)) add(scene, accel);
  return contests;
}

bool on_several_structures(const std::vector<Contest>& contests) {
  return std::ranges::any_of(contests, [&](const Contest& c) { return c.accel != contests[0].accel; });
}

// Holds what one method loses over all contests; one without an image by then counts as an infinite regret.
struct Loss {
  std::string name, shown;
  bool chooses = false;
  std::size_t missing = 0;
  std::vector<double> regrets = {};

  double worst() const { return missing > 0 ? infinity : *std::ranges::max_element(regrets); }
  double middle() const {
    std::vector<double> all = regrets;
    all.resize(regrets.size() + missing, infinity);
    return median(all);
  }
};

std::vector<Loss> find_losses(const ReportData& data, const std::vector<Contest>& contests) {
  std::vector<Loss> losses;
  for (const Contest& contest : contests)
    for (const Configuration& configuration : contest.scene->configurations) {
      const bool choice = &configuration == contest.chosen;
      if (configuration.accel != contest.accel || (chooses(configuration) && !choice)) continue;
      const std::string name = key_of(configuration);
      Loss& loss = find_or_add(losses, [&](const Loss& l) { return l.name == name; },
                               {name, choice ? name : label(data, configuration), choice});
      if (const auto regret = contest.regret(configuration))
        loss.regrets.push_back(*regret);
      else
        ++loss.missing;
    }
  std::ranges::stable_sort(losses, {}, &Loss::middle);
  return losses;
}

Table contests_table(const ReportData& data, const std::vector<Contest>& contests) {
  TableOf<Contest> table("regret", "Error over the least of all methods, by scene and time", contests);
  table.column("scene", "scene", [](const Contest& c) { return c.scene->name; });
  if (on_several_structures(contests))
    table.column("accel", "structure", [](const Contest& c) { return NameCell(c.chosen->shown_accel, c.accel); });
  table.column("time_s", "at time", [](const Contest& c) { return TableCell(c.time_s, format_seconds); });
  table.column("best", "best", [](const Contest& c) { return NameCell(c.best->shown_integrator, c.best->integrator); });
  table.column("least_error", "its error", [](const Contest& c) { return c.errors.at(c.best); });
  table.column("chosen", "chosen", [](const Contest& c) { return choices_of(*c.chosen); });
  table.column("regret", "regret", [](const Contest& c) {
    const auto regret = c.regret(*c.chosen);
    return regret ? times_cell(*regret) : TableCell();
  });
  table.note(fmt::format(
      "Regret is the error over the least that any one method has at that time, both geometric means over seeds and at "
      "least {:.0e}.",
      least_error));
  if (const std::string noise = noise_in_ratios(data); !noise.empty()) table.note(noise);
  return table.take();
}

Table losses_table(const std::vector<Loss>& losses) {
  TableOf<Loss> table("regrets", "What always taking one method loses", losses);
  table.column("method", "method", [](const Loss& loss) { return NameCell(loss.shown, loss.name); });
  table.column("median_regret", "median", [](const Loss& loss) { return times_cell(loss.middle()); });
  table.column("worst_regret", "worst", [](const Loss& loss) { return times_cell(loss.worst()); });
  table.column("without_image", "without an image", [](const Loss& loss) { return loss.missing; });
  return table.take();
}

constexpr double most_drawn = 100;

// A panel a time, a row a scene, a mark a method: where the choice fell, and in grey what it is among.
Figure regret_figure(const std::vector<Contest>& contests, const std::vector<Loss>& losses) {
  constexpr std::size_t blue = 0, black = 6;  // of the charts' palette
  const bool several = on_several_structures(contests);
  Figure figure{.name = "regret", .title = "Error over the least of all methods"};
  double least = 0.5;  // a choice may also err less than any one method
  for (const Loss& loss : losses)
    for (const double regret : loss.regrets) least = std::min(least, regret / 1.1);
  for (const double share : time_shares) {
    Chart chart{.x = {"error over the least", Scale::log, Interval{least, most_drawn}}, .y = {"", Scale::linear}};
    std::map<std::string, ChartSeries> series;
    Interval times{infinity, 0};  // of scenes, whose runs may have lasted differently
    for (const Contest& contest : contests) {
      if (contest.share != share) continue;
      times = {std::min(times.low, contest.time_s), std::max(times.high, contest.time_s)};
      const auto row = static_cast<double>(chart.rows.size());
      chart.rows.push_back(contest.scene->file_stem + (several ? ", " + contest.chosen->short_accel : ""));
      for (const auto& [configuration, error] : contest.errors)
        if (const auto regret = contest.regret(*configuration); regret && *regret <= most_drawn)
          series[key_of(*configuration)].points.emplace_back(*regret, row);
    }
    if (chart.rows.empty()) continue;
    chart.title = format_seconds(times.low);
    if (const std::string last = format_seconds(times.high); last != chart.title) chart.title += " to " + last;
    for (const bool choice : {true, false})
      for (const Loss& loss : losses) {
        if (loss.chooses != choice) continue;
        ChartSeries& marks = chart.series.emplace_back(std::move(series[loss.name]));
        marks.key = choice ? loss.name : "others";
        marks.label = choice ? loss.shown : "each other method";
        marks.detail = choice ? "" : loss.shown;
        marks.draw = choice ? ChartSeries::Draw::dots : ChartSeries::Draw::faint;
        marks.colour = choice ? blue : black;
      }
    figure.panels.push_back(std::move(chart));
  }
  figure.notes = {fmt::format("Methods that err more than {:.0f} times as much as the best are left out.", most_drawn)};
  return figure;
}

}  // namespace

KindReport regret_report(const ReportData& data) {
  if (data.empty() || data.is_signed(data.main_metric())) return {};
  const std::vector<Contest> contests = find_contests(data);
  if (contests.empty()) return {};
  const std::vector<Loss> losses = find_losses(data, contests);
  KindReport report{.id = "regret", .heading = "Regret"};
  report.tables = {contests_table(data, contests), losses_table(losses)};
  const auto chosen = std::ranges::find_if(losses, &Loss::chooses);
  const auto next = std::ranges::find_if(losses, [](const Loss& loss) { return !loss.chooses; });
  const auto times = [](double regret) {
    return std::isfinite(regret) ? format_factor(regret) + " times" : "without limit (no image by then)";
  };
  report.answer = fmt::format("{} errs {} as much as the best method at the median, {} at worst", chosen->shown,
                              times(chosen->middle()), times(chosen->worst()));
  if (next != losses.end())
    report.answer += fmt::format("; always {}: {} and {}", next->shown, times(next->middle()), times(next->worst()));
  report.answer += ".";
  report.section = fmt::format("<p>{}</p>\n", escape_html(report.answer));
  report.figures = {{"By scene and time", {regret_figure(contests, losses)}}};
  return report;
}

}  // namespace etendue
