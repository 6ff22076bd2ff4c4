#include "experiments/kinds/ledger/ledger.h"
#include "experiments/report/declared.h"
#include "experiments/report/reference_noise.h"
#include "experiments/report/report_data.h"
#include "experiments/report/report_text.h"
#include "experiments/report/table_of.h"
#include "experiments/report/verdicts.h"
#include "framework/core/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>

namespace etendue {

namespace {

constexpr double worth = 1.05;      // the least ratio that counts
constexpr double rounding = 1e-10;  // relMSE
constexpr double family_level = 0.05;

// The geometric mean of ratios whose logarithms are given.
Estimate ratio_estimate(const std::vector<double>& logs, double confidence) {
  Estimate estimate = signed_estimate(logs, confidence);
  estimate.centre = std::exp(estimate.centre);
  estimate.interval = {std::exp(estimate.interval.low), std::exp(estimate.interval.high)};
  return estimate;
}

bool above(const Estimate& e) { return e.spread == Spread::t95 && e.interval.low > 1 && e.centre >= worth; }
bool below(const Estimate& e) { return e.spread == Spread::t95 && e.interval.high < 1 && e.centre <= 1 / worth; }
bool little(const Estimate& e) { return e.spread == Spread::t95 && e.interval.low >= 1 / worth && e.interval.high <= worth; }

// Whether both errors are mostly the reference's noise, or near it, so that their ratio says little.
bool is_mostly_noise(const LedgerRecord& record) {
  const double error = mean(mapped(record.trials, &LedgerTrial::error)),
               switched = mean(mapped(record.trials, &LedgerTrial::switched_error));
  return std::min(error, switched) < 2 * record.relmse_floor && std::max(error, switched) < 4 * record.relmse_floor;
}

}  // namespace

std::string_view verdict_name(LedgerVerdict verdict) {
  constexpr std::string_view names[ledger_verdict_count] = {"earns its time", "costs nothing", "no gain beyond noise",
                                                            "a trade", "contradicted"};
  return names[static_cast<std::size_t>(verdict)];
}

LedgerFigures ledger_figures(const LedgerRecord& record, double confidence) {
  CHECK(!record.trials.empty());
  // A method whose error does not fall by itself is taken as one whose noise does.
  const double power = record.mse_exponent < 0 ? -1 / record.mse_exponent : 1;
  std::vector<double> errors, times, both;
  bool same = true;
  for (const LedgerTrial& trial : record.trials) {
    const auto log_ratio = [](double a, double b, double least) { return std::log(std::max(a, least) / std::max(b, least)); };
    errors.push_back(log_ratio(without_noise(trial.switched_error, record.relmse_floor),
                               without_noise(trial.error, record.relmse_floor), rounding));
    times.push_back(log_ratio(trial.switched_cpu_s, trial.cpu_s, 1e-9));
    both.push_back(power * errors.back() + times.back());
    same = same && trial.same_image;
  }
  return {ratio_estimate(errors, confidence), ratio_estimate(times, confidence), ratio_estimate(both, confidence), same};
}

LedgerVerdict judge_decision(const LedgerRecord& record, std::size_t decisions) {
  const LedgerFigures strict = ledger_figures(record, 1 - sidak_level(family_level, std::max<std::size_t>(1, decisions)));
  if (is_mostly_noise(record) && !strict.same_images) return LedgerVerdict::no_gain;
  const bool trade = (above(strict.error) && below(strict.time)) || (below(strict.error) && above(strict.time));
  if (record.bias == "biased" && trade) return LedgerVerdict::trade;
  if (above(strict.time_to_error)) return LedgerVerdict::earns_its_time;
  if (below(strict.time_to_error)) return LedgerVerdict::contradicted;
  const LedgerFigures usual = ledger_figures(record);
  return little(usual.error) && little(usual.time) ? LedgerVerdict::costs_nothing : LedgerVerdict::no_gain;
}

namespace {

struct Decision {
  const LedgerRecord* record;
  LedgerFigures figures;
  LedgerVerdict verdict;

  const std::string& component() const { return record->cell.integrator; }
  const std::string& owner() const { return record->cell.accel; }
  const std::string& scene() const { return record->cell.scene; }
};

std::vector<Decision> decisions_of(const RunLog& log) {
  std::vector<const LedgerRecord*> records = done_records_of<LedgerRecord>(log);
  std::erase_if(records, [](const LedgerRecord* record) { return record->trials.empty(); });
  return mapped(records, [&](const LedgerRecord* record) {
    return Decision{record, ledger_figures(*record), judge_decision(*record, records.size())};
  });
}

// A component of one method over all scenes.
struct Component {
  std::vector<Decision> decisions;

