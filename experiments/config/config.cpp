#include "experiments/config/config.h"

#include "experiments/config/config_keys.h"
#include "experiments/config/config_quick.h"
#include "experiments/kind.h"
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
  for (const char* key : {"title", "outputs", "quick", "threads", "predictions"}) table.erase(key);
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

void refuse_unknown_keys(const ConfigNode& root) {
  refuse_old_key(root, "rates", "[[predictions]] with expect = { exponent = … }");
  refuse_old_key(root, "ratios", "[[predictions]] with over, and expect = { ratio = … }");
  TableReader reader(root, "experiment");
  for (const char* key : {"title", "scenes", "accels", "integrators", "seeds", "budget", "reference", "metrics", "confidence",
                          "resolution", "threads", "structures", "regions", "predictions", "outputs", "quick"})
    reader.find(key);
  for (const ExperimentKind* kind : experiment_kinds())
    for (const auto& keys : {kind->keys(), kind->companions()})
      for (const std::string& key : keys) reader.find(key);
  reader.finish();
}

// What any experiment may say.
void read_common(const ConfigNode& root, const fs::path& directory, ExperimentConfig& config) {
  const auto find = [&](const char* key) { return find_key(root, key); };
  if (const auto* n = find("title")) config.title = read_text(*n, "title");
  if (const auto* n = find("resolution")) config.resolution = read_resolution(*n);
  if (const auto* n = find("threads")) config.threads = static_cast<int>(read_whole(*n, "threads", 1, 4096));
  if (const auto* n = find("structures")) config.structures = read_structures(*n);
  std::vector<std::string> all_metrics;
  for (const Metric& metric : metrics()) all_metrics.emplace_back(metric.name);
  const auto* wanted = find("metrics");
  config.metrics = wanted ? read_names(*wanted, "metrics", "metric", all_metrics) : all_metrics;
  if (const auto* n = find("confidence")) config.confidence = read_flag(*n, "confidence");
  config.table_formats = {"md", "csv", "tex"};
  if (const auto* outputs = find("outputs")) {
    TableReader reader(*outputs, "outputs");
    if (const auto* n = reader.find("tables"))
      config.table_formats = read_names(*n, "outputs.tables", "format", {"md", "csv", "tex"});
    reader.finish();
  }
  if (const auto* quick = find("quick"); quick && !quick->table()) wrong_type(*quick, "quick", "a table of keys to replace");
  refuse_unknown_keys(root);
  config.seeds = read_seeds(find("seeds"));
  if (const auto* n = find("budget")) config.budget = read_budget(*n);
  config.reference = read_reference(find("reference"), directory);
  config.accels = {default_accel()};
  if (const auto* n = find("scenes")) config.scenes = read_scenes(*n, directory);
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
