#include "experiments/report/page/html.h"

#include "experiments/log/json_line.h"
#include "experiments/report/page/assets.h"
#include "experiments/report/report_text.h"
#include "experiments/report/verdicts.h"
#include "framework/image/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace etendue {
namespace {

std::string html(std::string_view text) { return escape_html(text); }

std::string title_of(const RunLog& log) {
  std::vector<std::string> titles;
  for (const ManifestRecord& manifest : log.manifests)
    if (!manifest.title.empty()) index_in(titles, manifest.title);
  return titles.empty() ? "Experiment" : enumerate(titles, " / ", 4);
}

std::string facts(const ReportData& data, const PageContent& content) {
  std::vector<std::string> lines;
  for (const KindReport& part : content.parts)
    if (!part.fact.empty()) lines.push_back(part.fact);
  if (!data.log->cells.empty() || lines.empty())
    lines.push_back(fmt::format("{} · {} · {} · {}{} · {} done{}", counted(data.scenes.size(), "scene"),
                                counted(data.integrators.size(), "integrator"), counted(data.accels.size(), "structure"),
                                data.most_seeds > 1 ? "up to " : "", counted(data.most_seeds, "seed"),
                                counted(data.done, "cell"), data.failed > 0 ? fmt::format(", {} failed", data.failed) : ""));
  std::set<std::string> machines;
  for (const ManifestRecord& m : data.log->manifests)
    machines.insert(fmt::format("{}{} · etendue {} ({})", m.cpu.empty() ? "" : m.cpu + ", ",
                                counted(static_cast<std::size_t>(std::max(0, m.threads)), "thread"), m.version,
                                m.commit.empty() ? "no commit" : m.commit));
  lines.insert(lines.end(), machines.begin(), machines.end());
  std::string out;
  for (const std::string& line : lines) out += fmt::format("<p class=\"facts\">{}</p>\n", html(line));
  return out;
}

// --- sections ---

struct Section {
  std::string id, heading, body;

