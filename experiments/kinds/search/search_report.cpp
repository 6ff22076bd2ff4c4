#include "experiments/kinds/search/search_report.h"

#include "experiments/kinds/search/search_curves.h"
#include "experiments/report/report_text.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

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

// Colour and marker go with the structure, wherever it stands.
std::size_t style_of(const RunLog& log, const std::string& structure) {
  std::vector<std::string> names;
  for (const SearchRecord* record : records_of<SearchRecord>(log))
    for (const SearchFigure& figure : record->figures)
      if (std::find(names.begin(), names.end(), figure.structure) == names.end()) names.push_back(figure.structure);
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), structure) - names.begin());
}

ChartSeries series_of(const RunLog& log, const std::string& structure) {
  const std::size_t style = style_of(log, structure);
  ChartSeries series;
  series.key = series.label = structure;
  series.colour = style % chart_colours;
  series.marker = style % chart_markers;
  series.dash = style / chart_colours % chart_dashes;
  return series;
}

// Nothing is drawn at zero: brute force needs no memory of its own.
Chart chart_of(const RunLog& log, const SearchPlot& plot) {
  Chart chart;
  chart.title = measure_name(plot.measure, plot.parameter);
  chart.x = {abscissa_title(plot), Scale::log, std::nullopt};
  chart.y = {axis_title(plot), Scale::log, std::nullopt};
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
  Chart chart;
  chart.title = plots.front()->measure;
  chart.x = {plots.front()->kind, Scale::log, std::nullopt};
  chart.y = {"points asked for", Scale::log, std::nullopt};
  std::map<std::string, ChartSeries> led;
  for (const SearchPlot* plot : plots)
    for (const double x : abscissas(*plot)) {
      const std::string& structure = plot->curves[*leader_at(*plot, x)].structure;
      ChartSeries& series = led.try_emplace(structure, series_of(log, structure)).first->second;
      series.draw = ChartSeries::Draw::dots;
      series.points.push_back({x, plot->parameter, plot->parameter, plot->parameter});
    }
  for (auto& [structure, series] : led) chart.series.push_back(std::move(series));
  return chart;
}

std::string at_text(const SearchPlot& plot) {
  return plot.count > 0 ? fmt::format(" ({:g} {})", plot.count, plot.kind) : std::string();
}

}  // namespace

Table search_times_table(const RunLog& log) {
  Table table{"search-times", "Point and record structures", {}, {}, {}, failed_cells<SearchRecord>(log)};
  table.columns = {{"set", "set", false}, {"count", "count"}, {"structure", "structure", false}};
  std::vector<std::pair<std::string, double>> measures;
  for (const SearchRecord* record : records_of<SearchRecord>(log))
    for (const SearchFigure& f : record->figures) {
      const std::pair measure{f.measure, f.parameter};
      if (std::find(measures.begin(), measures.end(), measure) == measures.end()) measures.push_back(measure);
    }
  std::stable_sort(measures.begin(), measures.end(), [](const auto& a, const auto& b) {
    const auto rank = [](const std::string& m) { return m == "within" ? 1 : m == "nearest" ? 2 : 0; };
    return rank(a.first) < rank(b.first);
  });
  for (const auto& [measure, parameter] : measures) {
    const std::string name = measure_name(measure, parameter);
    std::string key = name + (measure == "memory" ? "_bytes" : "_s");
    std::replace(key.begin(), key.end(), ' ', '_');
    table.columns.push_back({key, name, true, Audience::everyone});
    for (const char* quartile : {"_low", "_high"})
      table.columns.push_back({key + quartile, name + quartile, true, Audience::machines});
  }
  for (const SearchRecord* logged : records_of<SearchRecord>(log)) {
    const SearchRecord& record = *logged;
    std::vector<std::string> structures;
    for (const SearchFigure& f : record.figures)
      if (std::find(structures.begin(), structures.end(), f.structure) == structures.end()) structures.push_back(f.structure);
    for (const std::string& structure : structures) {
      std::vector<TableCell> row{TableCell::words(record.cell.scene), TableCell::count(record.count),
                                 TableCell::words(structure)};
      for (const auto& wanted : measures) {
        const auto found = std::find_if(record.figures.begin(), record.figures.end(), [&](const SearchFigure& f) {
          return f.structure == structure && std::pair(f.measure, f.parameter) == wanted;
        });
        for (const auto part : {&Measured::median, &Measured::low, &Measured::high})
          row.push_back(found == record.figures.end()
                            ? TableCell{}
                            : TableCell::number(found->value.*part, value_text(wanted.first, found->value.*part)));
      }
      table.rows.push_back(std::move(row));
    }
  }
  std::uint64_t checked = 0, disagreements = 0;
  for (const SearchRecord* logged : records_of<SearchRecord>(log)) {
    const SearchRecord& record = *logged;
    checked += record.checked;
    disagreements += record.disagreements;
  }
  if (!table.rows.empty())
    table.notes.push_back(fmt::format(
        "CPU time of one thread; medians of interleaved repetitions (the CSV has their quartiles). Build and insertion per "
        "point and record, "
        "queries each. within k: by the radius that holds k points at the median query (clustered sets: at each query). {} "
        "answers compared, {} differ.",
        checked, disagreements));
  return table;
}

