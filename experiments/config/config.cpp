#include "experiments/config/config.h"

#include "experiments/config/config_keys.h"
#include "experiments/kind.h"
#include "framework/image/metrics.h"

#include <fmt/format.h>
#include <xxhash.h>
#include <filesystem>

namespace etendue {

namespace {

namespace fs = std::filesystem;

// A hash of all that changes a result, and so must not change within one output directory.
std::string result_hash(const ConfigNode& root) {
  ConfigNode::Table table = *root.table();
  for (const char* key : {"title", "outputs", "quick", "threads", "predictions", "elsewhere"}) table.erase(key);
  for (const char* key : {"accels", "integrators"})
    if (const auto methods = table.find(key); methods != table.end()) erase_own_labels(methods->second);
  const std::string text = canonical_text({std::move(table), {}, {}});
  return fmt::format("{:016x}", XXH3_64bits(text.data(), text.size()));
}

// Keys that would change nothing here, and those of other kinds.
void refuse_keys(const ConfigNode& root, const ExperimentKind& kind) {
  const auto refuse = [&](const std::string& key) {
    if (const ConfigNode* found = find_key(root, key))
      throw Error(found->key_where, fmt::format("{}: of no use beside {}; expected only one of them", key, kind.beside()));
  };
  for (const std::string& key : kind.useless()) refuse(key);
  for (const ExperimentKind* other : experiment_kinds()) {
    if (other == &kind) continue;
    for (const std::string& key : other->keys()) refuse(key);
    for (const std::string& key : other->companions())
      if (const ConfigNode* found = find_key(root, key))
        throw Error(found->key_where, fmt::format("{}: of no use without {}", key, other->beside()));
  }
}

// Reads what any experiment may say. All other keys are read by kinds.
void read_common(const ConfigNode& root, const fs::path& directory, ExperimentConfig& config) {
  TableReader reader(root, "experiment");
  reader.text("title", config.title);
  if (const auto* n = reader.find("resolution")) config.resolution = read_resolution(*n);
  reader.whole("threads", config.threads, 1, 4096);
  if (const auto* n = reader.find("structures")) config.structures = read_structures(*n);
  std::vector<std::string> all_metrics;
  for (const Metric& metric : metrics()) {
    all_metrics.emplace_back(metric.name);
    if (!metric.on_request()) config.metrics.emplace_back(metric.name);
  }
  reader.names("metrics", config.metrics, "metric", all_metrics);
  reader.flag("confidence", config.confidence);
  config.table_formats = {"md", "csv", "tex"};
  if (const auto* n = reader.find("outputs")) {
    TableReader outputs(*n, "outputs");
    outputs.names("tables", config.table_formats, "format", {"md", "csv", "tex"});
    outputs.finish();
  }
  if (const auto* quick = reader.find("quick"); quick && !quick->table())
    wrong_type(*quick, "quick", "a table of keys to replace");
  const auto *scenes = reader.find("scenes"), *seeds = reader.find("seeds"), *budget = reader.find("budget"),
             *reference = reader.find("reference");
  for (const char* key : {"accels", "integrators", "regions", "predictions", "elsewhere"}) reader.find(key);
  for (const ExperimentKind* kind : experiment_kinds())
    for (const auto& keys : {kind->keys(), kind->companions()})
      for (const std::string& key : keys) reader.find(key);
  reader.finish();
  config.seeds = read_seeds(seeds);
  if (budget) config.budget = read_budget(*budget);
  config.reference = read_reference(reference, directory);
  config.accels = {default_accel()};
  if (scenes) config.scenes = read_scenes(*scenes, directory);
}

// `--quick`: an experiment made short enough to see that it works, by its own [quick] table, or else by a default for its kind
// (one seed, little time, a small image). A key is replaced as a whole, so that budget = { samples = 4 } leaves nothing of
// budget = { time = "60s" }.
void apply_quick(ConfigNode& root) {
  const ConfigNode* own = find_key(root, "quick");
  if (own == nullptr) {
    for (const std::string& assignment : kind_of(root).quick(root)) apply_override(root, assignment);
    return;
  }
  if (!own->table()) wrong_type(*own, "quick", "a table of keys to replace");
  const ConfigNode::Table replaced = *own->table();
  auto& table = std::get<ConfigNode::Table>(root.value);
  for (const auto& [key, value] : replaced) {
    if (key == "quick") throw Error(value.key_where, "quick: a [quick] inside [quick]; expected keys of the experiment");
    table.insert_or_assign(key, value);
  }
}

ExperimentConfig interpret(const ConfigNode& root, const std::string& path) {
  ExperimentConfig config;
  config.path = path;
  config.title = fs::path(path).stem().string();
  config.kind = &kind_of(root);
  read_common(root, fs::path(path).parent_path(), config);
  refuse_keys(root, *config.kind);
  config.kind->read(root, config);
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

ExperimentConfig load_config(const std::string& path, const ConfigOptions& options) {
  return parse_experiment(read_config_text(path), path, options);
}

ExperimentConfig parse_experiment(const std::string& text, const std::string& path, const ConfigOptions& options) {
  ExperimentConfig config = finish(parse_config(text, path), path, options);
  config.text = text;
  return config;
}

}  // namespace etendue
