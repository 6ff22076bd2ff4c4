// `etendue list`: every name there is, and of one or all of them every parameter, default, range and unit.
#include "accel/bvh/dynamic/change_policy.h"
#include "accel/registry.h"
#include "experiments/command/commands.h"
#include "experiments/command/console.h"
#include "experiments/kinds/claims/claim_scenes.h"
#include "experiments/kinds/claims/measurement.h"
#include "experiments/kinds/ledger/ledger_decisions.h"
#include "experiments/kinds/stress/stress_figures.h"
#include "experiments/report/report_text.h"
#include "experiments/report/results/results.h"
#include "framework/image/metrics.h"
#include "framework/io/load_scene.h"
#include "framework/io/text.h"
#include "framework/scene/motion.h"
#include "integrators/registry.h"

#include <fmt/format.h>
#include <unistd.h>
#include <functional>
#include <vector>

namespace etendue {

namespace {

// A name that an experiment or the command line may write.
struct Entry {
  std::string name, summary;
  std::vector<ParamInfo> params = {};
  std::vector<Quantity> quantities = {};
};
using Entries = std::vector<Entry>;

// Without parameters a name takes one line, also on a narrow terminal.
void print_entry(const Entry& entry, bool params) {
  const std::string line = fmt::format("  {:<34} {}", entry.name, entry.summary);
  fmt::print("{}\n", !params && isatty(STDOUT_FILENO) ? shortened(line, Console::width()) : line);
  if (!params) return;
  for (const Quantity& quantity : entry.quantities) fmt::print("      {:<24} {}\n", quantity.name, quantity.text);
  for (const ParamInfo& info : entry.params) {
    const bool plain = info.unit.empty() || info.unit == "1";  // a number without a unit
    fmt::print("      {:<24} {:<14} {}{}{}: {}\n", info.name, info.default_value.empty() ? "\"\"" : info.default_value,
               info.range, plain ? "" : " ", plain ? "" : info.unit, info.help);
  }
}

Entries scene_entries() {
  Entries entries;
  for (const BuiltinScene& scene : builtin_scenes()) entries.push_back({"builtin:" + scene.name, scene.summary, scene.params});
  entries.push_back({"builtin:NAME?key=value,…", "with parameters"});
  entries.push_back({"FILE.pbrt, .xml", "a scene of pbrt or Mitsuba"});
  entries.push_back({"FILE.obj, .ply, .smf", "a bare mesh, with a camera and a light of its own"});
  return entries;
}

Entries accel_entries() {
  Entries entries;
  for (const RayEntry& entry : ray_structures())
    entries.push_back({entry.name,
                       entry.summary + (entry.available ? "" : " (absent: its library was not found when this was built)"),
                       entry.params});
  return entries;
}

// Measurements come with their figures, and with the scenes that only claims ask for.
Entries measurement_entries() {
  Entries entries;
  for (const Measurement& measurement : measurements())
    entries.push_back({measurement.name, measurement.summary, {}, measurement.quantities});
  for (const BuiltinScene& scene : claim_scenes()) entries.push_back({"claim:" + scene.name, scene.summary, scene.params});
  return entries;
}

// Their text is a summary, or what the member names.
template <class Rows, class Text>
std::function<Entries()> rows_of(Rows rows(), Text text) {
  return [rows, text] {
    Entries entries;
    for (const auto& row : rows()) {
      entries.push_back({std::string(row.name), std::string(row.*text)});
      if constexpr (requires { row.params; }) entries.back().params = row.params;
    }
    return entries;
  };
}

Entries experiment_entries() {
  Entries entries;
  for (const auto& [name, file] : experiment_files()) try {
      entries.push_back({name, question_of(read_file(file))});
    } catch (const Error&) {  // one that cannot be read is told of by `run`
      entries.push_back({name, ""});
    }
  return entries;
}

// The entries are gathered where the section is asked for.
struct Section {
  std::string name, title;
  std::function<Entries()> entries;
};

std::vector<Section> list_sections() {
  return {{"scenes", "scenes", scene_entries},
          {"integrators", "integrators", rows_of(integrators, &IntegratorEntry::summary)},
          {"accels", "ray structures", accel_entries},
          {"metrics", "metrics (x: image, r: reference)", rows_of(metrics, &Metric::formula)},
          {"points", "point structures: which photons lie near?", rows_of(point_structures, &PointEntry::summary)},
          {"records", "record structures: which records cover a point?", rows_of(record_structures, &RecordEntry::summary)},
          {"motions", "motions, of experiments on change over time", rows_of(motions, &MotionEntry::summary)},
          {"policies", "policies: what becomes of a tree when its scene moves",
           rows_of(change_policies, &ChangePolicyEntry::summary)},
          {"measurements", "measurements, of experiments on claims (and their scenes)", measurement_entries},
          {"figures", "figures of images and structures, of the failure map", rows_of(stress_figures, &StressFigure::text)},
          {"decisions", "decisions that the program makes from a scene, of the ledger",
           rows_of(ledger_decisions, &LedgerDecision::text)},
          {"edits", "changes of a scene that switch what no parameter does, of the ledger",
           rows_of(ledger_edits, &LedgerEdit::text)},
          {"experiments", "experiments, which `etendue run NAME` runs", experiment_entries}};
}

// Lists what goes by that name, wherever it stands; false if nothing does.
bool list_name(const std::vector<Section>& sections, const std::string& name) {
  bool found = false;
  for (const Section& section : sections)
    for (const Entry& entry : section.entries()) {
      if (entry.name != name) continue;
      fmt::print("{}\n", section.title);
      print_entry(entry, true);
      found = true;
    }
  return found;
}

}  // namespace

std::vector<std::string> listed_names(const std::string& list) {
  std::vector<std::string> names;
  for (const Section& section : list_sections()) {
    if (list.empty()) names.push_back(section.name);
    if (!list.empty() && list != section.name) continue;
    for (const Entry& entry : section.entries())
      if (entry.name.find_first_of(" ?") == std::string::npos) names.push_back(entry.name);  // others stand for many
  }
  return names;
}

int list_command(const std::string& what, bool params) {
  const std::vector<Section> sections = list_sections();
  std::vector<std::string> names;
  bool found = false, left_out = false;
  for (const Section& section : sections) {
    names.push_back(section.name);
    if (!what.empty() && what != section.name) continue;
    if (what.empty()) fmt::print("{}{}\n", found ? "\n" : "", section.title);
    for (const Entry& entry : section.entries()) {
      print_entry(entry, params);
      left_out |= !params && !(entry.params.empty() && entry.quantities.empty());
    }
    found = true;
  }
  if (left_out) fmt::print("\n`etendue list NAME` shows the parameters of one, `--all` those of all.\n");
  if (found || list_name(sections, what)) return 0;
  std::vector<std::string> all = names;
  for (const Section& section : sections)
    for (const Entry& entry : section.entries()) all.push_back(entry.name);
  if (nearest_names(what, all).empty()) all = names;
  throw Error(Location{"list"}, unknown_name("list or name", what, all));
}

}  // namespace etendue