Table search_leaders_table(const RunLog& log) {
  Table table{"search-leaders", "The fastest structure", {}, {}, {}, {}};
  table.columns = {{"set", "set", false}, {"measure", "measure", false}, {"count", "count"},    {"fastest", "fastest", false},
                   {"value", "value"},    {"next", "next", false},       {"ratio", "slower by"}};
  for (const SearchPlot& plot : search_plots(log)) {
    if (plot.abscissa != "count" || plot.measure == "memory") continue;
    for (const double x : abscissas(plot)) {
      std::vector<std::pair<double, std::string>> order;
      for (const StructureCurve& curve : plot.curves) {
        const CurvePoint* const point = point_at(curve, x);
        if (point && !(curve.structure == "brute" && plot.measure == "build"))
          order.emplace_back(point->value.median, curve.structure);
      }
      if (order.size() < 2) continue;
      std::sort(order.begin(), order.end());
      const double ratio = order[1].first / order[0].first;
      table.rows.push_back({TableCell::words(plot.set), TableCell::words(measure_name(plot.measure, plot.parameter)),
                            TableCell::count(static_cast<std::uint64_t>(x)), TableCell::words(order[0].second),
                            TableCell::number(order[0].first, value_text(plot.measure, order[0].first)),
                            TableCell::words(order[1].second), TableCell::number(ratio, fmt::format("{:.2f}×", ratio))});
    }
  }
  return table;
}

Table search_crossovers_table(const RunLog& log) {
  Table table{"search-crossovers", "Crossovers of structures", {}, {}, {}, {}};
  table.columns = {{"set", "set", false},
                   {"measure", "measure", false},
                   {"abscissa", "over", false},
                   {"overtaken", "overtaken", false},
                   {"overtaking", "by", false},
                   {"at", "at"},
                   {"lead", "takes the lead", false},
                   {"clear", "beyond the spread", false}};
  for (const SearchPlot& plot : search_plots(log))
    for (const Crossover& c : crossovers(plot)) {
      if (plot.measure == "memory" || plot.measure == "build" || plot.measure == "insert") {
        if (c.overtaken == "brute") continue;  // it builds nothing
      }
      table.rows.push_back({TableCell::words(plot.set), TableCell::words(measure_name(plot.measure, plot.parameter)),
                            TableCell::words(abscissa_title(plot) + at_text(plot)), TableCell::words(c.overtaken),
                            TableCell::words(c.overtaking), TableCell::number(c.at, fmt::format("{:.2g}", c.at)),
                            TableCell::words(c.lead ? "yes" : "no"), TableCell::words(c.clear ? "yes" : "no")});
    }
  if (!table.rows.empty())
    table.notes.push_back(
        "Where the lead changes, and where brute force is overtaken; logarithms interpolated between the values measured. "
        "Beyond "
        "the spread: on both sides the quartiles of the two are apart.");
  return table;
}

