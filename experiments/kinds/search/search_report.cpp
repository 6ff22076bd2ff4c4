#include "experiments/kinds/search/search_curves.h"

#include "experiments/report/report_data.h"
#include "experiments/report/report_text.h"
#include "experiments/report/table_of.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

namespace etendue {

namespace {

std::string measure_name(const std::string& measure, double parameter) {
  return parameter > 0 ? fmt::format("{} {:g}", measure, parameter) : measure;
}

std::string value_text(const std::string& measure, double value) {
  return measure == "memory" ? fmt::format("{:.3g} B", value) : format_seconds(value);
}

std::string axis_title(const SearchPlot& plot) {
  if (plot.measure == "memory") return plot.kind == "records" ? "bytes per record" : "bytes per point";
  if (plot.measure == "build") return "build [ns per point]";
  if (plot.measure == "insert") return "insertion [ns per record]";
  return plot.measure + " [ns per query]";
}

std::string abscissa_title(const SearchPlot& plot) {
  if (plot.abscissa == "count") return plot.kind;
  if (plot.abscissa == "neighbours") return "points asked for";
  return plot.abscissa;
}

// Its style goes with the structure, wherever that stands.
ChartSeries series_of(const RunLog& log, const std::string& structure) {
  std::vector<std::string> names;
  for (const SearchRecord* record : records_of<SearchRecord>(log))
    for (const SearchFigure& figure : record->figures) index_in(names, figure.structure);
  ChartSeries series{.key = structure, .label = structure};
  series.style(index_in(names, structure));
  return series;
}

// Nothing is drawn at zero: brute force needs no memory of its own.
Chart chart_of(const RunLog& log, const SearchPlot& plot) {
  Chart chart{.title = measure_name(plot.measure, plot.parameter), .x = {abscissa_title(plot)}, .y = {axis_title(plot)}};
  const double unit = plot.measure == "memory" ? 1 : 1e9;
  for (const StructureCurve& curve : plot.curves) {
    ChartSeries series = series_of(log, curve.structure);
    for (const CurvePoint& p : curve.points)
      if (p.value.median > 0) series.points.push_back({p.x, unit * p.value.median, unit * p.value.low, unit * p.value.high});
    chart.series.push_back(std::move(series));
  }
  return chart;
}

// A mark at each (count, points asked for) in the colour of the structure that answers first.
Chart leader_map(const RunLog& log, const std::vector<const SearchPlot*>& plots) {
  Chart chart{.title = plots.front()->measure, .x = {plots.front()->kind}, .y = {"points asked for"}};
  std::map<std::string, ChartSeries> led;
  for (const SearchPlot* plot : plots)
    for (const double x : abscissas(*plot)) {
      const std::string& structure = plot->curves[*leader_at(*plot, x)].structure;
      ChartSeries& series = led.try_emplace(structure, series_of(log, structure)).first->second;
      series.draw = ChartSeries::Draw::dots;
      series.points.emplace_back(x, plot->parameter);
    }
  for (auto& [structure, series] : led) chart.series.push_back(std::move(series));
  return chart;
}

std::string at_text(const SearchPlot& plot) {
  return plot.count > 0 ? fmt::format(" ({} {})", format_count(plot.count), plot.kind) : std::string();
}

// The measures of structures, in the order of the table's columns.
struct Measure {
  std::string name;
  double parameter = 0;

