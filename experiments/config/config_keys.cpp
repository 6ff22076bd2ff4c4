#include "experiments/config/config_keys.h"

#include "framework/io/load_scene.h"
#include "framework/io/whole_file.h"

#include <fmt/format.h>
#include <algorithm>

namespace etendue {

namespace {

namespace fs = std::filesystem;

// A file beside the experiment, or in the working directory; "": there is none.
std::string find_file(const fs::path& directory, const std::string& name) {
  for (const fs::path& candidate : {directory / name, fs::path(name)})
    if (is_file(candidate.string())) return candidate.string();
  return "";
}

SceneChoice read_scene(const ConfigNode& node, const fs::path& directory) {
  SceneChoice scene{read_text(node, "scenes", "names or paths in quotes"), {}, node.where};
  if (scene.name.starts_with(builtin_prefix)) {
    check_builtin(scene.name, scene.where);
    scene.path = scene.name;
  } else {
    scene.path = find_file(directory, scene.name);
  }
  if (!scene.path.empty()) return scene;
  throw Error(scene.where, fmt::format("no scene '{}'; expected a file beside the experiment or in the working directory, or "
                                       "builtin:NAME (`etendue list scenes`)",
                                       scene.name));
}

}  // namespace

std::vector<SceneChoice> read_scenes(const ConfigNode& node, const fs::path& directory) {
  std::vector<SceneChoice> scenes;
  for (const ConfigNode* element : list_elements(node, "scenes", "an array of scenes")) {
    SceneChoice scene = read_scene(*element, directory);
    for (const SceneChoice& other : scenes)
      if (other.name == scene.name) throw Error(scene.where, fmt::format("scene '{}' stands there twice", scene.name));
    scenes.push_back(std::move(scene));
  }
  return scenes;
}

void require_scenes(const ExperimentConfig& config) {
  if (config.scenes.empty()) throw Error(Location{config.path}, "no scenes; expected scenes = [\"builtin:cornell-box\", …]");
  const std::size_t files = config.reference.files.size();
  if (config.reference.kind == ReferenceChoice::Kind::file && files != config.scenes.size())
    throw Error(config.reference.where,
                fmt::format("reference: {} files for {} scenes; expected one a scene", files, config.scenes.size()));
}

std::vector<std::uint64_t> read_seeds(const ConfigNode* node) {
  if (!node) return {1};
  std::vector<std::uint64_t> seeds;
  if (node->array()) {
    for (const ConfigNode* element : list_elements(*node, "seeds", "how many, or an array of whole numbers")) {
      const auto seed = static_cast<std::uint64_t>(read_whole(*element, "seeds", 0, INT64_MAX));
      if (contains(seeds, seed)) throw Error(element->where, fmt::format("seed {} stands there twice", seed));
      seeds.push_back(seed);
    }
    return seeds;
  }
  const std::int64_t count = read_whole(*node, "seeds", 1, 1'000'000);
  for (std::int64_t seed = 1; seed <= count; ++seed) seeds.push_back(static_cast<std::uint64_t>(seed));
  return seeds;
}

Budget read_budget(const ConfigNode& node) {
  TableReader reader(node, "budget");
  Budget budget;
  reader.duration("time", budget.time_s);
  reader.whole("samples", budget.samples, 1, 4'000'000'000);
  reader.number("error", budget.error, 1e-12, 1e6);
  if (const auto* ladder = reader.find("checkpoints"))
    budget.checkpoints = read_parsed(*ladder, "budget.checkpoints", CheckpointLadder::parse);
  reader.finish();
  if (budget.time_s || budget.samples) return budget;
  if (budget.error)
    throw Error(find_key(node, "error")->where,
                "budget: an error that is never reached would run for ever; expected a time or samples beside it");
  throw Error(node.where, "budget: no limit; expected time, samples or error");
}

ReferenceChoice read_reference(const ConfigNode* node, const fs::path& directory) {
  using Kind = ReferenceChoice::Kind;
  if (!node) return {};
  if (const auto* text = node->text()) {
    if (*text == "auto") return {Kind::automatic, 0, {}, node->where};
    if (*text == "exact") return {Kind::exact, 0, {}, node->where};
    const std::vector<std::string> names{"auto", "exact"};
    throw Error(node->where, unknown_name("reference", *text, names) + "; or { samples = N } or { file = \"ref.exr\" }");
  }
  TableReader reader(*node, "reference", "\"auto\", \"exact\", { samples = N } or { file = \"ref.exr\" }");
  const auto* samples = reader.find("samples");
  const auto* file = reader.find("file");
  reader.finish();
  if ((samples != nullptr) == (file != nullptr)) throw Error(node->where, "reference: expected either samples or file");
  if (samples)
    return {Kind::samples,
            static_cast<std::uint64_t>(read_whole(*samples, "reference.samples", 16, 1'000'000'000)),
            {},
            samples->where};
  ReferenceChoice choice{Kind::file, 0, {}, file->where};
  for (const ConfigNode* element : list_elements(*file, "reference.file", "a file, or a list of them")) {
    const std::string name = read_text(*element, "reference.file"), path = find_file(directory, name);
    if (path.empty())
      throw Error(element->where,
                  fmt::format("reference: no file '{}' beside the experiment or in the working directory", name));
    choice.files.push_back(path);
  }
  return choice;
}

ivec2 read_resolution(const ConfigNode& node) {
  const auto* array = node.array();
  if (!array || array->size() != 2) wrong_type(node, "resolution", "[width, height]");
  return {static_cast<int>(read_whole((*array)[0], "resolution", 1, 16384)),
          static_cast<int>(read_whole((*array)[1], "resolution", 1, 16384))};
}

std::optional<StructureTiming> read_structures(const ConfigNode& node) {
  if (const auto* wanted = std::get_if<bool>(&node.value)) return *wanted ? std::optional(StructureTiming{}) : std::nullopt;
  TableReader reader(node, "structures", "true, false or { resolution = N, repetitions = N, … }");
  StructureTiming timing;
  reader.whole("resolution", timing.resolution, 8, 8192);
  reader.whole("repetitions", timing.repetitions, 1, 1000);
  reader.whole("check_rays", timing.check_rays, 0, 1'000'000'000'000);
  reader.duration("budget", timing.budget_s);
  std::vector<std::string> isas;
  reader.names("isa", isas, "instruction set", {std::begin(isa_options), std::end(isa_options)});
  for (const std::string& name : isas) timing.isas.push_back(isa_of_option(name));
  reader.finish();
  return timing;
}

}  // namespace etendue
