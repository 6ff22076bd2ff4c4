#include "experiments/report/page/html.h"

#include "experiments/log/json_line.h"
#include "experiments/report/report_text.h"
#include "experiments/report/table_of.h"
#include "framework/core/units.h"
#include "framework/image/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace etendue {
namespace {

// Writes what is shown at first, and all variants as text, of which the script shows the one that is chosen. A browser that
// parsed them all, as it does the content of <template>, would take several times as long to open the page.
class Variable {
 public:
  void add(const std::string& key, const std::string& text) {
    if (text.empty()) return;
    variants_ += fmt::format("<script type=\"text/html\" data-variant=\"{}\">{}</script>\n", escape_html(key), text);
    if (!stage_.empty()) return;
    stage_ = fmt::format("<div class=\"stage\" data-shown=\"{}\">{}</div>", escape_html(key), text);
  }
  bool empty() const { return stage_.empty(); }
  // `uses`: the toolbar's choices that make up a key; `more`: below what is shown.
  std::string figure(std::string_view classes, std::string_view uses, const std::string& more) const {
    return empty() ? ""
                   : fmt::format("<figure class=\"{}\" data-uses=\"{}\">{}{}\n{}</figure>\n", classes, uses, stage_, more,
                                 variants_);
  }

 private:
  std::string stage_, variants_;
};

template <class Make>
std::string variable_chart(const Variants& variants, std::string_view uses, const std::vector<Abscissa>& axes,
                           std::string_view more, const Make& make) {
  Variable variable;
  std::string legend;
  for (const std::string& metric : variants.metrics)
    for (const Scale scale : variants.scales)
      for (const Abscissa axis : axes) {
        std::string key = metric + (scale == Scale::log ? "|log" : "|linear");
        if (axes.size() > 1) key += axis == Abscissa::time ? "|time" : "|iterations";
        const Figure figure = make(metric, scale, axis);
        if (figure.empty()) continue;
        if (variable.empty()) legend = legend_html(figure);
        variable.add(key, stage_html(figure));
      }
  return variable.figure("chart main", uses, legend + std::string(more));
}

// --- the error at equal time ---

struct EqualTimeRow {
  const Configuration* configuration;
  std::optional<Estimate> error;  // nothing: no result by then
  double size = 0;
};

std::optional<Estimate> final_estimate(const Configuration& configuration, const std::string& metric, bool with_sign) {
  const std::vector<double> values = final_values(configuration, metric);
  if (values.empty()) return std::nullopt;
  return with_sign ? signed_estimate(values) : geometric_estimate(values);
}

Table equal_time_table(const ReportData& data, const SceneData& scene, const std::string& metric) {
  auto rows = mapped(scene.finished(), [&](const Configuration* of) {
    return EqualTimeRow{of, estimate_at(*of, metric, scene.common_time_s, data.is_signed(metric))};
  });
  std::string when = "after " + format_seconds(scene.common_time_s);
  // Cells of a few iterations may end before most others have a first image.
  const auto known = std::ranges::count_if(rows, [](const EqualTimeRow& row) { return row.error.has_value(); });
  if (known < 2 || 2 * known < std::ssize(rows)) {
    when = "at each cell's end";
    for (EqualTimeRow& row : rows) row.error = final_estimate(*row.configuration, metric, data.is_signed(metric));
  }
  double least = std::numeric_limits<double>::infinity();
  for (EqualTimeRow& row : rows) {
    row.size = row.error ? std::abs(row.error->centre) : std::numeric_limits<double>::infinity();
    least = std::min(least, row.size);
  }
  std::ranges::stable_sort(rows, {}, &EqualTimeRow::size);
  TableOf<EqualTimeRow> table("equal-time-" + scene.file_stem, fmt::format("{} {}", metric, when), std::move(rows));
  table.column("method", "method", [&](const EqualTimeRow& row) { return short_label(data, *row.configuration); });
  table.column(metric, metric, [](const EqualTimeRow& row) {
    if (!row.error) return TableCell();
    const auto& [centre, interval, spread, count] = *row.error;
    return spread == Spread::none ? TableCell(centre) : TableCell::interval(centre, interval.low, interval.high);
  });
  table.column("to_least", "times the least",
               [&](const EqualTimeRow& row) { return least > 0 && row.error ? TableCell(row.size / least) : TableCell(); });
  table.column("seeds", "seeds", [](const EqualTimeRow& row) { return row.configuration->replicates.size(); });
  return table.take();
}

std::string equal_time_html(const ReportData& data, const SceneData& scene, const Variants& variants) {
  if (scene.common_time_s <= 0) return {};
  Variable variable;
  for (const std::string& metric : variants.metrics)
    if (const Table table = equal_time_table(data, scene, metric); table.rows.size() > 1)
      variable.add(metric, table_html(table));
  return variable.figure("table", "metric", "");
}

// --- the viewer's data ---

Json pixels_json(const PixelText& text) { return text.file.empty() ? Json{{"data", text.in_page}} : Json{{"file", text.file}}; }

Json image_json(const PageImage& image) {
  Json frames = Json::array();
  const auto held = [](const PixelText& text) { return !text.in_page.empty() || !text.file.empty(); };
  for (const PageFrame& frame : image.frames) {
    frames.push_back({{"time", frame.time_s}, {"pixels", pixels_json(frame.pixels)}});
    if (held(frame.flip)) frames.back()["flip"] = pixels_json(frame.flip);
  }
  Json json = {{"label", image.label},
               {"detail", image.detail},
               {"isReference", image.configuration == nullptr},
               {"error", image.relmse ? Json(*image.relmse) : Json()},
               {"pixels", pixels_json(image.pixels)},
               {"exr", image.exr},
               {"frames", std::move(frames)}};
  if (held(image.flip)) json["flip"] = pixels_json(image.flip);
  if (held(image.difference)) {
    json["difference"] = pixels_json(image.difference);
    json["differenceUnit"] = image.difference_unit;
  }
  return json;
}

}  // namespace

