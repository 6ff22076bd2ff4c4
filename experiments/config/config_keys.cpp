#include "experiments/config/config_keys.h"

#include "framework/io/load_scene.h"
#include "framework/io/whole_file.h"

#include <fmt/format.h>
#include <algorithm>

namespace etendue {

namespace {

namespace fs = std::filesystem;

SceneChoice read_scene(const ConfigNode& node, const fs::path& directory) {
  SceneChoice scene{read_text(node, "scenes", "names or paths in quotes"), {}, node.where};
  if (scene.name.starts_with(builtin_prefix)) {
    check_builtin(scene.name, scene.where);
    scene.path = scene.name;
    return scene;
  }
  for (const fs::path& candidate : {directory / scene.name, fs::path(scene.name)}) {
    if (!is_file(candidate.string())) continue;
    scene.path = candidate.string();
    return scene;
  }
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
}

std::vector<std::uint64_t> read_seeds(const ConfigNode* node) {
  if (!node) return {1};
  std::vector<std::uint64_t> seeds;
  if (node->array()) {
    for (const ConfigNode* element : list_elements(*node, "seeds", "how many, or an array of whole numbers")) {
      const auto seed = static_cast<std::uint64_t>(read_whole(*element, "seeds", 0, INT64_MAX));
      if (std::find(seeds.begin(), seeds.end(), seed) != seeds.end())
        throw Error(element->where, fmt::format("seed {} stands there twice", seed));
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
  if (const auto* time = reader.find("time")) budget.time_s = read_duration(*time, "budget.time");
  if (const auto* samples = reader.find("samples"))
    budget.samples = static_cast<std::uint64_t>(read_whole(*samples, "budget.samples", 1, 4'000'000'000));
  const auto* error = reader.find("error");
  if (error) budget.error = read_number(*error, "budget.error", 1e-12, 1e6);
  if (const auto* ladder = reader.find("checkpoints")) {
    try {
      budget.checkpoints = CheckpointLadder::parse(read_text(*ladder, "budget.checkpoints"));
    } catch (const Error& e) {
      throw Error(ladder->where, std::string("budget: ") + e.what());
    }
  }
  reader.finish();
  if (!budget.time_s && !budget.samples)
    throw Error((error ? *error : node).where, error ? "budget: an error that is never reached would run for ever; expected a "
                                                       "time or samples beside it"
                                                     : "budget: no limit; expected time, samples or error");
  return budget;
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
  if (!node->table()) wrong_type(*node, "reference", "\"auto\", \"exact\", { samples = N } or { file = \"ref.exr\" }");
  TableReader reader(*node, "reference");
  const auto* samples = reader.find("samples");
  const auto* file = reader.find("file");
  reader.finish();
  if ((samples != nullptr) == (file != nullptr)) throw Error(node->where, "reference: expected either samples or file");
  if (samples)
    return {Kind::samples,
            static_cast<std::uint64_t>(read_whole(*samples, "reference.samples", 16, 1'000'000'000)),
            {},
            samples->where};
  const std::string name = read_text(*file, "reference.file");
  for (const fs::path& candidate : {directory / name, fs::path(name)})
    if (is_file(candidate.string())) return {Kind::file, 0, candidate.string(), file->where};
  throw Error(file->where, fmt::format("reference: no file '{}' beside the experiment or in the working directory", name));
}

bool read_flag(const ConfigNode& node, const std::string& key) {
  const auto* flag = std::get_if<bool>(&node.value);
  if (!flag) wrong_type(node, key, "true or false");
  return *flag;
}

std::vector<std::string> read_names(const ConfigNode& node, const std::string& key, const std::string& kind,
                                    const std::vector<std::string>& valid) {
  std::vector<std::string> names;
  for (const ConfigNode* element : list_elements(node, key, "an array of names")) {
    const std::string name = read_text(*element, key);
    if (std::find(valid.begin(), valid.end(), name) == valid.end())
      throw Error(element->where, key + ": " + unknown_name(kind, name, valid));
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

ivec2 read_resolution(const ConfigNode& node) {
  const auto* array = node.array();
  if (!array || array->size() != 2) wrong_type(node, "resolution", "[width, height]");
  return {static_cast<int>(read_whole((*array)[0], "resolution", 1, 16384)),
          static_cast<int>(read_whole((*array)[1], "resolution", 1, 16384))};
}

std::optional<StructureTiming> read_structures(const ConfigNode& node) {
  if (const auto* wanted = std::get_if<bool>(&node.value)) return *wanted ? std::optional(StructureTiming{}) : std::nullopt;
  if (!node.table()) wrong_type(node, "structures", "true, false or { resolution = N, repetitions = N, … }");
  TableReader reader(node, "structures");
  StructureTiming timing;
  if (const auto* n = reader.find("resolution"))
    timing.resolution = static_cast<int>(read_whole(*n, "structures.resolution", 8, 8192));
  if (const auto* n = reader.find("repetitions"))
    timing.repetitions = static_cast<int>(read_whole(*n, "structures.repetitions", 1, 1000));
  if (const auto* n = reader.find("check_rays"))
    timing.check_rays = static_cast<std::uint64_t>(read_whole(*n, "structures.check_rays", 0, 1'000'000'000'000));
  if (const auto* n = reader.find("budget")) timing.budget_s = read_duration(*n, "structures.budget");
  if (const auto* n = reader.find("isa"))
    for (const std::string& name :
         read_names(*n, "structures.isa", "instruction set", {std::begin(isa_options), std::end(isa_options)}))
      timing.isas.push_back(isa_of_option(name));
  reader.finish();
  return timing;
}

}  // namespace etendue
