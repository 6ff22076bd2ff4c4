#include "experiments/log/log_lines.h"

#include "experiments/log/json_line.h"

namespace etendue {

namespace {

Json finite_map(const std::map<std::string, double>& values) {
  Json json = Json::object();
  for (const auto& [key, value] : values) json[key] = finite(value);
  return json;
}

Json cell_json(const char* type, const CellName& cell) {
  return Json{
      {"type", type}, {"scene", cell.scene}, {"accel", cell.accel}, {"integrator", cell.integrator}, {"seed", cell.seed}};
}

CellName cell_name(const Json& json) {
  return {json.at("scene"), json.at("accel"), json.at("integrator"), json.at("seed").get<std::uint64_t>()};
}

// A figure that was measured stands under its key, its quartiles beside it; one that was not has no keys.
void put_measured(Json& json, const std::string& key, const Measured& measured) {
  if (measured.median == 0) return;
  json[key] = finite(measured.median);
  json[key + "_low"] = finite(measured.low);
  json[key + "_high"] = finite(measured.high);
}

Measured read_measured(const Json& j, const std::string& key) {
  const double median = j.value(key, 0.0);
  return {median, j.value(key + "_low", median), j.value(key + "_high", median)};
}

// Of a file that stands under `key`.
void put_stamp(Json& json, const std::string& key, const FileStamp& stamp) {
  if (stamp.hash.empty()) return;
  json[key + "_bytes"] = stamp.bytes;
  json[key + "_xxh3"] = stamp.hash;
}

FileStamp read_stamp(const Json& j, const std::string& key) {
  return {j.value(key + "_bytes", std::uint64_t{0}), j.value(key + "_xxh3", "")};
}

struct KindFigure {
  const char* suffix;
  ByRayKind<Measured> StructureRecord::*figures;
};
constexpr KindFigure kind_figures[] = {{"_mrays_per_s", &StructureRecord::mrays_per_s},
                                       {"_batched_mrays_per_s", &StructureRecord::batched_mrays_per_s},
                                       {"_to_embree", &StructureRecord::to_embree},
                                       {"_to_robust_embree", &StructureRecord::to_robust_embree},
                                       {"_batched_to_embree", &StructureRecord::batched_to_embree}};

}  // namespace

std::string to_json_line(const ManifestRecord& r) {
  Json json{{"type", "manifest"},     {"id", r.id},
            {"version", r.version},   {"commit", r.commit},
            {"compiler", r.compiler}, {"flags", r.flags},
            {"cpu", r.cpu},           {"threads", r.threads},
            {"title", r.title},       {"experiment_hash", r.experiment_hash}};
  if (!r.file.empty()) json["file"] = r.file;
  if (!r.options.empty()) json["options"] = r.options;
  if (!r.experiment.empty()) json["experiment"] = r.experiment;
  if (r.budget_s > 0) json["budget_s"] = finite(r.budget_s);
  return dump(json);
}

std::string to_json_line(const ReferenceRecord& r) {
  Json json{{"type", "reference"}, {"scene", r.scene},   {"scene_hash", r.scene_hash},
            {"source", r.source},  {"file", r.file},     {"mse_floor", finite(r.mse_floor)},
            {"width", r.width},    {"height", r.height}, {"checks", r.checks}};
  put_stamp(json, "file", r.stamp);
  if (!r.warnings.empty()) json["warnings"] = r.warnings;
  return dump(json);
}

std::string to_json_line(const PlanRecord& r) {
  Json json{{"type", "plan"},   {"experiment_hash", r.experiment_hash},
            {"shard", r.shard}, {"shards", r.shards},
            {"cells", r.cells}, {"all_cells", r.all_cells}};
  if (!r.filter.empty()) json["filter"] = r.filter;
  return dump(json);
}

std::string to_json_line(const SceneRecord& r) {
  return dump({{"type", "scene"}, {"scene", r.scene}, {"hash", r.hash}, {"file", r.file}});
}

const char* const finished_line = R"({"type":"finished"})";

std::string to_json_line(const StructureRecord& r) {
  Json json{{"type", "structure"},
            {"scene", r.scene},
            {"structure", r.structure},
            {"layout", r.layout},
            {"manifest", r.manifest},
            {"triangles", r.triangles},
            {"bytes", r.bytes},
            {"nodes", r.nodes},
            {"depth", r.depth},
            {"threads", r.threads},
            {"sah_cost", finite(r.sah_cost)},
            {"epo_cost", finite(r.epo_cost)},
            {"epo_triangles", r.epo_triangles},
            {"nodes_per_ray", finite(r.nodes_per_ray)},
            {"primitives_per_ray", finite(r.primitives_per_ray)},
            {"checked", r.checked},
            {"disagreements", r.disagreements}};
  if (!r.note.empty()) json["note"] = r.note;
  if (!r.fallback.empty()) json["fallback"] = r.fallback;
  put_measured(json, "build_s", r.build_s);
  put_measured(json, "parallel_build_s", r.parallel_build_s);
  for (const KindFigure& figure : kind_figures)
    for (const RayKind kind : ray_kinds)
      put_measured(json, std::string(ray_kind_name(kind)) + figure.suffix, (r.*figure.figures)[index_of(kind)]);
  return dump(json);
}

std::string to_json_line(const CheckpointRecord& r) {
  Json json = cell_json("checkpoint", r.cell);
  json["manifest"] = r.manifest;
  json["iterations"] = r.iterations;
  json["time_s"] = finite(r.time_s);
  json["cpu_s"] = finite(r.cpu_s);
  json["phases_s"] = finite_map(r.phases_s);
  json["metrics"] = finite_map(r.metrics);
  json["counters"] = r.counters;
  json["peak_memory_bytes"] = r.peak_memory_bytes;
  json["non_finite"] = r.non_finite;
  for (const auto& [name, metrics] : r.regions) json["regions"][name] = finite_map(metrics);
  if (!r.confidence.empty()) json["confidence"] = finite_map(r.confidence);
  return dump(json);
}

std::string to_json_line(const CellRecord& r) {
  Json json = cell_json("cell", r.cell);
  json["status"] = r.status;
  json["error"] = r.error;
  json["image"] = r.image;
  json["image_hash"] = r.image_hash;
  json["bias"] = r.bias;
  json["mse_exponent"] = finite(r.mse_exponent);
  json["bias_bound"] = finite(r.bias_bound);
  json["note"] = r.note;
  if (!r.fallback.empty()) json["fallback"] = r.fallback;
  put_stamp(json, "image", r.image_stamp);
  if (!r.strip.empty()) json["strip"] = r.strip;
  put_stamp(json, "strip", r.strip_stamp);
  if (r.checkpoints) json["checkpoints"] = *r.checkpoints;
  if (!r.non_finite_at.empty()) json["non_finite_at"] = r.non_finite_at;
  return dump(json);
}

ManifestRecord read_manifest(const Json& j) {
  ManifestRecord r{j.at("id"),  j.at("version"), j.at("commit"),          j.at("compiler"), j.at("flags"),
                   j.at("cpu"), j.at("title"),   j.at("experiment_hash"), j.at("threads")};
  // Older logs do not have these.
  r.file = j.value("file", "");
  r.options = j.value("options", "");
  r.experiment = j.value("experiment", "");
  r.budget_s = j.value("budget_s", 0.0);
  return r;
}

ReferenceRecord read_reference(const Json& j) {
  return {j.at("scene"),         j.at("scene_hash"),
          j.at("source"),        j.at("file"),
          j.at("checks"),        j.at("mse_floor"),
          j.at("width"),         j.at("height"),
          read_stamp(j, "file"), j.value("warnings", std::vector<std::string>{})};
}

PlanRecord read_plan(const Json& j) {
  return {j.at("experiment_hash"), j.value("filter", ""), j.at("shard"), j.at("shards"), j.at("cells"), j.at("all_cells")};
}

SceneRecord read_scene_record(const Json& j) { return {j.at("scene"), j.at("hash"), j.at("file")}; }

StructureRecord read_structure(const Json& j) {
  StructureRecord r;
  r.scene = j.at("scene");
  r.structure = j.at("structure");
  r.layout = j.at("layout");
  r.manifest = j.at("manifest");
  r.note = j.value("note", "");
  r.fallback = j.value("fallback", "");
  r.triangles = j.at("triangles");
  r.bytes = j.at("bytes");
  r.nodes = j.at("nodes");
  r.depth = j.at("depth");
  r.checked = j.value("checked", std::uint64_t{0});
  r.disagreements = j.at("disagreements");
  r.threads = j.value("threads", 1);
  r.build_s = read_measured(j, "build_s");
  r.parallel_build_s = read_measured(j, "parallel_build_s");
  r.sah_cost = j.at("sah_cost");
  r.epo_cost = j.value("epo_cost", 0.0);
  r.epo_triangles = j.value("epo_triangles", std::uint64_t{0});
  r.nodes_per_ray = j.at("nodes_per_ray");
  r.primitives_per_ray = j.at("primitives_per_ray");
  for (const KindFigure& figure : kind_figures)
    for (const RayKind kind : ray_kinds)
      (r.*figure.figures)[index_of(kind)] = read_measured(j, std::string(ray_kind_name(kind)) + figure.suffix);
  return r;
}

CheckpointRecord read_checkpoint(const Json& j) {
  CheckpointRecord r;
  r.cell = cell_name(j);
  r.manifest = j.at("manifest");
  r.iterations = j.at("iterations");
  r.time_s = j.at("time_s");
  r.cpu_s = j.at("cpu_s");
  r.phases_s = j.at("phases_s").get<std::map<std::string, double>>();
  r.metrics = j.at("metrics").get<std::map<std::string, double>>();
  r.counters = j.at("counters").get<std::map<std::string, std::uint64_t>>();
  r.peak_memory_bytes = j.at("peak_memory_bytes");
  r.non_finite = j.at("non_finite");
  if (const auto confidence = j.find("confidence"); confidence != j.end())
    r.confidence = confidence->get<std::map<std::string, double>>();
  if (const auto regions = j.find("regions"); regions != j.end())
    for (const auto& [name, metrics] : regions->items()) r.regions[name] = metrics.get<std::map<std::string, double>>();
  return r;
}

CellRecord read_cell(const Json& j) {
  CellRecord r;
  r.cell = cell_name(j);
  r.status = j.at("status");
  r.error = j.at("error");
  r.image = j.at("image");
  r.image_hash = j.at("image_hash");
  r.bias = j.at("bias");
  r.mse_exponent = j.at("mse_exponent");
  r.bias_bound = j.value("bias_bound", 0.0);
  r.note = j.at("note");
  r.fallback = j.value("fallback", "");
  r.strip = j.value("strip", "");
  r.image_stamp = read_stamp(j, "image");
  r.strip_stamp = read_stamp(j, "strip");
  if (const auto count = j.find("checkpoints"); count != j.end()) r.checkpoints = count->get<std::uint64_t>();
  r.non_finite_at = j.value("non_finite_at", r.non_finite_at);
  return r;
}

}  // namespace etendue
