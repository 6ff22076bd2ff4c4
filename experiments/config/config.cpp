#include "experiments/config/config.h"

#include "experiments/config/config_keys.h"
#include "experiments/config/config_quick.h"
#include "framework/image/metrics.h"

#include <fmt/format.h>
#include <xxhash.h>
#include <filesystem>

namespace etendue {

namespace {

namespace fs = std::filesystem;

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
  // All of the file must be valid, whichever half of it this run uses: a mistake in [quick] must not go unnoticed until
  // --quick. Overrides may correct a file (a structure this build lacks), so with them only the result is checked.
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
  return parse_experiment(read_config_text(path), path, options);
}

ExperimentConfig parse_experiment(const std::string& text, const std::string& path, const ConfigOptions& options) {
  ExperimentConfig config = finish(parse_config(text, path), path, options);
  config.text = text;
  return config;
}

}  // namespace etendue
