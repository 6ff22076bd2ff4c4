#include "experiments/report/charts/charts.h"

#include "experiments/report/report_text.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {
namespace {

// In the order of the SVG's styles (page/chart_file.css, chart_plot.cpp).
constexpr const char* colours[chart_colours] = {"0072B2", "D55E00", "009E73", "CC79A7", "E69F00", "56B4E9", "000000", "B8A800"};
constexpr const char* dashes[chart_dashes] = {"solid",
                                              "dash pattern=on 4pt off 2pt",
                                              "dash pattern=on 1pt off 1.8pt",
                                              "dash pattern=on 5pt off 1.5pt on 1pt off 1.5pt",
                                              "dash pattern=on 7pt off 2.5pt",
                                              "dash pattern=on 2.5pt off 1.5pt on 0.8pt off 1.5pt on 0.8pt off 1.5pt"};
constexpr const char* marks[chart_markers] = {"*", "square*", "triangle*", "diamond*", "triangle*,mark options={rotate=180}",
                                              "+", "x",       "pentagon*"};

std::string style_of(const ChartSeries& series) {
  using Draw = ChartSeries::Draw;
  const std::string colour = fmt::format("c{}", series.colour % chart_colours);
  const std::string mark = fmt::format("mark={},mark size=1.5pt", marks[series.marker % chart_markers]);
  if (series.draw == Draw::stairs) return "black!80,very thick,no marks,const plot";
  if (series.draw == Draw::context) return "black!22,thin,no marks";
  if (series.draw == Draw::guide) return colour + ",thick,densely dotted,no marks";
  if (series.draw == Draw::dots) return fmt::format("{},only marks,{}", colour, mark);
  if (series.draw == Draw::faint) return fmt::format("{},only marks,opacity=0.4,{}", colour, mark);
  return fmt::format("{},thick,{},{},mark options={{solid}}", colour, dashes[series.dash % chart_dashes], mark);
}

bool has_band(const ChartSeries& series) {
  return series.draw == ChartSeries::Draw::line &&
         std::ranges::any_of(series.points, [](const ChartPoint& point) { return point.high > point.low; });
}

std::string limits(const char* axis, Interval range, Scale scale) {
  return fmt::format("{0}min={1:g},{0}max={2:g},{0}mode={3}", axis, range.low, range.high,
                     scale == Scale::log ? fmt::format("log,log basis {}=10", axis) : "linear");
}

std::string axis_options(const Chart& chart) {
  std::string options = limits("x", chart.x.range.value_or(natural_x_range(chart)), chart.x.scale) + ",xlabel={" +
                        escape_tex(chart.x.title) + "}";
  if (!chart.title.empty()) options += ",title={" + escape_tex(chart.title) + "}";
  if (chart.rows.empty())
    return options + "," + limits("y", chart.y.range.value_or(natural_y_range(chart)), chart.y.scale) + ",ylabel={" +
           escape_tex(chart.y.title) + "}";
  std::string labels;
  for (const std::string& row : chart.rows) labels += (labels.empty() ? "{" : ",{") + escape_tex(row) + "}";
  return options + fmt::format(",y dir=reverse,ymin=-0.5,ymax={}.5,ytick={{0,...,{}}},yticklabels={{{}}}",
                               chart.rows.size() - 1, chart.rows.size() - 1, labels);
}

// Numbers the series of all panels, as the data file does.
std::string plots_of(const Chart& chart, const std::string& data_file, std::size_t& number) {
  std::string plots;
  for (const ChartSeries& series : chart.series) {
    const std::size_t index = number++;
    if (series.points.empty()) continue;
    const auto table = [&](const char* column) {
      return fmt::format("table[x=x,y={0},restrict expr to domain={{\\thisrow{{series}}}}{{{1}:{1}}}] {{{2}}};", column, index,
                         data_file);
    };
    if (has_band(series)) {
      for (const char* column : {"low", "high"})
        plots += fmt::format("\\addplot[forget plot,draw=none,name path={}{}] {}\n", column, index, table(column));
      plots += fmt::format("\\addplot[forget plot,c{0},opacity=0.16] fill between[of=low{1} and high{1}];\n",
                           series.colour % chart_colours, index);
    }
    plots += fmt::format("\\addplot[forget plot,{}] {}\n", style_of(series), table("y"));
  }
  const Interval range = chart.x.range.value_or(natural_x_range(chart));
  for (const ChartLabel& label : chart.labels)
    plots +=
        fmt::format("\\node[{},font=\\tiny] at (axis cs:{:g},{:g}) {{{}}};\n",
                    position(label.x, range, chart.x.scale) > 0.6 ? "left" : "right", label.x, label.y, escape_tex(label.text));
  return plots;
}

std::string legend(const std::vector<Chart>& panels) {
  std::string entries;
  for (const ChartSeries* series : legend_series(panels))
    entries += fmt::format("\\addlegendimage{{{}}}\n\\addlegendentry{{{}}}\n", style_of(*series), escape_tex(series->label));
  return entries;
}

}  // namespace