  const Decision& first() const { return decisions.front(); }
  std::size_t count(LedgerVerdict verdict) const {
    return static_cast<std::size_t>(std::ranges::count(decisions, verdict, &Decision::verdict));
  }
  std::vector<double> ratios(Estimate LedgerFigures::*figure) const {
    return mapped(decisions, [figure](const Decision& decision) { return (decision.figures.*figure).centre; });
  }
  std::string scenes(LedgerVerdict verdict) const {
    std::vector<std::string> names;
    for (const Decision& decision : decisions)
      if (decision.verdict == verdict) names.push_back(slug(decision.scene()));
    return joined(names, ", ");
  }
};

std::vector<Component> components_of(const std::vector<Decision>& decisions) {
  std::vector<Component> components;
  for (const Decision& decision : decisions) {
    const auto same = [&](const Component& component) {
      return component.first().component() == decision.component() && component.first().owner() == decision.owner();
    };
    find_or_add(components, same, Component{}).decisions.push_back(decision);
  }
  return components;
}

std::string count_text(const std::vector<Decision>& decisions) {
  std::map<LedgerVerdict, int> counts;
  for (const Decision& decision : decisions) ++counts[decision.verdict];
  return joined(counts, ", ", [](const auto& of) { return fmt::format("{} {}", of.second, verdict_name(of.first)); });
}

std::string on_where(const Component& component) {
  const auto on = std::ranges::count_if(component.decisions, [](const Decision& d) { return d.record->on; });
  const auto all = static_cast<std::ptrdiff_t>(component.decisions.size());
  return on == 0 ? "off" : on == all ? "on" : fmt::format("on in {} of {}", on, all);
}

// Whether more than a hundredth of an error is the reference's noise, which is known less well than the error.
bool is_noisy(const Decision& decision) {
  return std::ranges::any_of(decision.record->trials, [&](const LedgerTrial& trial) {
    return decision.record->relmse_floor > floor_share_limit * std::min(trial.error, trial.switched_error);
  });
}

// Older logs do not say how a reference was rendered.
bool knows_noise(const Decision& decision, const RunLog& log) {
  if (const ReferenceRecord* reference = log.reference(decision.scene()))
    return knows_variance(*reference) && reference_noise(reference, "relmse");
  return decision.record->relmse_floor > 0 || decision.record->reference.starts_with("closed form");
}

// Notes on what the reference's noise does to the ratios; none where references have none.
std::vector<std::string> noise_notes(const std::vector<Decision>& decisions, const RunLog& log) {
  std::vector<std::string> notes, scenes, unknown;
  for (const Decision& decision : decisions)
    if (!knows_noise(decision, log)) index_in(unknown, decision.scene());
  if (!unknown.empty())
    notes.push_back(
        fmt::format("Nobody knows the noise of the references of {}: errors hold it, which brings ratios nearer to 1.",
                    enumerate(unknown, ", ", 6)));
  if (std::ranges::any_of(decisions, [](const Decision& d) { return d.record->relmse_floor > 0; }))
    notes.emplace_back(noise_taken_off);
  for (const Decision& decision : decisions)
    if (is_noisy(decision)) index_in(scenes, decision.scene());
  if (!scenes.empty())
    notes.push_back(
        fmt::format("Of {} the reference's noise is more than {} % of an error, on {}: what is left when it is taken "
                    "off is uncertain, and where it is more than half of one and a quarter of the other there is no gain "
                    "beyond noise; expected reference = {{ samples = N }} with more samples.",
                    counted(static_cast<std::size_t>(std::ranges::count_if(decisions, is_noisy)), "decision"),
                    format_short(100 * floor_share_limit), enumerate(scenes, ", ", 6)));
  return notes;
}

TableCell median_and_ends(const std::vector<double>& ratios) {
  const auto [least, most] = std::ranges::minmax(ratios);
  const double middle = std::exp(median(mapped(ratios, [](double ratio) { return std::log(ratio); })));
  return TableCell::interval(middle, least, most);
}

Table components_table(const RunLog& log, const std::vector<Decision>& decisions, const std::vector<Component>& components) {
  TableOf<Component> table("ledger", "The ledger: components switched, one at a time", components);
  table.column("component", "component", [](const Component& c) { return c.first().component(); });
  table.column("method", "of", [](const Component& c) { return c.first().owner(); });
  table.column("decided", "decided", on_where);
  table.column("error", "error, switched over decided",
               [](const Component& c) { return median_and_ends(c.ratios(&LedgerFigures::error)); });
  table.column("time", "time", [](const Component& c) { return median_and_ends(c.ratios(&LedgerFigures::time)); });
  table.data("same_images", [](const Component& c) {
    return std::ranges::count_if(c.decisions, [](const Decision& d) { return d.figures.same_images; });
  });
  constexpr std::array keys{"earns", "nothing", "no_gain", "trade", "contradicted"};
  for (std::size_t i = 0; i < ledger_verdict_count; ++i)
    table.data(keys[i], [i](const Component& c) { return c.count(static_cast<LedgerVerdict>(i)); });
  table.column(
      "", "verdicts, of scenes", [](const Component& c) { return count_text(c.decisions); }, Audience::people);
  table.column("contradicted_on", "contradicted on", [](const Component& c) {
    const std::string kept = c.first().record->kept, scenes = c.scenes(LedgerVerdict::contradicted);
    return scenes.empty() || kept.empty() ? scenes : fmt::format("{} (it stands: {})", scenes, kept);
  });
  table.note(
      "Ratios: medians over scenes, with the least and the most; above 1 the program's decision is the better. Earns its time: "
      "switched, the image takes longer to the same error; contradicted: less time; a trade: of a biased method, one way errs "
      "less and the other takes less time; costs nothing: error and time are within 5 %; no gain: nor loss of time to the same "
      "error beyond noise and 5 %, though error and time may differ each. The first three are held to a level at which all "
      "decisions together err in one of twenty logs, what costs nothing to intervals of 95 % each.");
  for (const std::string& note : noise_notes(decisions, log)) table.note(note);
  return table.take(failed_cells<LedgerRecord>(log));
}

TableCell ratio_cell(const Estimate& e) { return TableCell::interval(e.centre, e.interval.low, e.interval.high); }

Table decisions_table(const std::vector<Decision>& decisions, const RunLog& log) {
  TableOf<Decision> table("ledger-scenes", "Each decision, scene by scene", decisions);
  table.column("component", "component", [](const Decision& d) { return d.component(); });
  table.column("method", "of", [](const Decision& d) { return d.owner(); });
  table.column("scene", "scene", [](const Decision& d) { return d.scene(); });
  table.column("decided", "decided", [](const Decision& d) { return std::string(d.record->on ? "on" : "off"); });
  table.column("why", "why", [](const Decision& d) { return d.record->why; });
  table.data("switched", [](const Decision& d) { return d.record->switched; });
  const auto ratio = [&](const std::string& key, const char* title, Estimate LedgerFigures::*figure) {
    table.parts(title, {key, key + "_low", key + "_high"}, [figure](const Decision& d) -> std::vector<TableCell> {
      const Estimate& e = d.figures.*figure;
      return {ratio_cell(e), e.centre, e.interval.low, e.interval.high};
    });
  };
  ratio("error", "error, switched over decided", &LedgerFigures::error);
  ratio("time", "time", &LedgerFigures::time);
  ratio("time_to_error", "time to error", &LedgerFigures::time_to_error);
  table.column("same_image", "same image", [](const Decision& d) { return std::string(d.figures.same_images ? "yes" : "no"); });
  table.data("seeds", [](const Decision& d) { return d.record->trials.size(); });
  table.column("verdict", "verdict", [](const Decision& d) { return std::string(verdict_name(d.verdict)); });
  table.note(
      "Geometric means over seeds with 95 % intervals: relMSE at equal iterations, and processor time on one thread. Time to "
      "error: error^(-1 / e) times time, e the exponent at which the method's MSE falls with iterations.");
  for (const std::string& note : noise_notes(decisions, log)) table.note(note);
  Table result = table.take();
  for (const LedgerRecord* record : done_records_of<LedgerRecord>(log))
    if (!record->inapplicable.empty())
      result.notes.push_back(fmt::format("{} on {}: {}.", record->cell.integrator, record->cell.scene, record->inapplicable));
  return result;
}

// "caustic map of photon-map (edge, corner)" for each component that some scene contradicts; without scenes where that is long.
std::string contradictions(const std::vector<Component>& components, bool with_scenes) {
  std::vector<std::string> parts;
  for (const Component& c : components)
    if (const std::size_t count = c.count(LedgerVerdict::contradicted); count > 0)
      parts.push_back(fmt::format("{} of {} ({})", c.first().component(), words_of(c.first().owner()).front(),
                                  with_scenes ? c.scenes(LedgerVerdict::contradicted) : counted(count, "scene")));
  return joined(parts, ", ");
}

std::string ledger_answer(const std::vector<Decision>& decisions, const std::vector<Component>& components) {
  if (decisions.empty()) return {};
  const std::string counts = fmt::format("{}: {}", counted(decisions.size(), "decision"), count_text(decisions));
  if (contradictions(components, true).empty()) return counts + "; none is contradicted";
  const std::string scenes = fmt::format("{}; contradicted: {}", counts, contradictions(components, true));
  if (display_width(scenes) <= answer_width) return scenes;
  const std::string named = fmt::format("{}; contradicted: {}", counts, contradictions(components, false));
  if (display_width(named) <= answer_width) return named;
  const auto some =
      std::ranges::count_if(components, [](const Component& c) { return c.count(LedgerVerdict::contradicted) > 0; });
  return fmt::format("{}, in {} of {} components", counts, some, components.size());
}

// The component, and whose it is where several have it.
std::string row_name(const Component& component, const std::vector<Component>& all) {
  const std::string& name = component.first().component();
  const auto same = std::ranges::count_if(all, [&](const Component& c) { return c.first().component() == name; });
  return same == 1 ? name : fmt::format("{}, {}", name, words_of(component.first().owner()).front());
}

// A row for each component, a dot for each scene; the verdict is the colour.
Figure ratios_figure(const std::vector<Component>& components, const char* what, Estimate LedgerFigures::*figure) {
  Chart chart;
  chart.x = {fmt::format("{}, switched over decided", what), Scale::log, std::nullopt};
  for (const Component& c : components) chart.rows.push_back(row_name(c, components));
  ChartSeries none{.draw = ChartSeries::Draw::context};
  none.points = {{1, -0.5}, {1, static_cast<double>(components.size()) - 0.5}};
  chart.series.push_back(std::move(none));
  constexpr std::array<std::size_t, ledger_verdict_count> colours{2, 7, 5, 4, 1};
  for (std::size_t v = 0; v < ledger_verdict_count; ++v) {
    ChartSeries series;
    series.style(v);
    series.colour = colours[v];
    series.key = series.label = verdict_name(static_cast<LedgerVerdict>(v));
    series.draw = ChartSeries::Draw::dots;
    for (std::size_t i = 0; i < components.size(); ++i)
      for (const Decision& d : components[i].decisions)
        if (d.verdict == static_cast<LedgerVerdict>(v))
          series.points.emplace_back((d.figures.*figure).centre, static_cast<double>(i));
    chart.series.push_back(std::move(series));
  }
  Figure made{.name = fmt::format("ledger-{}", what),
              .title = fmt::format("{} with a component switched: a dot is a scene", what)};
  made.title.front() = static_cast<char>(std::toupper(made.title.front()));
  made.panels = {std::move(chart)};
  made.notes.push_back("Right of 1 the program's decision is the better.");
  return made;
}

}  // namespace

KindReport ledger_report(const RunLog& log) {
  if (records_of<LedgerRecord>(log).empty()) return {};
  const std::vector<Decision> decisions = decisions_of(log);
  const std::vector<Component> components = components_of(decisions);
  KindReport report{.fact = counted(decisions.size(), "decision"),
                    .tables = {components_table(log, decisions, components), decisions_table(decisions, log)},
                    .answer = ledger_answer(decisions, components),
                    .id = "ledger",
                    .heading = "The ledger"};
  if (decisions.empty()) return report;
  report.section = fmt::format("<p>{}.</p>\n", escape_html(report.answer));
  report.figures.push_back(
      {"",
       {ratios_figure(components, "error", &LedgerFigures::error), ratios_figure(components, "time", &LedgerFigures::time)}});
  for (const Component& c : components)
    if (c.count(LedgerVerdict::contradicted) > 0)
      report.findings.emplace_back(row_name(c, components),
                                   fmt::format("contradicted on {}", c.scenes(LedgerVerdict::contradicted)));
  return report;
}

std::string ledger_summary(const RunLog& log) {
  if (records_of<LedgerRecord>(log).empty()) return {};
  const std::vector<Decision> decisions = decisions_of(log);
  const std::vector<Component> components = components_of(decisions);
  std::string out = to_terminal(components_table(log, decisions, components), 0);
  if (!decisions.empty()) out += "\n" + ledger_answer(decisions, components) + ".\n";
  return out;
}

}  // namespace etendue