  bool is(const SearchFigure& figure) const { return figure.measure == name && figure.parameter == parameter; }
};

std::vector<Measure> measures_of(const std::vector<const SearchRecord*>& records) {
  std::vector<Measure> measures;
  for (const SearchRecord* record : records)
    for (const SearchFigure& figure : record->figures)
      if (std::ranges::none_of(measures, [&](const Measure& m) { return m.is(figure); }))
        measures.push_back({figure.measure, figure.parameter});
  std::ranges::stable_sort(measures, [](const Measure& a, const Measure& b) {
    const auto rank = [](const std::string& m) { return m == "within" ? 1 : m == "nearest" ? 2 : 0; };
    return rank(a.name) < rank(b.name);
  });
  return measures;
}

// Brute force builds nothing, so that it takes part in queries alone.
bool is_query(const SearchPlot& plot) {
  return plot.measure != "memory" && plot.measure != "build" && plot.measure != "insert";
}

// Sorts structures by their values at x, the least first.
std::vector<std::pair<double, std::string>> ranking(const SearchPlot& plot, double x, bool with_brute) {
  std::vector<std::pair<double, std::string>> order;
  for (const StructureCurve& curve : plot.curves)
    if (const CurvePoint* point = point_at(curve, x); point && (with_brute || curve.structure != "brute"))
      order.emplace_back(point->value.median, curve.structure);
  std::ranges::sort(order);
  return order;
}

// Whether the quartiles of the first in the order at x are apart from those of all others.
bool leads_clearly(const SearchPlot& plot, double x, const std::vector<std::pair<double, std::string>>& order) {
  const auto value = [&](const std::string& structure) {
    return point_at(*std::ranges::find(plot.curves, structure, &StructureCurve::structure), x)->value;
  };
  const double first = value(order.front().second).high;
  return std::all_of(order.begin() + 1, order.end(), [&](const auto& other) { return first < value(other.second).low; });
}

// A row for each set, count, structure and seed.
Table search_times_table(const RunLog& log) {
  struct Row {
    const SearchRecord* record;
    std::string structure;
  };
  const std::vector<const SearchRecord*> records = records_of<SearchRecord>(log);
  std::vector<Row> rows;
  std::uint64_t checked = 0, disagreements = 0;
  std::set<std::uint64_t> seeds;
  for (const SearchRecord* record : records) {
    seeds.insert(record->cell.seed);
    std::vector<std::string> structures;
    for (const SearchFigure& figure : record->figures) index_in(structures, figure.structure);
    for (const std::string& structure : structures) rows.push_back({record, structure});
    checked += record->checked;
    disagreements += record->disagreements;
  }
  TableOf<Row> table("search-times", "Point and record structures", rows);
  table.column("set", "set", [](const Row& row) { return row.record->cell.scene; });
  table.column("count", "count", [](const Row& row) { return row.record->count; });
  table.column("structure", "structure", [](const Row& row) { return row.structure; });
  table.column(
      "seed", "seed", [](const Row& row) { return row.record->cell.seed; },
      seeds.size() > 1 ? Audience::everyone : Audience::machines);
  for (const Measure& measure : measures_of(records)) {
    const std::string name = measure_name(measure.name, measure.parameter);
    std::string key = name + (measure.name == "memory" ? "_bytes" : "_s");
    std::ranges::replace(key, ' ', '_');
    const auto part = [&](double Measured::*value) {
      return [&measure, value](const Row& row) {
        for (const SearchFigure& f : row.record->figures)
          if (f.structure == row.structure && measure.is(f))
            return TableCell(f.value.*value, value_text(measure.name, f.value.*value));
        return TableCell();
      };
    };
    table.column(key, name, part(&Measured::median));
    table.column(key + "_low", name + "_low", part(&Measured::low), Audience::machines);
    table.column(key + "_high", name + "_high", part(&Measured::high), Audience::machines);
  }
  Table result = table.take();
  result.notes = failed_cells<SearchRecord>(log);
  if (!rows.empty())
    result.notes.push_back(fmt::format(
        "CPU time of one thread; medians of interleaved repetitions (the CSV has their quartiles). Build and insertion per "
        "point and record, queries each. within k: by the radius that holds k points at the median query (clustered sets: at "
        "each query). {} answers compared, {} differ.",
        checked, disagreements));
  return result;
}

// A row for each set, measure and count: the fastest and the next.
Table search_leaders_table(const RunLog& log) {
  struct Row {
    const SearchPlot* plot;
    double x;
    std::vector<std::pair<double, std::string>> order;
  };
  const std::vector<SearchPlot> plots = search_plots(log);
  std::vector<Row> rows;
  for (const SearchPlot& plot : plots) {
    if (plot.abscissa != "count" || plot.measure == "memory") continue;
    for (const double x : abscissas(plot))
      if (auto order = ranking(plot, x, is_query(plot)); order.size() > 1) rows.push_back({&plot, x, std::move(order)});
  }
  TableOf<Row> table("search-leaders", "The fastest structure", std::move(rows));
  table.column("set", "set", [](const Row& row) { return row.plot->set; });
  table.column("measure", "measure", [](const Row& row) { return measure_name(row.plot->measure, row.plot->parameter); });
  table.column("count", "count", [](const Row& row) { return static_cast<std::uint64_t>(row.x); });
  table.column("fastest", "fastest", [](const Row& row) { return row.order[0].second; });
  table.column("value", "value",
               [](const Row& row) { return TableCell(row.order[0].first, value_text(row.plot->measure, row.order[0].first)); });
  table.column("next", "next", [](const Row& row) { return row.order[1].second; });
  table.column("ratio", "slower by", [](const Row& row) {
    const double ratio = row.order[1].first / row.order[0].first;
    return TableCell(ratio, fmt::format("{:.2f}×", ratio));
  });
  table.column("clear", "beyond the spread",
               [](const Row& row) { return leads_clearly(*row.plot, row.x, row.order) ? "yes" : "no"; });
  table.note("Beyond the spread: the fastest's quartiles are apart from those of all others.");
  return table.take();
}

// Says what a figure's panels show, which may be one measure.
std::string what_title(const SearchPlot& plot, bool one_measure) {
  if (!one_measure) return plot.abscissa == "neighbours" ? "queries" : "time and memory";
  if (plot.parameter == 0 && plot.abscissa != "neighbours") return "build and memory";
  return plot.measure == "within" ? "queries within a radius" : plot.measure + " neighbours";
}

// Charts over the count, the number of neighbours and the variation, and maps of which structure leads.
std::vector<Figure> search_figures(const RunLog& log) {
  std::vector<Figure> figures;
  const auto put = [&](const std::string& name, const std::string& set, const std::string& title, Chart chart) {
    const auto same = [&](const Figure& figure) { return figure.name == name; };
    find_or_add(figures, same, {name, set, title}).panels.push_back(std::move(chart));
  };
  const std::vector<SearchPlot> plots = search_plots(log);
  std::vector<std::vector<const SearchPlot*>> maps;  // of one set and measure each
  for (const SearchPlot& plot : plots) {
    if (abscissas(plot).size() < 2) continue;
    const bool records = plot.kind == "records", over_count = plot.abscissa == "count";
    if (over_count && plot.parameter > 0) {
      const auto same = [&](const auto& map) { return map[0]->set == plot.set && map[0]->measure == plot.measure; };
      find_or_add(maps, same, {}).push_back(&plot);
    }
    // What varies on purpose is shown over what it varies by; and records, of which there is less to show, both ways.
    if (plot.set != plot.base && !records) continue;
    const bool over_neighbours = plot.abscissa == "neighbours";
    const std::string what = records || over_neighbours ? "" : "-" + (plot.parameter > 0 ? plot.measure : "build");
    put(fmt::format("{}{}-{}-{}", plot.kind, what, plot.abscissa, slug(plot.set)), plot.set,
        over_count ? fmt::format("{} over the number of {}", what_title(plot, !what.empty()), plot.kind)
                   : fmt::format("{} over the {}{}", what_title(plot, !what.empty()),
                                 over_neighbours ? "number asked for" : plot.abscissa, at_text(plot)),
        chart_of(log, plot));
  }
  for (const std::vector<const SearchPlot*>& map : maps) {
    const std::string &set = map.front()->set, &base = map.front()->base;
    Chart chart = leader_map(log, map);
    if (set != base) chart.title += "," + set.substr(base.size());
    put("points-crossover-" + slug(base), base, "the structure that answers first", std::move(chart));
  }
  return figures;
}

// The structures that took part in one measure of a set at its largest count, the fastest first.
struct LargestCount {
  SearchPlot plot;
  double x;
  std::vector<std::pair<double, std::string>> order;  // two at least
};

std::vector<LargestCount> at_largest_counts(const RunLog& log) {
  std::vector<LargestCount> all;
  for (SearchPlot& plot : search_plots(log)) {
    if (plot.abscissa != "count" || plot.measure == "memory") continue;
    const double x = abscissas(plot).back();
    if (auto order = ranking(plot, x, false); order.size() > 1) all.push_back({std::move(plot), x, std::move(order)});
  }
  return all;
}

// Every structure's time at each set's largest count, a sentence for each measure.
std::vector<std::pair<std::string, std::string>> search_orders(const RunLog& log) {
  std::vector<std::pair<std::string, std::string>> findings;
  for (const auto& [plot, x, order] : at_largest_counts(log)) {
    std::string text = fmt::format("{} at {:g} {}: {} {}", measure_name(plot.measure, plot.parameter), x, plot.kind,
                                   order[0].second, value_text(plot.measure, order[0].first));
    for (std::size_t i = 1; i < order.size(); ++i)
      text += fmt::format(", {} {:.{}f}×", order[i].second, order[i].first / order[0].first,
                          order[i].first < 10 * order[0].first ? 1 : 0);
    if (findings.empty() || findings.back().first != plot.set) findings.emplace_back(plot.set, "");
    findings.back().second += (findings.back().second.empty() ? "" : "; ") + text;
  }
  return findings;
}

// Who is fastest at each measure of a set, at its largest count: "within 1, 10, 50: hash-grid; within 500: bvh".
std::vector<std::pair<std::string, std::string>> search_findings(const RunLog& log) {
  struct Lead {
    std::string set, measure, structure, parameters;
    double least, most;  // how many times slower the next one is
  };
  std::vector<Lead> leads;
  std::map<std::string, std::string> counts;  // by set
  for (const LargestCount& at : at_largest_counts(log)) {
    const auto& [plot, x, order] = at;
    counts[plot.set] = format_count(x) + " " + plot.kind;
    const double ratio = order[1].first / order[0].first;
    const auto same = [&](const Lead& lead) {
      return lead.set == at.plot.set && lead.measure == at.plot.measure && lead.structure == at.order[0].second;
    };
    Lead& lead = find_or_add(leads, same, {plot.set, plot.measure, order[0].second, "", ratio, ratio});
    if (plot.parameter > 0) lead.parameters += fmt::format("{}{:g}", lead.parameters.empty() ? " " : ", ", plot.parameter);
    lead.least = std::min(lead.least, ratio);
    lead.most = std::max(lead.most, ratio);
  }
  std::vector<std::pair<std::string, std::string>> findings;
  for (const Lead& lead : leads) {
    const bool first = findings.empty() || findings.back().first != lead.set;
    if (first) findings.emplace_back(lead.set, "Fastest at " + counts[lead.set] + ". ");
    const std::string least = fmt::format("{:.1f}", lead.least), most = fmt::format("{:.1f}", lead.most);
    findings.back().second += fmt::format("{}{}{}: {} (next: {}{}×)", first ? "" : "; ", lead.measure, lead.parameters,
                                          lead.structure, least, least == most ? "" : "–" + most);
  }
  return findings;
}

// Who is fastest at each measure, at the largest number in each set: "within: hash-grid in 11 of 16, bvh in 5; beyond
// the spread in 14 of 16".
std::string search_answer(const RunLog& log) {
  using Wins = std::vector<std::pair<std::string, std::size_t>>;  // of structures
  std::vector<std::pair<std::string, Wins>> measures;
  std::size_t clear = 0, contests = 0;
  for (const auto& [plot, x, order] : at_largest_counts(log)) {
    clear += leads_clearly(plot, x, order);
    ++contests;
    const auto named = [](const std::string& name) { return [&name](const auto& entry) { return entry.first == name; }; };
    Wins& wins = find_or_add(measures, named(plot.measure), {plot.measure, {}}).second;
    ++find_or_add(wins, named(order[0].second), {order[0].second, 0}).second;
  }
  std::string text;
  for (auto& [measure, wins] : measures) {
    std::ranges::stable_sort(wins, [](const auto& a, const auto& b) { return a.second > b.second; });
    constexpr std::size_t most_named = 3;
    std::size_t all = 0;
    for (const auto& [structure, count] : wins) all += count;
    std::string named;
    for (std::size_t i = 0, left = all; i < wins.size() && i <= most_named; left -= wins[i++].second)
      named += i == 0           ? fmt::format("{} in {} of {}", wins[i].first, wins[i].second, all)
               : i < most_named ? fmt::format(", {} in {}", wins[i].first, wins[i].second)
                                : fmt::format(", others in {}", left);
    text += fmt::format("{}{}: {}", text.empty() ? "Fastest at the largest number: " : "; ", measure, named);
  }
  return text.empty() ? text : fmt::format("{}; beyond the spread in {} of {}", text, clear, contests);
}

}  // namespace

Table search_crossovers_table(const RunLog& log) {
  struct Row {
    const SearchPlot* plot;
    Crossover crossover;
  };
  const std::vector<SearchPlot> plots = search_plots(log);
  std::vector<Row> rows;
  for (const SearchPlot& plot : plots)
    for (const Crossover& crossover : crossovers(plot))
      if (is_query(plot) || crossover.overtaken != "brute") rows.push_back({&plot, crossover});
  TableOf<Row> table("search-crossovers", "Crossovers of structures", std::move(rows));
  const auto yes_or_no = [](bool yes) { return yes ? "yes" : "no"; };
  table.column("set", "set", [](const Row& row) { return row.plot->set; });
  table.column("measure", "measure", [](const Row& row) { return measure_name(row.plot->measure, row.plot->parameter); });
  table.column("abscissa", "over", [](const Row& row) { return abscissa_title(*row.plot) + at_text(*row.plot); });
  table.column("overtaken", "overtaken", [](const Row& row) { return row.crossover.overtaken; });
  table.column("overtaking", "by", [](const Row& row) { return row.crossover.overtaking; });
  table.column("at", "at", [](const Row& row) { return TableCell(row.crossover.at, format_figure(row.crossover.at, 2)); });
  table.column("lead", "takes the lead", [&](const Row& row) { return yes_or_no(row.crossover.lead); });
  table.column("clear", "beyond the spread", [&](const Row& row) { return yes_or_no(row.crossover.clear); });
  table.note(
      "Where the lead changes, and where brute force is overtaken; logarithms interpolated between the values measured. Beyond "
      "the spread: on both sides the quartiles of the two are apart.");
  return table.take();
}

std::string search_summary(const RunLog& log) {
  std::string out;
  for (const auto& [set, text] : search_orders(log)) {
    out += set + "\n";
    for (const std::string& part : split(text, "; ")) out += "  " + part + "\n";
  }
  const Table crossings = search_crossovers_table(log);
  if (!crossings.rows.empty()) out += to_terminal(crossings, 0);
  for (const std::string& note : failed_cells<SearchRecord>(log)) out += note + "\n";
  return out;
}

KindReport search_report(const RunLog& log) {
  const std::size_t sets = records_of<SearchRecord>(log).size();
  if (sets == 0) return {};
  KindReport report{.fact = counted(sets, "set") + " searched",
                    .tables = {search_times_table(log), search_leaders_table(log), search_crossovers_table(log)},
                    .findings = search_findings(log),
                    .answer = search_answer(log),
                    .id = "searches",
                    .heading = "Points and records",
                    .figures = {{"", search_figures(log)}}};
  for (auto& [set, text] : report.findings) text += ".";
  return report;
}

}  // namespace etendue
