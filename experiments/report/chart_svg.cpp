#include "experiments/report/chart_svg.h"

#include "experiments/report/chart_plot.h"
#include "experiments/report/report_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace etendue {
namespace {

struct LegendEntry {
  const ChartSeries* series;
  double y;  // where its line ends
};

// One entry a key, in order; series that draw what another already names (a context, a front's faint points) or
// whose panel is theirs alone are left out.
std::vector<LegendEntry> legend_entries(std::span<const Chart> panels, const PlotFrame* frame) {
  std::vector<LegendEntry> entries;
  for (const Chart& chart : panels)
    for (const ChartSeries& series : chart.series) {
      if (series.draw == ChartSeries::Draw::context || series.draw == ChartSeries::Draw::guide || series.points.empty() ||
          named_by_panel(chart, series))
        continue;
      const bool known =
          std::any_of(entries.begin(), entries.end(), [&](const LegendEntry& e) { return e.series->key == series.key; });
      if (known) continue;
      const double y = frame == nullptr ? 0 : frame->place(series.points.back().x, series.points.back().y).y;
      entries.push_back({&series, y});
    }
  return entries;
}

constexpr std::size_t legend_length = 96;  // characters: a method with the parameters that tell it from others

std::string swatch(ChartSeries series, double x, double y) {
  using Draw = ChartSeries::Draw;
  if (series.draw == Draw::faint) series.draw = Draw::dots;
  std::string out = fmt::format("<g class=\"{}\">", series_classes(series));
  if (series.draw == Draw::line || series.draw == Draw::stairs)
    out += fmt::format("<path class=\"line\" d=\"M{:.1f} {:.1f}h28\"/>", x, y);
  if (series.draw != Draw::stairs)
    out += fmt::format("<path class=\"mark\" d=\"{}\"/>", marker_path(series.marker, {x + 14, y}, 4));
  return out + "</g>";
}

std::string legend_text(const ChartSeries& series, double x, double y) {
  const std::string text = shortened(series.label, legend_length);
  std::string out = fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{}", x, y + 4.5, escape_html(text));
  if (text != series.label) out += fmt::format("<title>{}</title>", escape_html(series.label));
  return out + "</text>\n";
}

// Entries beside the ends of their lines, pushed apart until none touches another; a thin line leads to each.
std::string legend_at_ends(std::vector<LegendEntry> entries, const PlotFrame& frame, double left) {
  std::stable_sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.y < b.y; });
  constexpr double pitch = 18;
  std::vector<double> at;
  for (const LegendEntry& entry : entries) at.push_back(at.empty() ? entry.y : std::max(entry.y, at.back() + pitch));
  double limit = frame.box.bottom();
  for (auto y = at.rbegin(); y != at.rend(); ++y, limit -= pitch) *y = std::min(*y, limit);
  std::string out;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const double edge = frame.box.right();
    out += fmt::format("<path class=\"leader\" d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\"/>", edge + 3, entries[i].y, left - 4, at[i]);
    out += swatch(*entries[i].series, left, at[i]) + legend_text(*entries[i].series, left + 36, at[i]);
  }
  return out;
}

std::string document(double width, double height, const std::string& title, const std::string& body) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" role=\"img\">\n<title>{2}</title>\n<style>\n"
      "text{{font:13px \"Helvetica Neue\",Helvetica,Arial,\"Liberation Sans\",sans-serif;fill:#222}}\n"
      ".c0{{color:#0072b2}}.c1{{color:#d55e00}}.c2{{color:#009e73}}.c3{{color:#cc79a7}}.c4{{color:#e69f00}}.c5{{color:#56b4e9}}"
      ".c6{{color:#000}}.c7{{color:#b8a800}}\n{3}"
      ".context{{color:#c9c9c9}}.grid{{stroke:#e2e2e2}}.minor{{stroke:#f3f3f3}}.zero{{stroke:#999}}.frame{{stroke:#888}}"
      ".leader{{stroke:#aaa}}.mark{{stroke-width:1}}.stairs{{color:#222}}\n"
      ".heading{{font-size:16px;font-weight:600}}.note{{font-size:11.5px;fill:#555}}.label{{stroke:#fff}}\n"
      "</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n{4}</svg>\n",
      width, height, escape_html(title), chart_css(), body);
}

