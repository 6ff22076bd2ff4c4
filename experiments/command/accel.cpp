// `etendue accel`: every ray structure on one scene, on the same rays.
#include "experiments/harness/accel_comparison.h"

#include "experiments/command/commands.h"
#include "experiments/command/console.h"
#include "experiments/harness/report_data.h"
#include "experiments/harness/tables.h"
#include "framework/io/load_scene.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sstream>

namespace etendue {

namespace {

std::vector<StructureChoice> choose(const std::string& names) {
  std::vector<StructureChoice> choices;
  if (names.empty()) {
    for (const RayEntry& entry : ray_structures())
      if (entry.available) choices.push_back({entry.name, {}});
    return choices;
  }
  std::istringstream stream(names);
  for (std::string name; std::getline(stream, name, ',');) {
    find_ray_structure(name, {"--structures"});
    choices.push_back({name, {}});
  }
  return choices;
}

std::string to_json(const StructureRecord& r) {
  return nlohmann::ordered_json{{"scene", r.scene},
                                {"structure", r.structure},
                                {"layout", r.layout},
                                {"triangles", r.triangles},
                                {"build_s", r.build_s},
                                {"bytes", r.bytes},
                                {"sah_cost", r.sah_cost},
                                {"primary_mrays_per_s", r.primary_mrays_per_s},
                                {"diffuse_mrays_per_s", r.diffuse_mrays_per_s},
                                {"shadow_mrays_per_s", r.shadow_mrays_per_s},
                                {"nodes_per_ray", r.nodes_per_ray},
                                {"primitives_per_ray", r.primitives_per_ray},
                                {"disagreements", r.disagreements}}
      .dump();
}

}  // namespace

int accel_command(const AccelCommand& command) {
  Console console;
  exit_on_interrupt("\ninterrupted\n");
  const std::vector<StructureChoice> choices = choose(command.structures);
  ComparisonOptions options;
  options.resolution = static_cast<int>(whole_option("--resolution", command.resolution, 8, 8192));
  options.repetitions = static_cast<int>(whole_option("--repetitions", command.repetitions, 1, 1000));
  RunLog log;
  std::uint64_t disagreements = 0;
  for (const std::string& name : command.scenes) {
    const Scene scene = load_scene(name);
    for (const std::string& warning : scene.warnings) console.warning(warning);
    for (StructureRecord record :
         compare_structures(scene, choices, options, [&](const std::string& line) { console.status(line); })) {
      record.scene = name;
      disagreements += record.disagreements;
      if (command.json) {
        console.clear_status();
        fmt::print("{}\n", to_json(record));
      }
      log.structures.push_back(std::move(record));
    }
  }
  console.clear_status();
  if (!command.json) {
    const Table table = structures_table(arrange(log));
    for (std::size_t group = 1; group <= std::max<std::size_t>(1, table.group_titles.size()); ++group)
      fmt::print("{}\n", to_terminal(table, group));
  }
  if (disagreements > 0) console.warning(fmt::format("structures disagree on {} rays", disagreements));
  return disagreements > 0 ? 1 : 0;
}

}  // namespace etendue
