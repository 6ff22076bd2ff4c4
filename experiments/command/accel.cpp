// `etendue accel` compares every ray structure on one scene, on the same rays.
#include "experiments/kinds/structures/accel_comparison.h"

#include "experiments/command/commands.h"
#include "experiments/command/console.h"
#include "experiments/config/method.h"
#include "experiments/report/report_data.h"
#include "experiments/report/tables.h"
#include "framework/core/units.h"
#include "framework/io/load_scene.h"

#include <fmt/format.h>

namespace etendue {

namespace {

// Reads structures with their parameters, such as "sah,binned-sah:layout=bvh8:bins=32".
std::vector<Method> choose(const std::string& names) {
  const Location where{"--structures"};
  if (names.empty()) return all_accels(where);
  std::vector<Method> choices;
  for (const std::string& item : split(names, ",")) {
    const std::vector<std::string> parts = split(item, ":");
    Method& method = choices.emplace_back(Method{parts[0], {}, where});
    for (const std::string& pair : std::span(parts).subspan(1)) {
      const std::size_t equals = pair.find('=');
      if (equals == std::string::npos) throw Error(where, "'" + pair + "': expected key=value, as in binned-sah:layout=bvh8");
      method.params[pair.substr(0, equals)] = parse_param_value(pair.substr(equals + 1), where);
    }
    validate_accel(method);
  }
  return choices;
}

// Counts the primitives that no structure may hold, over all objects, each once.
std::uint64_t left_out(const Scene& scene) {
  std::uint64_t count = 0;
  for (const Object& object : scene.objects)
    count += object.geometry.primitive_count() - object.geometry.valid_primitives().size();
  return count;
}

void print_comparison(const std::string& name, const Scene& scene, const RunLog& log) {
  fmt::print("{}: {} triangles", name, format_count(static_cast<double>(scene.triangle_count())));
  if (const std::uint64_t count = left_out(scene); count > 0)
    fmt::print("; {} primitives left out, of no area or not finite", format_count(static_cast<double>(count)));
  fmt::print("\n\n");
  Table table = structures_table(arrange(log));
  for (TableColumn& column : table.columns)
    if (column.key == "scene" || column.key == "triangles") column.audience = Audience::machines;  // the heading says them
  for (std::size_t group = 1; group <= table.group_titles.size(); ++group)
    fmt::print("{}\n{}\n", table.group_titles[group - 1], to_terminal(table, group));
}

}  // namespace

int accel_command(const AccelCommand& command) {
  Console console;
  exit_on_interrupt("\ninterrupted\n");
  const std::vector<Method> choices = choose(command.structures);
  StructureTiming timing = command.timing;
  timing.threads = available_threads(command.threads, console);
  std::vector<Scene> scenes;  // all of them before any is measured: a misspelt one is told at once
  for (const std::string& name : command.scenes) {
    scenes.push_back(load_scene(name, {"command line"}, command.reading));
    for (const std::string& warning : scenes.back().warnings) console.warning(warning);
  }
  std::uint64_t disagreements = 0;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const std::string& name = command.scenes[i];
    const Scene& scene = scenes[i];
    RunLog log;
    for (StructureRecord record :
         compare_structures(scene, choices, timing, [&](const std::string& line) { console.status(line); })) {
      record.scene = name;
      if (!record.fallback.empty()) console.warning(fmt::format("{}: {}: {}", name, record.structure, record.fallback));
      if (!is_third_party(record)) disagreements += record.disagreements;
      if (command.json) {
        console.clear_status();
        fmt::print("{}\n", to_json_line(record));
      }
      log.structures.push_back(std::move(record));
    }
    console.clear_status();
    if (!command.json) print_comparison(name, scene, log);
  }
  if (disagreements > 0) console.warning(fmt::format("{} answers of structures are wrong", disagreements));
  return disagreements > 0 ? 1 : 0;
}

}  // namespace etendue