// Notes broken at words to fit the width.
std::vector<std::string> wrapped(const std::vector<std::string>& notes, double width) {
  const auto most = static_cast<std::size_t>(std::max(20.0, width / (0.5 * 11.5)));
  std::vector<std::string> lines;
  for (const std::string& note : notes) {
    std::string line;
    for (std::size_t begin = 0; begin < note.size();) {
      const std::size_t end = std::min(note.find(' ', begin), note.size());
      const std::string word = note.substr(begin, end - begin);
      if (!line.empty() && display_width(line) + 1 + display_width(word) > most) {
        lines.push_back(line);
        line.clear();
      }
      line += (line.empty() ? "" : " ") + word;
      begin = end + 1;
    }
    if (!line.empty()) lines.push_back(line);
  }
  return lines;
}

std::string note_lines(const std::vector<std::string>& lines, double x, double y) {
  std::string out;
  for (std::size_t i = 0; i < lines.size(); ++i)
    out += fmt::format("<text class=\"note\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", x, y + 16 * static_cast<double>(i),
                       escape_html(lines[i]));
  return out;
}

std::string heading(const std::string& title) {
  return fmt::format("<text class=\"heading\" x=\"16\" y=\"26\">{}</text>\n", escape_html(shortened(title, 100)));
}

double plot_height(const Chart& chart) {
  return chart.rows.empty() ? 440 : 84 + 24 * static_cast<double>(std::max<std::size_t>(2, chart.rows.size()));
}

std::string single(const std::string& title, const Chart& chart, const std::vector<std::string>& notes) {
  constexpr double plot_width = 700, legend_left = plot_width + 26;
  const std::size_t count = legend_entries({&chart, 1}, nullptr).size();
  const double height = std::max(plot_height(chart), 18.0 * static_cast<double>(count) + 84);
  const PlotFrame frame = fit_plot(chart, {8, 40, plot_width, height}, false);
  const auto entries = legend_entries({&chart, 1}, &frame);
  std::string body = heading(title) + draw_plot(chart, frame, false);
  const bool at_ends = std::all_of(entries.begin(), entries.end(),
                                   [](const LegendEntry& e) { return e.series->draw == ChartSeries::Draw::line; });
  double widest = 0;
  for (const LegendEntry& entry : entries)
    widest = std::max(widest, text_width(shortened(entry.series->label, legend_length), 13));
  if (at_ends) {
    body += legend_at_ends(entries, frame, legend_left);
  } else {
    double y = frame.box.top + 8;
    for (const LegendEntry& entry : entries) {
      body += swatch(*entry.series, legend_left, y) + legend_text(*entry.series, legend_left + 36, y);
      y += 18;
    }
  }
  const double width = std::max(plot_width + 24, legend_left + 36 + widest + 16);
  const auto lines = wrapped(notes, width - 32);
  body += note_lines(lines, 16, 40 + height + 20);
  return document(width, 40 + height + 18 + 16 * static_cast<double>(lines.size()), title, body);
}

std::string grid(const std::string& title, std::span<const Chart> panels, const std::vector<std::string>& notes) {
  constexpr double panel_width = 380, panel_height = 300;
  const std::size_t columns = std::min<std::size_t>(3, panels.size());
  const double width = panel_width * static_cast<double>(columns) + 16;
  std::string body = heading(title);
  double x = 16, y = 52;
  for (const LegendEntry& entry : legend_entries(panels, nullptr)) {  // in rows below the title
    const double needed = 36 + text_width(shortened(entry.series->label, legend_length), 13) + 22;
    if (x + needed > width && x > 16) {
      x = 16;
      y += 20;
    }
    body += swatch(*entry.series, x, y) + legend_text(*entry.series, x + 36, y);
    x += needed;
  }
  y += 14;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const PixelBox outer{8 + panel_width * static_cast<double>(i % columns),
                         y + panel_height * static_cast<double>(i / columns), panel_width, panel_height};
    body += draw_plot(panels[i], fit_plot(panels[i], outer, true), true);
  }
  y += panel_height * static_cast<double>((panels.size() + columns - 1) / columns);
  const auto lines = wrapped(notes, width - 32);
  body += note_lines(lines, 16, y + 20);
  return document(width, y + 18 + 16 * static_cast<double>(lines.size()), title, body);
}

}  // namespace