  std::string text() const { return fmt::format("<section id=\"{}\"><h2>{}</h2>\n{}</section>\n", id, html(heading), body); }
  std::string link() const { return fmt::format("<a href=\"#{}\">{}</a>", id, html(heading)); }
};

std::string scene_card(const SceneFindings& scene, bool folded) {
  std::string out = fmt::format("<article class=\"card\"><h3>{}</h3><dl>\n", html(scene.scene));
  for (const Finding& finding : scene.findings) {
    if (folded && &finding == &scene.findings[1]) out += "</dl><details><summary>more</summary><dl>\n";
    out += fmt::format("<dt>{}</dt><dd>{}{}</dd>\n", html(finding.topic),
                       finding.lead.empty() ? "" : "<strong>" + html(finding.lead) + "</strong>", html(finding.text));
  }
  return out + (folded && scene.findings.size() > 1 ? "</dl></details></article>\n" : "</dl></article>\n");
}

// Empty where sections of their own say all that was found.
Section findings(const ReportData& data, const PageContent& content) {
  Section section{"findings", "Findings", ""};
  if (data.done == 0 && data.failed > 0)
    section.body += "<p>No cell finished; what went wrong is in the table of failures.</p>\n";
  else if (data.done == 0 && data.log->records.empty() && data.log->structures.empty())
    section.body += "<p>The log holds no finished cell.</p>\n";
  else if (data.done > 0 && data.empty())
    section.body += "<p>No metric was logged: there was nothing to measure the images against.</p>\n";
  const Conclusions conclusions = conclude(data);
  std::string cards, warnings;
  // Many scenes: what leads stays in sight, the rest a click away.
  for (const SceneFindings& scene : conclusions.scenes) cards += scene_card(scene, conclusions.scenes.size() > 4);
  for (const KindReport& part : content.parts)
    for (const auto& [subject, text] : part.findings)
      cards += fmt::format("<article class=\"card\"><h3>{}</h3><p>{}</p></article>\n", html(subject), html(text));
  for (const std::string& warning : conclusions.warnings) warnings += "<li>" + html(warning) + "</li>\n";
  if (!cards.empty()) section.body += "<div class=\"findings\">\n" + cards + "</div>\n";
  if (!warnings.empty())
    section.body += fmt::format("<aside class=\"warnings\"><h3>To be wary of</h3><ul>\n{}</ul></aside>\n", warnings);
  return section;
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
  for (const Configuration* configuration : data.finished())
    points += static_cast<double>(configuration->replicates.front().checkpoints.size());
  const double each = points * bytes_per_point * charts_per_variant * static_cast<double>(data.metrics.size());
  Variants variants{data.metrics, {Scale::log, Scale::linear}, ""};
  if (2 * each <= static_cast<double>(budget)) return variants;
  variants.scales = {Scale::log};
  variants.note = "Linear axes are left out to keep this page small.";
  if (each <= static_cast<double>(budget)) return variants;
  variants.metrics.resize(1);
  variants.note = "Charts of the other metrics are in charts/, to keep this page small.";
  return variants;
}

// What the toolbar chooses among; the script shows it where there is something to choose.
std::string metric_options(const Variants& variants) {
  std::string out;
  for (const std::string& metric : variants.metrics) {
    const Metric* known = find_metric(metric);
    out += fmt::format("<option data-formula=\"{}\">{}</option>", known ? html(known->formula) : "", html(metric));
  }
  return out;
}

// The title, the panels and the notes of a figure; and the buttons that switch its series, where there are several.
std::string stage_html(const Figure& figure) {
  std::string out = fmt::format("<figcaption>{}</figcaption><div class=\"panels\">", html(figure.title));
  for (const Chart& panel : figure.panels) out += inline_svg(panel, figure.panels.size() > 1);
  out += "</div>";
  for (const std::string& note : figure.notes) out += "<p class=\"note\">" + html(note) + "</p>";
  return out;
}

std::string legend_html(const Figure& figure) {
  const std::vector<const ChartSeries*> entries = legend_series(figure.panels);
  if (entries.size() < 2) return {};
  std::string out = "<ul class=\"legend\" aria-label=\"Series: click to switch, double click to see one alone\">";
  for (const ChartSeries* series : entries)
    out += fmt::format("<li><button type=\"button\" data-key=\"{}\" aria-pressed=\"true\">{}{}</button></li>",
                       html(series->key), legend_swatch(*series), html(series->label));
  return out + "</ul>";
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
        std::string key = metric + (scale == Scale::log ? "|log" : "|linear");
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

Section scene_section(const ReportData& data, const SceneData& scene, const Variants& variants, const PageContent& content) {
  Section section{"scene-" + scene.file_stem, scene.name, ""};
  std::string& out = section.body;
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
    if (content.images[i].scene == scene.name) out += fmt::format("<figure class=\"viewer\" data-scene=\"{}\"></figure>\n", i);
  return section;
}

Section part_section(const KindReport& part) {
  Section section{part.id, part.heading, part.section};
  for (const FigureGroup& group : part.figures) {
    if (group.figures.empty()) continue;
    if (!group.heading.empty()) section.body += fmt::format("<h3>{}</h3>", html(group.heading));
    section.body += "<div class=\"figures\">\n";
    for (Figure figure : group.figures) {
      if (group.heading.empty()) figure.title = figure.scene + ", " + figure.title;
      section.body += fmt::format("<figure class=\"chart\">{}{}</figure>\n", stage_html(figure), legend_html(figure));
    }
    section.body += "</div>\n";
  }
  return section;
}

// --- images ---

std::string images_json(const std::vector<SceneImages>& scenes) {
  Json all = {{"colours", viridis_stops()}, {"scenes", Json::array()}};
  for (const SceneImages& scene : scenes) {
    Json images = Json::array();
    for (const PageImage& image : scene.images)
      images.push_back({{"label", image.label},
                        {"detail", image.detail},
                        {"png", image.png},
                        {"err", image.error_png},
                        {"relmse", image.relmse ? Json(*image.relmse) : Json()}});
    all["scenes"].push_back({{"width", scene.shown.x},
                             {"low", scene.lowest_decade},
                             {"high", scene.highest_decade},
                             {"notes", scene.notes},
                             {"images", std::move(images)}});
  }
  std::string text = dump(all);
  // No text ends the script.
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) text.replace(at, 1, "\\u003c");
  return text;
}

// --- how to reproduce ---

std::string command_of(const ManifestRecord& m, const PageContent& content) {
  constexpr std::string_view dirty = "-dirty";  // there is no such commit to check out
  const bool changed = m.commit.ends_with(dirty);
  std::string out;
  if (!m.commit.empty())
    out = fmt::format("git checkout {}{}\n", m.commit.substr(0, m.commit.size() - (changed ? dirty.size() : 0)),
                      changed ? "  # and changes that were not committed" : "");
  const bool beside = m.experiment.empty() && content.experiments.size() == 1;
  const std::string file = !m.file.empty() ? m.file : beside ? content.experiments.front().first : nameless_experiment;
  return out + fmt::format("./etendue run {}{} --threads {}{}\n", shell_word(file), m.options.empty() ? "" : " " + m.options,
                           m.threads, m.file.empty() && !m.experiment.empty() ? "  # its text is below" : "");
}

Section reproduction(const ReportData& data, const PageContent& content) {
  std::set<std::string> commands;
  for (const ManifestRecord& manifest : data.log->manifests) commands.insert(command_of(manifest, content));
  std::string report = "./etendue report";
  for (const std::string& directory : content.directories) report += " " + shell_word(directory);
  Section section{"reproduce", "How to reproduce", ""};
  section.body = fmt::format(
      "<pre>{}{}</pre>\n<p class=\"note\">Equal seeds give equal images on any number of threads; times belong to the machine "
      "named above. Everything on this page is computed from runs.jsonl.</p>\n",
      html(fmt::format("{}", fmt::join(commands, ""))), html(report));
  for (const auto& [name, text] : content.experiments)
    section.body += fmt::format("<details><summary>{}</summary><pre>{}</pre></details>\n", html(name), html(text));
  return section;
}

}  // namespace

