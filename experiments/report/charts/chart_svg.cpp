#include "experiments/report/charts/chart_svg.h"

#include "experiments/log/json_line.h"
#include "experiments/report/charts/chart_plot.h"
#include "experiments/report/page/assets.h"
#include "experiments/report/report_text.h"
#include "framework/core/lists.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {
namespace {

constexpr std::size_t legend_length = 96;  // characters: a method with the parameters that tell it from others

std::string swatch(ChartSeries series, double x, double y) {
  using Draw = ChartSeries::Draw;
  if (series.draw == Draw::faint) series.draw = Draw::dots;
  std::string out = fmt::format(R"(<g class="{}">)", series_classes(series));
  if (series.draw == Draw::line || series.draw == Draw::stairs)
    out += fmt::format(R"(<path class="line" d="M{} {}h28"/>)", px(x), px(y));
  if (series.draw != Draw::stairs)
    out += fmt::format(R"(<path class="mark" d="{}"/>)", marker_path(series.marker, {x + 14, y}, 4));
  return out + "</g>";
}

// The swatch and its name, from `x` on, in the middle of `y`.
std::string legend_entry(const ChartSeries& series, double x, double y) {
  const std::string text = shortened(series.label, legend_length);
  return fmt::format("{}<text x=\"{}\" y=\"{}\">{}{}</text>\n", swatch(series, x, y), px(x + 36), px(y + 4.5),
                     escape_html(text),
                     text == series.label ? "" : fmt::format("<title>{}</title>", escape_html(series.label)));
}

double legend_width(const ChartSeries& series) { return 36 + text_width(shortened(series.label, legend_length), 13); }

// Entries beside the ends of their lines, pushed apart until none touches another; a thin line leads to each.
std::string legend_at_ends(const std::vector<const ChartSeries*>& entries, const Plot& plot, double left) {
  auto ends = mapped(entries, [&](const ChartSeries* series) {
    return std::pair(plot.place(series->points.back().x, series->points.back().y).y, series);
  });
  std::ranges::stable_sort(ends, {}, [](const auto& end) { return end.first; });
  constexpr double pitch = 18;
  std::vector<double> at;
  for (const auto& [y, series] : ends) at.push_back(at.empty() ? y : std::max(y, at.back() + pitch));
  double limit = plot.box().bottom();
  for (auto y = at.rbegin(); y != at.rend(); ++y, limit -= pitch) *y = std::min(*y, limit);
  std::string out;
  for (std::size_t i = 0; i < ends.size(); ++i)
    out += fmt::format(R"(<path class="leader" d="{}"/>{})",
                       polyline(std::array{dvec2(plot.box().right() + 3, ends[i].first), dvec2(left - 4, at[i])}),
                       legend_entry(*ends[i].second, left, at[i]));
  return out;
}

std::string document(double width, double height, const std::string& title, const std::string& body) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" role=\"img\">\n<title>{2}</title>\n<style>\n{3}{4}</style>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n{5}</svg>\n",
      width, height, escape_html(title), chart_file_css, chart_css, body);
}

// The height that the rows of one of several panels need.
double rows_height(const Chart& chart) { return 84 + 15 * static_cast<double>(chart.rows.size()); }

double plot_height(const Chart& chart) {
  return chart.rows.empty() ? 440 : 84 + 24 * static_cast<double>(std::max<std::size_t>(2, chart.rows.size()));
}

// Holds what stands between the heading of a file and its notes.
struct Sheet {
  std::string body;
  double width, bottom;
};

Sheet single_plot(const Chart& chart) {
  constexpr double plot_width = 700, legend_left = plot_width + 26;
  const auto entries = legend_series({&chart, 1});
  const double height = std::max(plot_height(chart), 18.0 * static_cast<double>(entries.size()) + 84);
  const Plot plot(chart, {8, 40, plot_width, height}, false);
  Sheet sheet{plot.svg(), plot_width + 24, 40 + height};
  double y = plot.box().top + 8, widest = legend_width({});
  for (const ChartSeries* series : entries) widest = std::max(widest, legend_width(*series));
  sheet.width = std::max(sheet.width, legend_left + widest + 16);
  if (std::ranges::all_of(entries, [](const auto* s) { return s->draw == ChartSeries::Draw::line; })) {
    sheet.body += legend_at_ends(entries, plot, legend_left);
    return sheet;
  }
  for (const ChartSeries* series : entries) {
    sheet.body += legend_entry(*series, legend_left, y);
    y += 18;
  }
  return sheet;
}

