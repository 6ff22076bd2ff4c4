// One function a key reads the values of an experiment's keys. Each throws Error at the value's place in the file.
#pragma once

#include "experiments/config/config.h"
#include "experiments/config/config_tree.h"

#include <filesystem>

namespace etendue {

// Files are looked for in `directory`, that of the experiment, then in the working directory.
std::vector<SceneChoice> read_scenes(const ConfigNode& node, const std::filesystem::path& directory);
// Throws where an experiment has none, or not as many files of references as scenes.
void require_scenes(const ExperimentConfig& config);
// A null `node` is a key that was left out: seed 1, and the reference chosen automatically.
std::vector<std::uint64_t> read_seeds(const ConfigNode* node);
ReferenceChoice read_reference(const ConfigNode* node, const std::filesystem::path& directory);
Budget read_budget(const ConfigNode& node);
ivec2 read_resolution(const ConfigNode& node);
std::optional<StructureTiming> read_structures(const ConfigNode& node);

}  // namespace etendue