std::string report_page(const ReportData& data, const PageContent& content) {
  Variants variants;
  const Section found = findings(data, content);
  std::vector<Section> sections;
  if (!data.empty() && !data.finished().empty()) {
    variants = affordable(data, content.chart_budget_bytes);
    for (const SceneData& scene : data.scenes)
      if (!scene.finished().empty()) sections.push_back(scene_section(data, scene, variants, content));
  }
  for (const KindReport& part : content.parts)
    if (!part.section.empty() || !part.figures.empty()) sections.push_back(part_section(part));
  Section& tables = sections.emplace_back(Section{"tables", "Tables", ""});
  for (const Table& table : content.tables)
    if (!table.rows.empty()) tables.body += to_html(table);
  sections.push_back(reproduction(data, content));

  std::string links = found.body.empty() ? "" : found.link(), text;
  for (const Section& section : sections) {
    links += section.link();
    text += section.text();
  }
  return fmt::format(fmt::runtime(page_html), fmt::arg("title", html(title_of(*data.log))), fmt::arg("chart_style", chart_css),
                     fmt::arg("style", page_css), fmt::arg("facts", facts(data, content)), fmt::arg("links", links),
                     fmt::arg("findings", found.body.empty() ? "" : found.text()),
                     fmt::arg("metrics", metric_options(variants)), fmt::arg("left_out", html(variants.note)),
                     fmt::arg("sections", text), fmt::arg("images", images_json(content.images)), fmt::arg("script", page_js));
}

}  // namespace etendue