Sheet grid_of_plots(std::span<const Chart> panels) {
  constexpr double panel_width = 380;
  double panel_height = 300;
  for (const Chart& panel : panels) panel_height = std::max(panel_height, rows_height(panel));
  const std::size_t columns = std::min<std::size_t>(3, panels.size());
  Sheet sheet{"", panel_width * static_cast<double>(columns) + 16, 0};
  double x = 16, y = 52;
  for (const ChartSeries* series : legend_series(panels)) {  // in rows below the title
    const double needed = legend_width(*series) + 22;
    if (x + needed > sheet.width && x > 16) {
      x = 16;
      y += 20;
    }
    sheet.body += legend_entry(*series, x, y);
    x += needed;
  }
  y += 14;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const PixelBox outer{8 + panel_width * static_cast<double>(i % columns),
                         y + panel_height * static_cast<double>(i / columns), panel_width, panel_height};
    sheet.body += Plot(panels[i], outer, true).svg();
  }
  sheet.bottom = y + panel_height * static_cast<double>((panels.size() + columns - 1) / columns);
  return sheet;
}

// The sheet has its heading above, and notes below.
std::string whole_sheet(const std::string& title, Sheet sheet, const std::vector<std::string>& notes) {
  double y = sheet.bottom + 20;
  for (const std::string& note : notes)
    for (const std::string& line : broken_lines(note, static_cast<std::size_t>(std::max(20.0, (sheet.width - 32) / 5.75)))) {
      sheet.body += fmt::format("<text class=\"note\" x=\"16\" y=\"{}\">{}</text>\n", px(y), escape_html(line));
      y += 16;
    }
  const std::string heading =
      fmt::format("<text class=\"heading\" x=\"16\" y=\"26\">{}</text>\n", escape_html(shortened(title, 100)));
  return document(sheet.width, y - 2, title, heading + sheet.body);
}

}  // namespace

std::vector<const ChartSeries*> legend_series(std::span<const Chart> panels) {
  std::vector<const ChartSeries*> entries;
  for (const Chart& chart : panels) {
    const auto count = std::ranges::count_if(chart.series, [](const auto& s) { return s.is_in_legend(); });
    for (const ChartSeries& series : chart.series) {
      const auto same = [&](const ChartSeries* entry) { return entry->key == series.key; };
      const bool named_by_title = count == 1 && series.label == chart.title;
      if (series.is_in_legend() && !named_by_title && std::ranges::none_of(entries, same)) entries.push_back(&series);
    }
  }
  return entries;
}

std::string inline_svg(const Chart& chart, bool compact) {
  const double width = compact ? 420 : 720, height = compact ? std::max(310.0, rows_height(chart)) : plot_height(chart);
  return fmt::format(
      "<svg class=\"chart\" viewBox=\"0 0 {:.0f} {:.0f}\" tabindex=\"0\" role=\"img\" aria-label=\"{}\" "
      "data-title=\"{}\" data-x=\"{}\" data-y=\"{}\"{}>\n{}</svg>\n",
      width, height,
      escape_html(fmt::format("{}{} against {}", chart.title.empty() ? "" : chart.title + ": ", chart.y.title, chart.x.title)),
      escape_html(chart.title), escape_html(chart.x.title), escape_html(chart.y.title),
      chart.rows.empty() ? "" : fmt::format(R"( data-rows="{}")", escape_html(dump(Json(chart.rows)))),
      Plot(chart, {0, 0, width, height}, compact).svg());
}

std::string standalone_svg(const std::string& title, std::span<const Chart> panels, const std::vector<std::string>& notes) {
  return whole_sheet(title, panels.size() == 1 ? single_plot(panels.front()) : grid_of_plots(panels), notes);
}

std::string standalone_svg(const std::string& title, const Drawing& drawing, const std::vector<std::string>& notes) {
  return whole_sheet(
      title, {fmt::format("<g transform=\"translate(0 40)\">{}</g>\n", drawing.svg), drawing.width, 40 + drawing.height},
      notes);
}

std::string inline_svg(const Drawing& drawing, const std::string& title) {
  // A narrow one fits a phone as it is, and is not blown up to the page's width.
  constexpr double narrow = 600;
  const std::string style =
      drawing.width > narrow ? "" : fmt::format(" style=\"min-width:0;max-width:{:.0f}px\"", 1.4 * drawing.width);
  return fmt::format("<svg class=\"drawing\" viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"{}\"{}>\n{}</svg>\n",
                     drawing.width, drawing.height, escape_html(title), style, drawing.svg);
}

std::string legend_swatch(const ChartSeries& series) {
  return fmt::format("<svg class=\"swatch\" viewBox=\"0 0 28 14\" width=\"28\" height=\"14\" aria-hidden=\"true\">{}</svg>",
                     swatch(series, 0, 7));
}

}  // namespace etendue
