#include "experiments/harness/config.h"

#include "experiments/harness/config_tree.h"
#include "framework/image/metrics.h"
#include "framework/io/load_scene.h"

#include <fmt/format.h>
#include <xxhash.h>
#include <algorithm>
#include <filesystem>
#include <span>

namespace etendue {

namespace {

namespace fs = std::filesystem;

// What `--quick` means where an experiment has no [quick] table of its own.
constexpr const char* default_dynamic_quick[] = {"seeds=1", "dynamic.frames=10", "dynamic.resolution=32",
                                                 "dynamic.repetitions=1"};
constexpr const char* default_points_quick[] = {"points.counts=[10, 1000, 10000]", "points.queries=200",
                                                "points.repetitions=3"};
constexpr const char* default_balls_quick[] = {"balls.counts=[10, 100, 1000]", "balls.queries=200", "balls.repetitions=3"};
constexpr std::string_view default_claims_quick = "timing = { resolution = 32, repetitions = 3, large = false }\n";
constexpr std::string_view default_stress_quick = "seeds = 1\nresolution = [32, 32]\n";
constexpr std::string_view default_quick = "seeds = 1\nbudget = { time = \"0.3s\" }\nresolution = [64, 64]\n";

SceneChoice read_scene(const ConfigNode& node, const fs::path& directory) {
  SceneChoice scene{read_text(node, "scenes", "names or paths in quotes"), {}, node.where};
  if (scene.name.starts_with(builtin_prefix)) {
    check_builtin(scene.name, scene.where);
    scene.path = scene.name;
    return scene;
  }
  for (const fs::path& candidate : {directory / scene.name, fs::path(scene.name)}) {
    if (!fs::is_regular_file(candidate)) continue;
    scene.path = candidate.string();
    return scene;
  }
  throw Error(scene.where, fmt::format("no scene '{}'; expected a file beside the experiment or in the working directory, or "
                                       "builtin:NAME (`etendue list scenes`)",
                                       scene.name));
}

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
    if (fs::is_regular_file(candidate)) return {Kind::file, 0, candidate.string(), file->where};
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
  reader.finish();
  return timing;
}

// Puts [quick]'s keys in the place of the experiment's own; whole keys, so that { samples } replaces { time }.
void apply_quick(ConfigNode& root) {
  auto& table = std::get<ConfigNode::Table>(root.value);
  const auto own = table.find("quick");
  const auto shortened = [&](const char* key, std::span<const char* const> assignments) {
    const auto found = table.find(key);
    if (own != table.end() || found == table.end() || !found->second.table()) return false;
    for (const char* assignment : assignments) apply_override(root, assignment);
    return true;
  };
  if (shortened("dynamic", default_dynamic_quick) || shortened("points", default_points_quick) ||
      shortened("balls", default_balls_quick))
    return;
  const std::string_view usual = table.contains("claims")   ? default_claims_quick
                                 : table.contains("stress") ? default_stress_quick
                                                            : default_quick;
  ConfigNode quick = own == table.end() ? parse_config(usual, "--quick") : own->second;
  if (const auto timing = table.find("structures");
      own == table.end() && timing != table.end() && read_structures(timing->second))
    apply_override(quick, "structures={ resolution = 64, repetitions = 1 }");
  if (!quick.table()) wrong_type(quick, "quick", "a table of keys to replace");
  for (const auto& [key, value] : *quick.table()) {
    if (key == "quick") throw Error(value.key_where, "quick: a [quick] inside [quick]; expected keys of the experiment");
    table.insert_or_assign(key, value);
  }
}

// What changes a result, and so must not change within one output directory.
std::string result_hash(const ConfigNode& root) {
  ConfigNode::Table table = *root.table();
  for (const char* key : {"title", "outputs", "quick", "threads", "rates", "ratios"}) table.erase(key);
  const std::string text = canonical_text({std::move(table), {}, {}});
  return fmt::format("{:016x}", XXH3_64bits(text.data(), text.size()));
}

// An experiment on change over time, or on claims, has no matrix to render: such keys would change nothing.
void refuse_keys(const ConfigNode& root, const char* beside, std::initializer_list<const char*> keys) {
  const ConfigNode::Table& table = *root.table();
  for (const char* key : keys)
    if (const auto found = table.find(key); found != table.end())
      throw Error(found->second.key_where, fmt::format("{}: of no use beside {}; expected only one of them", key, beside));
}

// The keys that say which kind of experiment it is; null where absent.
struct ExperimentKeys {
  const ConfigNode *scenes, *accels, *methods, *budget, *dynamic, *points, *balls, *claims, *timing, *regions, *rates, *ratios,
      *stress;
};

// What any experiment may say; of the other keys, where they stand.
ExperimentKeys read_keys(const ConfigNode& root, const fs::path& directory, ExperimentConfig& config) {
  TableReader reader(root, "experiment");
  const auto* seeds = reader.find("seeds");
  const auto* reference = reader.find("reference");
  if (const auto* n = reader.find("title")) config.title = read_text(*n, "title");
  if (const auto* n = reader.find("resolution")) config.resolution = read_resolution(*n);
  if (const auto* n = reader.find("threads")) config.threads = static_cast<int>(read_whole(*n, "threads", 1, 4096));
  if (const auto* n = reader.find("structures")) config.structures = read_structures(*n);
  std::vector<std::string> all_metrics;
  for (const Metric& metric : metrics()) all_metrics.emplace_back(metric.name);
  const auto* wanted = reader.find("metrics");
  config.metrics = wanted ? read_names(*wanted, "metrics", "metric", all_metrics) : all_metrics;
  if (const auto* n = reader.find("confidence")) config.confidence = read_flag(*n, "confidence");
  config.table_formats = {"md", "csv", "tex"};
  if (const auto* outputs = reader.find("outputs")) {
    TableReader output_reader(*outputs, "outputs");
    if (const auto* n = output_reader.find("tables"))
      config.table_formats = read_names(*n, "outputs.tables", "format", {"md", "csv", "tex"});
    output_reader.finish();
  }
  if (const auto* quick = reader.find("quick"); quick && !quick->table())
    wrong_type(*quick, "quick", "a table of keys to replace");
  const ExperimentKeys keys{reader.find("scenes"),  reader.find("accels"),  reader.find("integrators"), reader.find("budget"),
                            reader.find("dynamic"), reader.find("points"),  reader.find("balls"),       reader.find("claims"),
                            reader.find("timing"),  reader.find("regions"), reader.find("rates"),       reader.find("ratios"),
                            reader.find("stress")};
  reader.finish();
  config.seeds = read_seeds(seeds);
  if (keys.budget) config.budget = read_budget(*keys.budget);
  config.reference = read_reference(reference, directory);
  return keys;
}

void interpret_claims(const ConfigNode& root, const ExperimentKeys& keys, ExperimentConfig& config) {
  refuse_keys(root, "[[claims]], which name what they measure",
              {"scenes", "accels", "integrators", "seeds", "structures", "dynamic", "budget", "reference", "metrics",
               "confidence", "resolution", "regions", "rates", "ratios", "points", "balls"});
  config.claims = read_claims(*keys.claims, keys.timing);
}

void interpret_stress(const ConfigNode& root, const ExperimentKeys& keys, ExperimentConfig& config) {
  refuse_keys(root, "[[stress]], which names scenes and methods",
              {"scenes", "accels", "integrators", "structures", "dynamic", "reference", "metrics", "confidence", "timing",
               "regions", "rates", "ratios", "points", "balls"});
  config.stress = read_stress(*keys.stress);
  if (!config.budget.samples || config.budget.time_s || config.budget.error)
    throw Error(keys.stress->key_where, "stress: expected budget = { samples = N } beside it, and no other limit");
}

void interpret_search(const ConfigNode& root, const ExperimentKeys& keys, const fs::path& directory, ExperimentConfig& config) {
  const std::string beside = keys.points ? "[points]" : "[balls]";
  refuse_keys(root, (beside + ", which renders nothing").c_str(),
              {"integrators", "accels", "structures", "dynamic", "budget", "reference", "metrics", "confidence", "resolution",
               "threads", "regions", "rates", "ratios"});
  if (keys.points) refuse_keys(root, "[points]", {"balls"});
  config.search = read_search(keys.points ? *keys.points : *keys.balls, keys.balls != nullptr);
  if (keys.scenes) config.scenes = read_scenes(*keys.scenes, directory);
  if (config_sets(config).empty())
    throw Error(Location{config.path}, fmt::format("nothing to search; expected scenes = [\"builtin:cornell-box\", …]{}",
                                                   keys.points ? " or points.contrasts" : ""));
}

// Scenes by structures by methods; or scenes that move.
void interpret_matrix(const ExperimentKeys& keys, const fs::path& directory, ExperimentConfig& config) {
  const Location where{config.path};
  if (keys.methods) config.integrators = read_integrators(*keys.methods);
  if (!keys.scenes) throw Error(where, "no scenes; expected scenes = [\"builtin:cornell-box\", …]");
  config.scenes = read_scenes(*keys.scenes, directory);
  std::vector<std::string> scene_names;
  for (const SceneChoice& scene : config.scenes) scene_names.push_back(scene.name);
  if (keys.regions) config.regions = read_regions(*keys.regions, scene_names);
  const RateContext context{scene_names, config.integrators, config.regions, config.metrics};
  if (keys.rates) config.rates = read_rates(*keys.rates, context);
  if (keys.ratios) config.ratios = read_ratios(*keys.ratios, context);
  if (!keys.methods && !config.structures && !keys.dynamic)
    throw Error(where, "no integrators; expected [[integrators]] tables (or structures = true, or [dynamic])");
  if (keys.methods && !keys.budget) throw Error(where, "no budget; expected budget = { time = \"60s\" } or { samples = 256 }");
  if (config.reference.kind == ReferenceChoice::Kind::file && config.scenes.size() > 1)
    throw Error(config.reference.where,
                fmt::format("reference: one file for {} scenes; expected one scene", config.scenes.size()));
}

ExperimentConfig interpret(const ConfigNode& root, const std::string& path) {
  const fs::path directory = fs::path(path).parent_path();
  ExperimentConfig config;
  config.path = path;
  config.title = fs::path(path).stem().string();
  const ExperimentKeys keys = read_keys(root, directory, config);
  if (keys.dynamic) {
    refuse_keys(root, "[dynamic], which renders nothing",
                {"integrators", "structures", "budget", "reference", "metrics", "confidence", "resolution", "regions", "rates",
                 "ratios"});
    config.animation = read_animation(*keys.dynamic);
    config.accels = read_builders(keys.accels);
  } else {
    config.accels = keys.accels ? read_accels(*keys.accels) : std::vector<Method>{default_accel()};
  }
  if (keys.timing && !keys.claims && !keys.stress) throw Error(keys.timing->key_where, "timing: of no use without [[claims]]");
  if (keys.claims)
    interpret_claims(root, keys, config);
  else if (keys.stress)
    interpret_stress(root, keys, config);
  else if (keys.points || keys.balls)
    interpret_search(root, keys, directory, config);
  else
    interpret_matrix(keys, directory, config);
  config.hash = result_hash(root);
  return config;
}

ExperimentConfig finish(ConfigNode root, const std::string& path, const ConfigOptions& options) {
  ConfigNode quick = root;
  apply_quick(quick);
  // All of the file must be valid, whichever half of it this run uses: a slip in [quick] shall not wait for --quick. Overrides
  // may mend what is wrong with a file (a structure this build lacks), so that then only the outcome counts.
  if (options.overrides.empty()) {
    ExperimentConfig config = interpret(root, path);
    ExperimentConfig quick_config = interpret(quick, path);
    return options.quick ? quick_config : config;
  }
  ConfigNode& chosen = options.quick ? quick : root;
  for (const std::string& assignment : options.overrides) {
    if (assignment.starts_with("quick"))
      throw Error(Location{"-o " + assignment},
                  "overrides come after [quick]; expected the key itself, such as budget.time=5s");
    apply_override(chosen, assignment);
  }
  return interpret(chosen, path);
}

}  // namespace

std::vector<SearchSet> config_sets(const ExperimentConfig& config) {
  std::vector<std::string> names;
  for (const SceneChoice& scene : config.scenes) names.push_back(scene.name);
  return config.search ? search_sets(*config.search, names) : std::vector<SearchSet>{};
}

ExperimentConfig load_config(const std::string& path, const ConfigOptions& options) {
  return finish(read_config_file(path), path, options);
}

ExperimentConfig parse_experiment(const std::string& text, const std::string& path, const ConfigOptions& options) {
  return finish(parse_config(text, path), path, options);
}

}  // namespace etendue
