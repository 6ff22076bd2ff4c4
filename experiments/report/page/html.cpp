#include "experiments/report/page/html.h"

#include "experiments/log/json_line.h"
#include "experiments/report/charts.h"
#include "experiments/report/page/assets.h"
#include "experiments/report/page/figure.h"
#include "experiments/report/rate_report.h"
#include "experiments/report/report_text.h"
#include "experiments/report/structures/structure_figures.h"
#include "experiments/report/verdicts.h"
#include "framework/core/check.h"
#include "framework/image/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace etendue {
namespace {

std::string html(std::string_view text) { return escape_html(text); }

std::string counted(std::size_t count, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

std::string title_of(const RunLog& log) {
  std::vector<std::string> titles;
  for (const ManifestRecord& manifest : log.manifests)
    if (!manifest.title.empty() && std::find(titles.begin(), titles.end(), manifest.title) == titles.end())
      titles.push_back(manifest.title);
  return titles.empty() ? "Experiment" : enumerate(titles, " / ", 4);
}

std::string header(const ReportData& data, const PageContent& content) {
  std::string out = fmt::format("<header><h1>{}</h1>\n", html(title_of(*data.log)));
  for (const KindReport& kind : content.kinds)
    if (!kind.fact.empty()) out += fmt::format("<p class=\"facts\">{}</p>\n", html(kind.fact));
  if (!data.scenes.empty() || data.log->records.empty())
    out += fmt::format(
        "<p class=\"facts\">{} · {} · {} · {}{} · {} done{}</p>\n", counted(data.scenes.size(), "scene", "scenes"),
        counted(data.integrators.size(), "integrator", "integrators"), counted(data.accels.size(), "structure", "structures"),
        data.most_seeds > 1 ? "up to " : "", counted(data.most_seeds, "seed", "seeds"), counted(data.done, "cell", "cells"),
        data.failed > 0 ? fmt::format(", {} failed", data.failed) : "");
  std::set<std::string> machines;
  for (const ManifestRecord& m : data.log->manifests)
    machines.insert(fmt::format("{}{} · etendue {} ({})", m.cpu.empty() ? "" : m.cpu + ", ",
                                counted(static_cast<std::size_t>(std::max(0, m.threads)), "thread", "threads"), m.version,
                                m.commit.empty() ? "no commit" : m.commit));
  for (const std::string& machine : machines) out += fmt::format("<p class=\"facts\">{}</p>\n", html(machine));
  return out + "</header>\n";
}

bool has_charts(const ReportData& data, const SceneData& scene) {
  return !data.empty() && std::any_of(scene.configurations.begin(), scene.configurations.end(),
                                      [](const Configuration& c) { return !c.replicates.empty(); });
}

// Whether sections of their own say all that was found.
bool found_in_sections(const ReportData& data, const PageContent& content) {
  if (!data.scenes.empty()) return false;
  bool any = false;
  for (const KindReport& kind : content.kinds) {
    if (!kind.findings.empty()) return false;
    any = any || kind.finds_in_section;
  }
  return any;
}

std::string navigation(const ReportData& data, const PageContent& content) {
  std::string out = "<nav aria-label=\"Contents\">";
  if (!found_in_sections(data, content)) out += "<a href=\"#findings\">Findings</a>";
  for (const SceneData& scene : data.scenes)
    if (has_charts(data, scene)) out += fmt::format("<a href=\"#scene-{}\">{}</a>", scene.file_stem, html(scene.name));
  if (!content.stated.rows.empty()) out += "<a href=\"#predictions\">Predictions</a>";
  for (const KindReport& kind : content.kinds)
    if (!kind.section.empty()) out += fmt::format("<a href=\"#{}\">{}</a>", kind.id, html(kind.heading));
  if (!data.log->structures.empty()) out += "<a href=\"#structures\">Ray structures</a>";
  return out + "<a href=\"#tables\">Tables</a><a href=\"#reproduce\">How to reproduce</a></nav>\n";
}

std::string findings(const ReportData& data, const PageContent& content) {
  if (found_in_sections(data, content)) return {};
  const Conclusions conclusions = conclude(data);
  std::string out = "<section id=\"findings\"><h2>Findings</h2>\n";
  if (data.done == 0 && data.failed > 0)
    out += "<p>No cell finished; what went wrong is in the table of failures.</p>\n";
  else if (data.done == 0 && data.log->records.empty())
    out += "<p>The log holds no finished cell.</p>\n";
  else if (data.done > 0 && data.empty())
    out += "<p>No metric was logged: there was nothing to measure the images against.</p>\n";
  out += "<div class=\"findings\">\n";
  for (const SceneFindings& scene : conclusions.scenes) {
    out += fmt::format("<article class=\"card\"><h3>{}</h3><dl>\n", html(scene.scene));
    for (const Finding& finding : scene.findings) {
      // Many scenes: what leads stays in sight, the rest a click away.
      if (conclusions.scenes.size() > 4 && &finding == &scene.findings[1]) out += "</dl><details><summary>more</summary><dl>\n";
      out += fmt::format("<dt>{}</dt><dd>{}{}</dd>\n", html(finding.topic),
                         finding.lead.empty() ? "" : "<strong>" + html(finding.lead) + "</strong>", html(finding.text));
    }
    out += conclusions.scenes.size() > 4 && scene.findings.size() > 1 ? "</dl></details></article>\n" : "</dl></article>\n";
  }
  for (const KindReport& kind : content.kinds)
    for (const auto& [subject, text] : kind.findings)
      out += fmt::format("<article class=\"card\"><h3>{}</h3><p>{}</p></article>\n", html(subject), html(text));
  out += "</div>\n";
  if (!conclusions.warnings.empty()) {
    out += "<aside class=\"warnings\"><h3>To be wary of</h3><ul>\n";
    for (const std::string& warning : conclusions.warnings) out += "<li>" + html(warning) + "</li>\n";
    out += "</ul></aside>\n";
  }
  return out + "</section>\n";
}

// --- charts ---

// Which variants of the charts the page can afford.
struct Variants {
  std::vector<std::string> metrics;
  std::vector<Scale> scales{Scale::log, Scale::linear};
  std::string note;
};

Variants affordable(const ReportData& data, std::size_t budget) {
  constexpr double bytes_per_point = 130, charts_per_variant = 3;  // over time, over iterations, the front
  double points = 0;
  for (const SceneData& scene : data.scenes)
    for (const Configuration& configuration : scene.configurations)
      if (!configuration.replicates.empty()) points += static_cast<double>(configuration.replicates.front().checkpoints.size());
  const double each = points * bytes_per_point * charts_per_variant;
  Variants variants{data.metrics, {Scale::log, Scale::linear}, ""};
  if (each * 2 * static_cast<double>(data.metrics.size()) <= static_cast<double>(budget)) return variants;
  variants.scales = {Scale::log};
  variants.note = "Linear axes are left out to keep this page small.";
  if (each * static_cast<double>(data.metrics.size()) <= static_cast<double>(budget)) return variants;
  variants.metrics.resize(1);
  variants.note = "Charts of the other metrics are in charts/, to keep this page small.";
  return variants;
}

std::string_view scale_name(Scale scale) { return scale == Scale::log ? "log" : "linear"; }

std::string toolbar(const Variants& variants) {
  std::string out = "<div class=\"toolbar\"><label>Metric <select name=\"metric\">";
  for (const std::string& metric : variants.metrics) {
    const Metric* known = find_metric(metric);
    out += fmt::format("<option data-formula=\"{}\">{}</option>", known ? html(known->formula) : "", html(metric));
  }
  out +=
      "</select></label>\n<fieldset><legend>Against</legend><label><input type=\"radio\" name=\"axis\" value=\"time\" checked> "
      "time</label>"
      "<label><input type=\"radio\" name=\"axis\" value=\"iterations\"> iterations</label></fieldset>\n";
  if (variants.scales.size() > 1)
    out +=
        "<fieldset><legend>Axes</legend><label><input type=\"radio\" name=\"scale\" value=\"log\" checked> logarithmic</label>"
        "<label><input type=\"radio\" name=\"scale\" value=\"linear\"> linear</label></fieldset>\n";
  out += "<output class=\"formula note\"></output>";
  if (!variants.note.empty()) out += fmt::format("<span class=\"note\">{}</span>", html(variants.note));
  return out + "</div>\n";
}

// The first variant that draws anything in the open, all of them as templates.
template <class Make>
std::string variable_figure(const Variants& variants, std::string_view uses, const std::vector<Abscissa>& axes,
                            const Make& make) {
  Figure first;
  std::string templates, shown;
  for (const std::string& metric : variants.metrics)
    for (const Scale scale : variants.scales)
      for (const Abscissa axis : axes) {
        std::string key = fmt::format("{}|{}", metric, scale_name(scale));
        if (axes.size() > 1) key += axis == Abscissa::time ? "|time" : "|iterations";
        Figure figure = make(metric, scale, axis);
        if (figure.empty()) continue;
        templates += fmt::format("<template data-variant=\"{}\">{}</template>\n", html(key), stage_html(figure));
        if (!first.empty()) continue;
        first = std::move(figure);
        shown = key;
      }
  if (first.empty()) return {};
  return fmt::format(
      "<figure class=\"chart{}\" data-uses=\"{}\"><div class=\"stage\" data-shown=\"{}\">{}</div>{}\n{}</figure>\n",
      first.panels.size() > 1 ? " wide" : "", uses, html(shown), stage_html(first), legend_html(first), templates);
}

// --- images ---

std::string viewer(const SceneImages& images, std::size_t index) {
  std::string out = fmt::format("<figure class=\"viewer\" data-scene=\"{}\"><figcaption>Images</figcaption>\n", index);
  out += fmt::format(
      "<svg width=\"0\" height=\"0\" aria-hidden=\"true\" style=\"position:absolute\"><filter id=\"exposure-{}\" "
      "color-interpolation-filters=\"linearRGB\"><feComponentTransfer><feFuncR type=\"linear\" slope=\"1\"/>"
      "<feFuncG type=\"linear\" slope=\"1\"/><feFuncB type=\"linear\" slope=\"1\"/></feComponentTransfer></filter></svg>\n",
      index);
  out +=
      "<div class=\"controls\"><label>Left <select class=\"left\"></select></label><label>Right <select "
      "class=\"right\"></select></label>"
      "<label>Exposure <input class=\"exposure\" type=\"range\" min=\"-4\" max=\"6\" step=\"0.25\" value=\"0\"><output "
      "class=\"ev\">0 EV"
      "</output></label><label>Zoom <select class=\"zoom\"><option "
      "value=\"fit\">fit</option><option>1</option><option>2</option>"
      "<option>4</option><option>8</option></select></label></div>\n";
  out +=
      "<div class=\"panes\"><div class=\"pane\"><div class=\"frame-box\"><div class=\"canvas wipe-canvas\"><img "
      "class=\"under\" alt=\"\">"
      "<img class=\"over\" alt=\"\"><div class=\"divider\"></div></div></div>"
      "<input class=\"wipe\" type=\"range\" min=\"0\" max=\"100\" step=\"0.5\" value=\"50\" aria-label=\"Border between left "
      "and right\">"
      "<p class=\"caption\"><span class=\"name-left\"></span><span class=\"name-right\"></span></p></div>\n";
  const auto mapped =
      std::count_if(images.images.begin(), images.images.end(), [](const auto& i) { return !i.error_png.empty(); });
  std::string stops;
  for (int i = 0; i <= 10; ++i) stops += (i > 0 ? "," : "") + viridis_css(i / 10.0);
  out += fmt::format(
      "<div class=\"pane map\"><div class=\"frame-box\"><div class=\"canvas\"><img class=\"error\" alt=\"\"></div></div>"
      "<div class=\"colourbar\" style=\"background:linear-gradient(to right,{})\"></div><div class=\"ticks\"></div>"
      "<p class=\"caption\"><span class=\"name-map\"></span></p></div></div>\n{}<div class=\"sheet\"></div>\n",
      stops,
      mapped < 2
          ? ""
          : "<h3>Where each one errs</h3><p class=\"note\">Each image with its map of relative squared error below it, all in "
            "the colours of the bar above; a click puts it on the left.</p>\n");
  for (const std::string& note : images.notes) out += "<p class=\"note\">" + html(note) + "</p>\n";
  out += fmt::format(
      "<p class=\"note\">White at 0 EV is {} W/(m² sr), 1.25 times the 98th percentile; what is brighter was clipped, so only "
      "darker "
      "parts "
      "can be exposed anew.</p></figure>\n",
      format_figure(1 / images.exposure));
  return out;
}

std::string images_json(const std::vector<SceneImages>& scenes) {
  Json all = Json::array();
  for (const SceneImages& scene : scenes) {
    Json images = Json::array();
    for (const PageImage& image : scene.images)
      images.push_back({{"label", image.label},
                        {"detail", image.detail},
                        {"png", image.png},
                        {"err", image.error_png},
                        {"relmse", image.relmse < 0 ? Json() : Json(image.relmse)}});
    all.push_back({{"width", scene.shown.x},
                   {"low", scene.lowest_decade},
                   {"high", scene.highest_decade},
                   {"images", std::move(images)}});
  }
  std::string text = dump(all);
  // No text ends the script.
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) text.replace(at, 1, "\\u003c");
  return fmt::format("<script type=\"application/json\" id=\"images\">{}</script>\n", text);
}

std::string scene_section(const ReportData& data, const SceneData& scene, const Variants& variants,
                          const PageContent& content) {
  std::string out = fmt::format("<section class=\"scene\" id=\"scene-{}\"><h2>{}</h2>\n", scene.file_stem, html(scene.name));
  if (scene.reference != nullptr) {
    const ReferenceRecord& r = *scene.reference;
    out +=
        fmt::format("<p class=\"note\">Reference: {}{}{}.</p>\n", html(r.source), r.checks.empty() ? "" : "; " + html(r.checks),
                    r.mse_floor > 0 ? fmt::format("; its own variance {}", format_figure(r.mse_floor)) : "");
  }
  const std::string over_time = variable_figure(
      variants, "metric scale axis", {Abscissa::time, Abscissa::iterations},
      [&](const std::string& metric, Scale scale, Abscissa axis) { return error_figure(data, scene, metric, axis, scale); });
  const std::string front = variable_figure(
      variants, "metric scale", {Abscissa::time},
      [&](const std::string& metric, Scale scale, Abscissa) { return front_figure(data, scene, metric, scale); });
  if (over_time.empty() && front.empty())
    out += "<p class=\"none\">Nothing to draw: no checkpoint has both a time and this metric.</p>\n";
  else
    out += "<div class=\"figures\">\n" + over_time + front + "</div>\n";
  for (std::size_t i = 0; i < content.images.size(); ++i)
    if (content.images[i].scene == scene.name) out += viewer(content.images[i], i);
  return out + "</section>\n";
}

std::string predictions_section(const PageContent& content) {
  if (content.stated.rows.empty()) return {};
  std::string out = fmt::format("<section id=\"predictions\"><h2>Predictions</h2>\n<p>{}</p>\n<div class=\"figures\">\n",
                                html(predictions_finding(content.stated)));
  for (Figure& figure : rate_figures(content.rates)) {
    figure.title = figure.scene + ", " + figure.title;
    out += figure_html(figure);
  }
  return out + "</div>\n</section>\n";
}

std::string kind_section(const KindReport& kind) {
  if (kind.section.empty()) return {};
  return fmt::format("<section id=\"{}\"><h2>{}</h2>\n{}</section>\n", kind.id, html(kind.heading), kind.section);
}

std::string structures_section(const ReportData& data) {
  if (data.log->structures.empty()) return {};
  std::string out = "<section id=\"structures\"><h2>Ray structures</h2>\n";
  for (const SceneData& scene : data.scenes) {
    const std::string figures = figure_html(structures_figure(data, scene)) + figure_html(break_even_figure(data, scene)) +
                                figure_html(ray_cost_figure(data, scene));
    if (!figures.empty()) out += fmt::format("<h3>{}</h3><div class=\"figures\">\n{}</div>\n", html(scene.name), figures);
  }
  for (const Figure& figure : structure_sweep_figures(data))
    out += fmt::format("<h3>{}</h3><div class=\"figures\">\n{}</div>\n", html(figure.scene + ": " + figure.title),
                       figure_html(figure));
  if (const std::string figure = figure_html(structures_over_scenes_figure(data)); !figure.empty())
    out += fmt::format("<h3>Over all scenes</h3><div class=\"figures\">\n{}</div>\n", figure);
  return out + "</section>\n";
}

std::string reproduction(const ReportData& data, const PageContent& content) {
  std::string out = "<section id=\"reproduce\"><h2>How to reproduce</h2>\n<pre>";
  std::set<std::string> commands;
  for (const ManifestRecord& m : data.log->manifests) {
    constexpr std::string_view dirty = "-dirty";  // there is no such commit to check out
    const bool changed = m.commit.ends_with(dirty);
    const std::string commit = changed ? m.commit.substr(0, m.commit.size() - dirty.size()) : m.commit;
    const std::string checkout =
        commit.empty() ? ""
                       : fmt::format("git checkout {}{}\n", commit, changed ? "  # and changes that were not committed" : "");
    const bool beside = m.experiment.empty() && content.experiments.size() == 1;
    const std::string file = !m.file.empty() ? m.file : beside ? content.experiments.front().first : nameless_experiment;
    commands.insert(fmt::format("{}./etendue run {}{} --threads {}{}\n", checkout, shell_word(file),
                                m.options.empty() ? "" : " " + m.options, m.threads,
                                m.file.empty() && !m.experiment.empty() ? "  # its text is below" : ""));
  }
  for (const std::string& command : commands) out += html(command);
  out += "./etendue report";
  for (const std::string& directory : content.directories) out += " " + html(shell_word(directory));
  out +=
      "</pre>\n<p class=\"note\">Equal seeds give equal images on any number of threads; times belong to the machine named "
      "above. Everything "
      "on this page is computed from runs.jsonl.</p>\n";
  for (const auto& [name, text] : content.experiments)
    out += fmt::format("<details><summary>{}</summary><pre>{}</pre></details>\n", html(name), html(text));
  return out + "</section>\n";
}

// The template with what stands for each @name@ in its place.
std::string filled(std::string_view page, const std::vector<std::pair<std::string_view, std::string_view>>& parts) {
  std::string out;
  for (const auto& [name, text] : parts) {
    const std::string place = fmt::format("@{}@", name);
    const std::size_t at = page.find(place);
    CHECK(at != std::string_view::npos);
    out.append(page.substr(0, at)).append(text);
    page.remove_prefix(at + place.size());
  }
  return out.append(page);
}

}  // namespace

std::string report_page(const ReportData& data, const PageContent& content) {
  std::string out = header(data, content) + navigation(data, content) + findings(data, content);
  const bool any = std::any_of(data.scenes.begin(), data.scenes.end(), [&](const SceneData& s) { return has_charts(data, s); });
  if (any) {
    const Variants variants = affordable(data, content.chart_budget_bytes);
    out += toolbar(variants);
    out += "<noscript><p class=\"note\">Without JavaScript the charts stand still and images are not shown.</p></noscript>\n";
    for (const SceneData& scene : data.scenes)
      if (has_charts(data, scene)) out += scene_section(data, scene, variants, content);
  }
  out += predictions_section(content);
  for (const KindReport& kind : content.kinds) out += kind_section(kind);
  out += structures_section(data);
  out += "<section id=\"tables\"><h2>Tables</h2>\n";
  for (const Table& table : content.tables)
    if (!table.rows.empty()) out += to_html(table);
  out += "</section>\n" + reproduction(data, content) + images_json(content.images);
  return filled(page_html, {{"title", html(title_of(*data.log))},
                            {"chart_style", chart_css},
                            {"style", page_css},
                            {"content", out},
                            {"script", page_js}});
}

}  // namespace etendue
