#include "experiments/report/page/figure.h"

#include "experiments/report/report_text.h"

#include <fmt/format.h>
#include <set>

namespace etendue {

std::string stage_html(const Figure& figure) {
  std::string out = fmt::format("<figcaption>{}</figcaption><div class=\"panels\">", escape_html(figure.title));
  for (const Chart& panel : figure.panels) out += inline_svg(panel, figure.panels.size() > 1);
  out += "</div>";
  for (const std::string& note : figure.notes) out += "<p class=\"note\">" + escape_html(note) + "</p>";
  return out;
}

std::string legend_html(const Figure& figure) {
  std::string out = "<ul class=\"legend\" aria-label=\"Series: click to switch, double click to see one alone\">";
  std::set<std::string> keys;
  std::size_t count = 0;
  for (const Chart& panel : figure.panels)
    for (const ChartSeries& series : panel.series) {
      if (!series.is_in_legend() || panel.is_named_by_title(series) || !keys.insert(series.key).second) continue;
      ++count;
      out += fmt::format("<li><button type=\"button\" data-key=\"{}\" aria-pressed=\"true\">{}{}</button></li>",
                         escape_html(series.key), legend_swatch(series), escape_html(series.label));
    }
  return count < 2 ? std::string() : out + "</ul>";
}

std::string figure_html(const Figure& figure) {
  if (figure.empty()) return {};
  return fmt::format("<figure class=\"chart\">{}{}</figure>\n", stage_html(figure), legend_html(figure));
}

}  // namespace etendue