std::string Section::text() const {
  return fmt::format("<section id=\"{}\"><h2>{}</h2>\n{}</section>\n", id, escape_html(heading), body);
}
std::string Section::link() const { return fmt::format("<a href=\"#{}\">{}</a>", id, escape_html(heading)); }

Variants affordable(const ReportData& data, std::size_t budget_bytes) {
  constexpr double bytes_per_point = 130, charts_per_variant = 3;  // over time, over iterations, the front
  double points = 0;
  for (const Configuration* configuration : data.finished())
    points += static_cast<double>(configuration->replicates.front().checkpoints.size());
  const double each = points * bytes_per_point * charts_per_variant * static_cast<double>(data.metrics.size());
  Variants variants{data.metrics, {Scale::log, Scale::linear}, ""};
  if (2 * each <= static_cast<double>(budget_bytes)) return variants;
  variants.scales = {Scale::log};
  variants.note = "Linear axes are left out to keep this page small.";
  if (each <= static_cast<double>(budget_bytes)) return variants;
  variants.metrics.resize(1);
  variants.note = "Charts of the other metrics are in charts/, to keep this page small.";
  return variants;
}

std::string stage_html(const Figure& figure) {
  std::string out = fmt::format("<figcaption>{}</figcaption><div class=\"panels\">", escape_html(figure.title));
  for (const Chart& panel : figure.panels) out += inline_svg(panel, figure.panels.size() > 1);
  if (!figure.drawing.svg.empty()) out += inline_svg(figure.drawing, figure.title);
  return out + "</div>" + notes_html(figure.notes);
}

std::string legend_html(const Figure& figure) {
  const std::vector<const ChartSeries*> entries = legend_series(figure.panels);
  if (entries.size() < 2) return {};
  std::string out = "<ul class=\"legend\" aria-label=\"Series: click to switch, double click to see one alone\">";
  for (const ChartSeries* series : entries)
    out += fmt::format("<li><button type=\"button\" data-key=\"{}\" aria-pressed=\"true\">{}<span>{}</span></button></li>",
                       escape_html(series->key), legend_swatch(*series), escape_html(series->label));
  return out + "</ul>";
}

