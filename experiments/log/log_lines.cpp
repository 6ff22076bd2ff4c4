#include "experiments/log/log_lines.h"

#include "experiments/log/fields.h"

namespace etendue {

namespace {

constexpr const char* quantities[] = {"exponent", "ratio"};
constexpr const char* models[] = {"power", "plateau"};
constexpr const char* points[] = {"checkpoints", "configurations"};

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

void list_fields(auto& f, FieldsOf<ManifestRecord> auto& r) {
  f("id", r.id);
  f("version", r.version);
  f("commit", r.commit);
  f("compiler", r.compiler);
  f("flags", r.flags);
  f("cpu", r.cpu);
  f("threads", r.threads);
  f("title", r.title);
  f("experiment_hash", r.experiment_hash);
  f.maybe("file", r.file);
  f.maybe("options", r.options);
  f.maybe("experiment", r.experiment);
  f.maybe("budget_s", r.budget_s);
  f.maybe("cpu_vendor", r.cpu_vendor);
  f.maybe("cpu_family", r.cpu_family);
  f.maybe("cpu_model", r.cpu_model);
  f.maybe("cpu_stepping", r.cpu_stepping);
  f.maybe("isa", r.isa);
  f.maybe("cores", r.cores);
  f.maybe("memory_bytes", r.memory_bytes);
  f.maybe("date", r.date);
}

void list_fields(auto& f, FieldsOf<PlanRecord> auto& r) {
  f("experiment_hash", r.experiment_hash);
  f("shard", r.shard);
  f("shards", r.shards);
  f("cells", r.cells);
  f("all_cells", r.all_cells);
  f.maybe("filter", r.filter);
}

void list_fields(auto& f, FieldsOf<SceneRecord> auto& r) {
  f("scene", r.scene);
  f("hash", r.hash);
  f("file", r.file);
}

void list_fields(auto& f, FieldsOf<ReferenceRecord> auto& r) {
  f("scene", r.scene);
  f("scene_hash", r.scene_hash);
  f("source", r.source);
  f("file", r.file);
  f("mse_floor", r.mse_floor);
  f("width", r.width);
  f("height", r.height);
  f("checks", r.checks);
  f.stamp("file", r.stamp);
  f.maybe("warnings", r.warnings);
}

void list_fields(auto& f, FieldsOf<StructureRecord> auto& r) {
  f("scene", r.scene);
  f("structure", r.structure);
  f("layout", r.layout);
  f("manifest", r.manifest);
  f("triangles", r.triangles);
  f("bytes", r.bytes);
  f("nodes", r.nodes);
  f("depth", r.depth);
  f.later("threads", r.threads, 1);
  f("sah_cost", r.sah_cost);
  f.later("epo_cost", r.epo_cost, 0.0);
  f.later("epo_triangles", r.epo_triangles, std::uint64_t{0});
  f("nodes_per_ray", r.nodes_per_ray);
  f("primitives_per_ray", r.primitives_per_ray);
  f.later("checked", r.checked, std::uint64_t{0});
  f("disagreements", r.disagreements);
  f.maybe("note", r.note);
  f.maybe("fallback", r.fallback);
  f.measured("build_s", r.build_s);
  f.measured("parallel_build_s", r.parallel_build_s);
  for (const KindFigure& figure : kind_figures)
    for (const RayKind kind : ray_kinds)
      f.measured(std::string(ray_kind_name(kind)) + figure.suffix, (r.*figure.figures)[index_of(kind)]);
}

void list_fields(auto& f, FieldsOf<CheckpointRecord> auto& r) {
  f.cell(r.cell);
  f("manifest", r.manifest);
  f("iterations", r.iterations);
  f("time_s", r.time_s);
  f("cpu_s", r.cpu_s);
  f("phases_s", r.phases_s);
  f("metrics", r.metrics);
  f("counters", r.counters);
  f("peak_memory_bytes", r.peak_memory_bytes);
  f("non_finite", r.non_finite);
  f.maybe("regions", r.regions);
  f.maybe("confidence", r.confidence);
}

void list_fields(auto& f, FieldsOf<CellRecord> auto& r) {
  f.cell(r.cell);
  f("status", r.status);
  f("error", r.error);
  f("image", r.image);
  f("image_hash", r.image_hash);
  f("bias", r.bias);
  f("mse_exponent", r.mse_exponent);
  f.later("bias_bound", r.bias_bound, 0.0);
  f("note", r.note);
  f.maybe("fallback", r.fallback);
  f.stamp("image", r.image_stamp);
  f.maybe("strip", r.strip);
  f.stamp("strip", r.strip_stamp);
  f.maybe("checkpoints", r.checkpoints);
  f.maybe("non_finite_at", r.non_finite_at);
}

void list_fields(auto& f, FieldsOf<ProductsRecord> auto& r) {
  f("scene", r.scene);
  f("accel", r.accel);
  f("integrator", r.integrator);
  f.maybe("region", r.region);
  f.maybe("at_checkpoints", r.at_checkpoints);
  f("images", r.images);
  f("seeds", r.seeds);
  f("products", r.products);
}

void list_fields(auto& f, FieldsOf<Expected> auto& r) {
  f.end("low", r.low, -endless);
  f.end("high", r.high, endless);
  f.maybe("text", r.text);
}

void list_fields(auto& f, FieldsOf<Prediction> auto& r) {
  f.choice("quantity", r.quantity, quantities);
  f("method", r.method);
  f.maybe("over", r.over);
  f("scene", r.scene);
  f("region", r.region);
  f.maybe("expected", r.expected);
  f("source", r.source);
  if (r.is_ratio()) return;
  f("metric", r.metric);
  f("x", r.x);
  f.choice("points", r.across, points);
  f("from", r.from);
  f("to", r.to);
  f.choice("model", r.model, models);
}

void list_fields(auto& f, FieldsOf<RegionChoice> auto& r) {
  f("name", r.name);
  f("scene", r.scene);
  f("polygon", r.polygon);
}

void list_fields(auto& f, FieldsOf<StatedRecord> auto& r) {
  f("predictions", r.predictions);
  f("regions", r.regions);
}

std::string to_json_line(const ManifestRecord& r) { return line_of("manifest", r); }
std::string to_json_line(const PlanRecord& r) { return line_of("plan", r); }
std::string to_json_line(const SceneRecord& r) { return line_of("scene", r); }
std::string to_json_line(const ReferenceRecord& r) { return line_of("reference", r); }
std::string to_json_line(const StructureRecord& r) { return line_of("structure", r); }
std::string to_json_line(const CheckpointRecord& r) { return line_of("checkpoint", r); }
std::string to_json_line(const CellRecord& r) { return line_of("cell", r); }
std::string to_json_line(const ProductsRecord& r) { return line_of("products", r); }
std::string to_json_line(const StatedRecord& r) { return line_of("predictions", r); }
std::string finished_line(double took_s) {
  Json json{{"type", "finished"}};
  if (took_s > 0) json["took_s"] = finite(took_s);
  return dump(json);
}

ManifestRecord read_manifest(const Json& json) { return read_value<ManifestRecord>(json); }
PlanRecord read_plan(const Json& json) { return read_value<PlanRecord>(json); }
SceneRecord read_scene_record(const Json& json) { return read_value<SceneRecord>(json); }
ReferenceRecord read_reference(const Json& json) { return read_value<ReferenceRecord>(json); }
StructureRecord read_structure(const Json& json) { return read_value<StructureRecord>(json); }
CheckpointRecord read_checkpoint(const Json& json) { return read_value<CheckpointRecord>(json); }
CellRecord read_cell(const Json& json) { return read_value<CellRecord>(json); }
ProductsRecord read_products(const Json& json) { return read_value<ProductsRecord>(json); }
StatedRecord read_stated(const Json& json) { return read_value<StatedRecord>(json); }

}  // namespace etendue