std::vector<Figure> search_figures(const RunLog& log) {
  std::vector<Figure> figures;
  std::map<std::string, std::size_t> by_name;
  const auto put = [&](const std::string& name, const std::string& set, const std::string& title, Chart chart) {
    const auto [entry, fresh] = by_name.try_emplace(name, figures.size());
    if (fresh) figures.push_back({name, set, title, {}, {}});
    figures[entry->second].panels.push_back(std::move(chart));
  };
  const std::vector<SearchPlot> plots = search_plots(log);
  std::map<std::pair<std::string, std::string>, std::vector<const SearchPlot*>> maps;
  std::vector<std::pair<std::string, std::string>> map_order;
  for (const SearchPlot& plot : plots) {
    if (abscissas(plot).size() < 2) continue;
    const bool records = plot.kind == "records", one_of_many = plot.set != plot.base;
    const std::string what = records || plot.parameter > 0 ? plot.measure : "build";
    if (plot.abscissa == "count" && plot.parameter > 0) {
      auto& map = maps[{plot.set, plot.measure}];
      if (map.empty()) map_order.emplace_back(plot.set, plot.measure);
      map.push_back(&plot);
    }
    // What varies on purpose is shown over what it varies by; and records, of which there is less to show, both ways.
    if (one_of_many && !records) continue;
    if (plot.abscissa == "count")
      put(fmt::format("{}-count-{}", records ? "records" : "points-" + what, slug(plot.set)), plot.set,
          plot.kind + " over their number", chart_of(log, plot));
    else if (plot.abscissa == "neighbours")
      put("points-neighbours-" + slug(plot.set), plot.set, "points over the number asked for" + at_text(plot),
          chart_of(log, plot));
    else
      put(fmt::format("{}-{}-{}", records ? "records" : "points-" + what, plot.abscissa, slug(plot.set)), plot.set,
          fmt::format("{} over the {}{}", plot.kind, plot.abscissa, at_text(plot)), chart_of(log, plot));
  }
  for (const auto& key : map_order) {
    const std::vector<const SearchPlot*>& map = maps.at(key);
    const std::string& base = map.front()->base;
    Chart chart = leader_map(log, map);
    if (key.first != base) chart.title += "," + key.first.substr(base.size());
    put("points-crossover-" + slug(base), base, "the structure that answers first", std::move(chart));
  }
  return figures;
}

std::vector<std::pair<std::string, std::string>> search_findings(const RunLog& log) {
  std::vector<std::pair<std::string, std::string>> findings;
  for (const SearchPlot& plot : search_plots(log)) {
    if (plot.abscissa != "count" || plot.measure == "memory") continue;
    const double x = abscissas(plot).back();
    std::vector<std::pair<double, std::string>> order;
    for (const StructureCurve& curve : plot.curves)
      if (const CurvePoint* point = point_at(curve, x); point && curve.structure != "brute")
        order.emplace_back(point->value.median, curve.structure);
    if (order.size() < 2) continue;
    std::sort(order.begin(), order.end());
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

std::string search_summary(const RunLog& log) {
  std::string out;
  for (const auto& [set, text] : search_findings(log)) {
    out += set + "\n";
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find("; ", begin), text.size());
      out += "  " + text.substr(begin, end - begin) + "\n";
      begin = end + 2;
    }
  }
  const Table crossings = search_crossovers_table(log);
  if (!crossings.rows.empty()) out += to_terminal(crossings, 0);
  for (const std::string& note : failed_cells<SearchRecord>(log)) out += note + "\n";
  return out.empty() ? "The log holds no finished cell.\n" : out;
}

KindReport search_report(const RunLog& log) {
  const std::size_t sets = records_of<SearchRecord>(log).size();
  if (sets == 0) return {};
  KindReport report{.fact = fmt::format("{} {}", sets, sets == 1 ? "set searched" : "sets searched"),
                    .tables = {search_times_table(log), search_leaders_table(log), search_crossovers_table(log)},
                    .findings = search_findings(log),
                    .id = "searches",
                    .heading = "Points and records",
                    .figures = {{"", search_figures(log)}}};
  for (auto& [set, text] : report.findings) text += ".";
  return report;
}

}  // namespace etendue
