#include "experiments/report/page/html.h"

#include "experiments/report/page/assets.h"
#include "experiments/report/report_text.h"
#include "experiments/report/verdicts.h"
#include "framework/image/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
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
  const auto has_fewer = [&](const Configuration* c) { return c->replicates.size() < data.most_seeds; };
  std::vector<std::string> lines;
  for (const KindReport& part : content.parts)
    if (!part.fact.empty()) lines.push_back(part.fact);
  if (!data.log->cells.empty() || lines.empty())
    lines.push_back(fmt::format("{} · {} · {} · {}{} · {} done{}", counted(data.scenes.size(), "scene"),
                                counted(data.integrators.size(), "integrator"), counted(data.accels.size(), "structure"),
                                std::ranges::any_of(data.finished(), has_fewer) ? "up to " : "",
                                counted(data.most_seeds, "seed"), counted(data.done, "cell"),
                                data.failed > 0 ? fmt::format(", {} failed", data.failed) : ""));
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
  constexpr std::size_t most_warnings = 6;  // in sight; the others are a click away
  const bool folded = conclusions.warnings.size() > most_warnings + 1;
  for (std::size_t i = 0; i < conclusions.warnings.size(); ++i) {
    if (folded && i == most_warnings)
      warnings += fmt::format("</ul><details><summary>{} more</summary><ul>\n", conclusions.warnings.size() - i);
    warnings += "<li>" + html(conclusions.warnings[i]) + "</li>\n";
  }
  if (!cards.empty()) section.body += "<div class=\"findings\">\n" + cards + "</div>\n";
  if (!conclusions.scenes.empty() && !data.left_out_of_names.empty())
    section.body += fmt::format("<p class=\"note\">Left out of names: {}.</p>\n", html(joined(data.left_out_of_names, "; ")));
  if (!warnings.empty())
    section.body += fmt::format("<aside class=\"warnings\"><h3>To be wary of</h3><ul>\n{}</ul>{}</aside>\n", warnings,
                                folded ? "</details>" : "");
  return section;
}

// The choices of the toolbar; the script shows it where there is something to choose.
std::string metric_options(const Variants& variants) {
  std::string out;
  for (const std::string& metric : variants.metrics) {
    const Metric* known = find_metric(metric);
    out += fmt::format("<option data-formula=\"{}\">{}</option>", known ? html(known->formula) : "", html(metric));
  }
  return out;
}

Section part_section(const KindReport& part) {
  Section section{part.id, part.heading, part.section};
  for (const FigureGroup& group : part.figures) {
    if (group.figures.empty()) continue;
    if (!group.heading.empty()) section.body += fmt::format("<h3>{}</h3>", html(group.heading));
    section.body += "<div class=\"figures\">\n";
    for (Figure figure : group.figures) {
      if (figure.empty()) continue;
      if (group.heading.empty() && !figure.scene.empty()) figure.title = figure.scene + ", " + figure.title;
      section.body += fmt::format("<figure class=\"chart{}\">{}{}</figure>\n",
                                  figure.panels.size() > 1 || !figure.drawing.svg.empty() ? " wide" : "", stage_html(figure),
                                  legend_html(figure));
    }
    section.body += "</div>\n" + group.below;
  }
  return section;
}

// --- how to reproduce ---

std::string command_of(const ManifestRecord& m) {
  constexpr std::string_view dirty = "-dirty";  // there is no such commit to check out
  const bool changed = m.commit.ends_with(dirty);
  std::string out;
  if (!m.commit.empty())
    out = fmt::format("git checkout {}{}\n", m.commit.substr(0, m.commit.size() - (changed ? dirty.size() : 0)),
                      changed ? "  # and changes that were not committed" : "");
  const std::string file = m.file.empty() ? nameless_experiment : m.file;
  return out + fmt::format("./etendue run {}{} --threads {}{}\n", shell_word(file), m.options.empty() ? "" : " " + m.options,
                           m.threads, m.file.empty() && !m.experiment.empty() ? "  # its text is below" : "");
}

Section reproduction(const ReportData& data, const PageContent& content) {
  std::set<std::string> commands;
  for (const ManifestRecord& manifest : data.log->manifests) commands.insert(command_of(manifest));
  const std::string report = "./etendue report " + joined(content.directories, " ", shell_word);
  Section section{"reproduce", "How to reproduce", ""};
  section.body = fmt::format(
      "<pre>{}{}</pre>\n<p class=\"note\">Equal seeds give equal images on any number of threads; times belong to the machine "
      "named above. Everything on this page is computed from runs.jsonl.</p>\n",
      html(joined(commands, "")), html(report));
  for (const auto& [name, text] : content.experiments)
    section.body += fmt::format("<details><summary>{}</summary><pre>{}</pre></details>\n", html(name), html(text));
  return section;
}

}  // namespace

std::string report_page(const ReportData& data, const PageContent& content) {
  const std::array scripts{page_js, charts_js, tables_js, pixels_js, viewer_js, panes_js, start_js};
  Variants variants;
  const Section found = findings(data, content);
  std::vector<Section> sections;
  if (!data.empty() && !data.finished().empty()) {
    variants = affordable(data, content.chart_budget_bytes);
    for (const SceneData& scene : data.scenes)
      if (!scene.finished().empty()) sections.push_back(scene_section(data, scene, variants, content.images));
  }
  for (const KindReport& part : content.parts)
    if (!part.section.empty() || !part.figures.empty()) sections.push_back(part_section(part));
  Section& tables = sections.emplace_back(Section{"tables", "Tables", ""});
  for (const Table& table : content.tables)
    if (!table.rows.empty()) tables.body += to_html(table, content.has_csv ? "tables/" + table.name + ".csv" : "");
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
                     fmt::arg("sections", text), fmt::arg("images", images_json(content.images)),
                     fmt::arg("answer", content.answer.empty()
                                            ? ""
                                            : fmt::format("<p class=\"answer\">{}</p>\n",
                                                          html(content.answer + (content.answer.ends_with('.') ? "" : ".")))),
                     fmt::arg("gallery", gallery_html(data, content.images)), fmt::arg("script", joined(scripts, "")));
}

}  // namespace etendue
