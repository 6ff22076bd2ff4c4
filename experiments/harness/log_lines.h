// The records of log.h out of the JSON objects they were written as. Their other direction, to_json_line, is declared beside
// each record. A missing key or one of the wrong type throws nlohmann::json::exception; keys that were
// added to the format later have defaults, so that older logs can still be read.
#pragma once

#include "experiments/harness/log.h"

#include <nlohmann/json_fwd.hpp>

namespace etendue {

ManifestRecord read_manifest(const nlohmann::ordered_json& json);
ReferenceRecord read_reference(const nlohmann::ordered_json& json);
StructureRecord read_structure(const nlohmann::ordered_json& json);
CheckpointRecord read_checkpoint(const nlohmann::ordered_json& json);
CellRecord read_cell(const nlohmann::ordered_json& json);
PlanRecord read_plan(const nlohmann::ordered_json& json);
SceneRecord read_scene_record(const nlohmann::ordered_json& json);

}  // namespace etendue