std::string pgfplots_data(const Figure& figure) {
  std::string data = "series x y low high\n";
  std::size_t number = 0;
  for (const Chart& chart : figure.panels) {
    // A log axis has no place for what lies at or below zero: such points lie on its lower edge, as in the SVG.
    const double least =
        chart.rows.empty() && chart.y.scale == Scale::log ? chart.y.range.value_or(natural_y_range(chart)).low : -infinity;
    const auto placed = [&](double value) { return value > 0 ? value : std::max(value, least); };
    for (const ChartSeries& series : chart.series) {
      data += fmt::format("# {}: {}{}\n", number, chart.title.empty() ? "" : chart.title + ": ", series.label);
      for (const ChartPoint& point : series.points)
        data += fmt::format("{} {:.6g} {:.6g} {:.6g} {:.6g}\n", number, point.x, placed(point.y), placed(point.low),
                            placed(point.high));
      ++number;
    }
  }
  return data;
}

std::string to_pgfplots(const Figure& figure, const std::string& data_file) {
  std::string text =
      "% needs " + data_file + " beside it\n\\documentclass[border=2pt]{standalone}\n\\usepackage{pgfplots}\n" +
      "\\pgfplotsset{compat=1.16}\n\\usepgfplotslibrary{fillbetween,groupplots}\n\\begin{document}\n\\begin{tikzpicture}\n";
  for (std::size_t i = 0; i < chart_colours; ++i) text += fmt::format("\\definecolor{{c{}}}{{HTML}}{{{}}}\n", i, colours[i]);
  const std::string common =
      "unbounded coords=discard,filter discard warning=false,legend cell align=left,legend style={draw=none,font=\\small},"
      "grid=major,grid style={black!10}";
  std::size_t number = 0;
  const std::vector<Chart>& panels = figure.panels;
  if (panels.size() == 1) {
    text += fmt::format("\\begin{{axis}}[{},width=9cm,height=6.5cm,legend pos=outer north east,{}]\n", common,
                        axis_options(panels.front()));
    text += legend(panels) + plots_of(panels.front(), data_file, number) + "\\end{axis}\n";
  } else {
    const std::size_t columns = std::min<std::size_t>(3, panels.size());
    text += fmt::format(
        "\\begin{{groupplot}}[group style={{group size={} by {},horizontal sep=1.6cm,vertical sep=1.8cm}},{},width=6cm,"
        "height=5cm,title style={{font=\\small}},label style={{font=\\small}},tick label style={{font=\\scriptsize}}]\n",
        columns, (panels.size() + columns - 1) / columns, common);
    for (std::size_t i = 0; i < panels.size(); ++i) {
      const bool first = i == 0;  // above it stands the legend of all
      text += fmt::format("\\nextgroupplot[{}{}]\n", axis_options(panels[i]),
                          first ? ",legend columns=3,legend style={at={(0,1.25)},anchor=south west}" : "");
      text += (first ? legend(panels) : "") + plots_of(panels[i], data_file, number);
    }
    text += "\\end{groupplot}\n";
  }
  return text + "\\end{tikzpicture}\n\\end{document}\n";
}

}  // namespace etendue