Section scene_section(const ReportData& data, const SceneData& scene, const Variants& variants,
                      const std::vector<SceneImages>& images) {
  Section section{"scene-" + scene.file_stem, scene.name, ""};
  std::string& out = section.body;
  if (scene.reference != nullptr) {
    const ReferenceRecord& r = *scene.reference;
    out += fmt::format("<p class=\"note\">Reference: {}{}{}.</p>\n", escape_html(r.source),
                       r.checks.empty() ? "" : "; " + escape_html(r.checks),
                       r.mse_floor > 0 ? fmt::format("; its own variance {}", format_figure(r.mse_floor)) : "");
  }
  const std::string over_time =
      variable_chart(variants, "metric scale axis", {Abscissa::time, Abscissa::iterations}, "<div class=\"multiples\"></div>",
                     [&](const std::string& metric, Scale scale, Abscissa axis) {
                       return error_figure(data, scene, metric, axis, scale, Layout::overlay);
                     });
  const std::string front = variable_chart(
      variants, "metric scale", {Abscissa::time}, "",
      [&](const std::string& metric, Scale scale, Abscissa) { return front_figure(data, scene, metric, scale); });
  if (over_time.empty() && front.empty())
    out += "<p class=\"none\">Nothing to draw: no checkpoint has both a time and this metric.</p>\n";
  else
    out += "<div class=\"figures\">\n" + over_time + front + "</div>\n";
  for (std::size_t i = 0; i < images.size(); ++i)
    if (images[i].scene == scene.name)
      out += fmt::format("<div class=\"viewer\" data-scene=\"{}\" role=\"group\" aria-label=\"Images of {}\"></div>\n", i,
                         escape_html(scene.name));
  out += equal_time_html(data, scene, variants);
  return section;
}

std::string gallery_html(const ReportData& data, const std::vector<SceneImages>& scenes) {
  constexpr std::size_t most_open = 4;
  std::string out;
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    if (s == most_open) out += "<details><summary>More scenes</summary>\n";
    out += fmt::format("<div><h3>{}</h3><div class=\"strip\">\n", escape_html(scenes[s].scene));
    for (std::size_t i = 0; i < scenes[s].images.size(); ++i) {
      const PageImage& image = scenes[s].images[i];
      const std::string mark = image.configuration != nullptr ? legend_swatch(method_series(data, *image.configuration)) : "";
      out += fmt::format(
          "<a href=\"#view{0}\" data-scene=\"{0}\" data-image=\"{1}\" title=\"{5}\"><img alt=\"\" "
          "src=\"data:image/png;base64,{2}\"><span>{3}{4}</span>{6}</a>\n",
          s, i, image.thumbnail, mark, escape_html(image.label), escape_html(image.detail),
          image.relmse ? fmt::format("<span class=\"note\">relmse {}</span>", format_figure(*image.relmse)) : "");
    }
    out += "</div></div>\n";
  }
  if (scenes.size() > most_open) out += "</details>\n";
  return out.empty() ? "" : "<section class=\"gallery\" aria-label=\"Images\">\n" + out + "</section>\n";
}

std::string images_json(const std::vector<SceneImages>& scenes) {
  Json all = {{"colours", viridis_stops()}, {"scenes", Json::array()}};
  for (const SceneImages& scene : scenes) {
    Json images = Json::array(), ranges = Json::object();
    for (const PageImage& image : scene.images) images.push_back(image_json(image));
    for (const auto& [kind, range] : scene.ranges) ranges[kind] = {range.first, range.second};
    all["scenes"].push_back({{"name", scene.scene},
                             {"width", scene.size.x},
                             {"height", scene.size.y},
                             {"unit", scene.unit},
                             {"white", scene.white},
                             {"epsilon", relmse_epsilon},
                             {"ranges", std::move(ranges)},
                             {"notes", scene.notes},
                             {"images", std::move(images)}});
  }
  std::string text = dump(all);
  // No text ends the script.
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) text.replace(at, 1, "\\u003c");
  return text;
}

}  // namespace etendue
