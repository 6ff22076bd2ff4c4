// The records of log.h out of the JSON objects they were written as. Their other direction, to_json_line, is declared there. A
// missing key or one of the wrong type throws nlohmann::json::exception; keys that were added to the format later have
// defaults, so that older logs can still be read.
#pragma once

#include "experiments/log/json_fwd.h"
#include "experiments/log/log.h"

namespace etendue {

ManifestRecord read_manifest(const Json& json);
ReferenceRecord read_reference(const Json& json);
StructureRecord read_structure(const Json& json);
CheckpointRecord read_checkpoint(const Json& json);
CellRecord read_cell(const Json& json);
ProductsRecord read_products(const Json& json);
PlanRecord read_plan(const Json& json);
SceneRecord read_scene_record(const Json& json);
StatedRecord read_stated(const Json& json);

}  // namespace etendue