Interval natural_x_range(const Chart& chart) {
  std::vector<double> values;
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points) values.push_back(point.x);
  return padded_range(values, chart.x.scale);
}

Interval natural_y_range(const Chart& chart) {
  if (!chart.rows.empty()) return {static_cast<double>(chart.rows.size()) - 0.5, -0.5};  // the first on top
  std::vector<double> values;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points) {
      values.push_back(point.y);
      low = std::min(low, point.y);
      high = std::max(high, point.y);
    }
  // A wide band widens the axis, but not beyond what leaves the lines readable: the interval of three seeds spans decades.
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points) {
      const bool log = chart.y.scale == Scale::log;
      values.push_back(log ? std::max(point.low, point.y / 2) : std::max(point.low, low - 0.3 * (high - low)));
      values.push_back(log ? std::min(point.high, point.y * 2) : std::min(point.high, high + 0.3 * (high - low)));
    }
  return padded_range(values, chart.y.scale);
}

std::string inline_svg(const Chart& chart, bool compact) {
  const double width = compact ? 420 : 720, height = compact ? 310 : chart.rows.empty() ? 440 : plot_height(chart);
  const PlotFrame frame = fit_plot(chart, {0, 0, width, height}, compact);
  return fmt::format(
      "<svg class=\"chart\" viewBox=\"0 0 {:.0f} {:.0f}\" tabindex=\"0\" role=\"img\" aria-label=\"{}\" "
      "data-title=\"{}\" data-x=\"{}\" data-y=\"{}\"{}>\n{}</svg>\n",
      width, height,
      escape_html(fmt::format("{}{} against {}", chart.title.empty() ? "" : chart.title + ": ", chart.y.title, chart.x.title)),
      escape_html(chart.title), escape_html(chart.x.title), escape_html(chart.y.title),
      chart.rows.empty() ? "" : " data-rows=\"1\"", draw_plot(chart, frame, compact));
}

std::string standalone_svg(const std::string& title, std::span<const Chart> panels, const std::vector<std::string>& notes) {
  return panels.size() == 1 ? single(title, panels.front(), notes) : grid(title, panels, notes);
}

std::string legend_swatch(const ChartSeries& series) {
  return fmt::format("<svg class=\"swatch\" viewBox=\"0 0 28 14\" width=\"28\" height=\"14\" aria-hidden=\"true\">{}</svg>",
                     swatch(series, 0, 7));
}

std::string chart_css() {
  return ".line{fill:none;stroke:currentColor;stroke-width:2;stroke-linejoin:round}.context "
         ".line,.line.context{stroke-width:1.2}"
         ".band{fill:currentColor;fill-opacity:.16}.mark{fill:currentColor;stroke:currentColor}"
         ".guide .line{stroke-width:1.4;stroke-dasharray:2 2.5}.faint "
         ".mark{fill:currentColor;fill-opacity:.4;stroke:none}.stairs .line{stroke-width:2.6}"
         ".d1 .line{stroke-dasharray:8 4}.d2 .line{stroke-dasharray:2 3.5}.d3 .line{stroke-dasharray:10 3 2 3}"
         ".d4 .line{stroke-dasharray:14 5}.d5 .line{stroke-dasharray:5 3 1.5 3 1.5 3}"
         ".grid,.minor,.zero,.leader{fill:none;stroke-width:1}.frame{fill:none}"
         ".axis-title{font-weight:500}.panel-title{font-weight:600}"
         ".label{font-size:12px;paint-order:stroke;stroke-width:3.5px;stroke-linejoin:round}\n";
}

}  // namespace etendue
