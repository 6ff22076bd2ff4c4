// The fields of the records of log.h, and their lines.
#include "experiments/log/field_list.h"
#include "experiments/log/fields.h"
#include "experiments/log/log.h"

namespace etendue {

namespace {

constexpr const char* quantities[] = {"exponent", "ratio", "bias"};
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
  FIELDS(id, version, commit, compiler, flags, cpu, threads, title, experiment_hash);
  MAYBE_FIELDS(file, options, experiment, budget_s, cpu_vendor, cpu_family, cpu_model, cpu_stepping, isa, cores, memory_bytes,
               date);
}

void list_fields(auto& f, FieldsOf<PlanRecord> auto& r) {
  FIELDS(experiment_hash, shard, shards, cells, all_cells);
  f.maybe("filter", r.filter);
}

void list_fields(auto& f, FieldsOf<SceneRecord> auto& r) {
  FIELDS(scene, hash, file);
  f.maybe("pixel_filter", r.pixel_filter);
}

void list_fields(auto& f, FieldsOf<ReferenceRecord> auto& r) {
  FIELDS(scene, scene_hash, source, file, mse_floor, width, height, checks);
  f.stamp("file", r.stamp);
  MAYBE_FIELDS(warnings, relmse_floor);
}

void list_fields(auto& f, FieldsOf<StructureRecord> auto& r) {
  FIELDS(scene, structure, layout, manifest, triangles, bytes, nodes, depth, threads, sah_cost, epo_cost, epo_triangles);
  FIELDS(nodes_per_ray, primitives_per_ray, checked, disagreements);
  MAYBE_FIELDS(note, fallback);
  f.measured("build_s", r.build_s);
  f.measured("parallel_build_s", r.parallel_build_s);
  for (const KindFigure& figure : kind_figures)
    for (const RayKind kind : ray_kinds)
      f.measured(std::string(ray_kind_name(kind)) + figure.suffix, (r.*figure.figures)[index_of(kind)]);
}

void list_fields(auto& f, FieldsOf<CheckpointRecord> auto& r) {
  f.cell(r.cell);
  FIELDS(manifest, iterations, time_s, cpu_s, phases_s, metrics, peak_memory_bytes);
  f.counts("counters", r.counters);
  MAYBE_FIELDS(non_finite, regions, confidence);
}

void list_fields(auto& f, FieldsOf<CellRecord> auto& r) {
  f.cell(r.cell);
  MAYBE_FIELDS(parameters, accel_parameters);
  FIELDS(status, error, image, image_hash);
  f("declared_bias", r.bias);
  FIELDS(mse_exponent, bias_bound, note);
  MAYBE_FIELDS(fallback, chosen, why, chosen_accel, accel_why, out_of_reach);
  f.stamp("image", r.image_stamp);
  f.maybe("strip", r.strip);
  f.stamp("strip", r.strip_stamp);
  MAYBE_FIELDS(checkpoints, non_finite_at);
}

void list_fields(auto& f, FieldsOf<ProductsRecord> auto& r) {
  FIELDS(scene, accel, integrator);
  MAYBE_FIELDS(region, at_checkpoints);
  FIELDS(images, seeds, products);
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
  FIELDS(scene, region);
  f.maybe("expected", r.expected);
  f("source", r.source);
  if (!r.is_exponent()) return;
  FIELDS(metric, x);
  f.choice("points", r.across, points);
  f("from", r.from);
  f.end("to", r.to, endless);
  f.choice("model", r.model, models);
}

void list_fields(auto& f, FieldsOf<RegionChoice> auto& r) { FIELDS(name, scene, polygon); }

void list_fields(auto& f, FieldsOf<ElsewhereFigure> auto& r) {
  FIELDS(scene, program, method, metric, time_s, error, machine, date, source);
}

void list_fields(auto& f, FieldsOf<StatedRecord> auto& r) {
  FIELDS(predictions, regions);
  MAYBE_FIELDS(elsewhere, labels);
}

template <class Record>
std::string to_json_line(const Record& record) {
  return line_of(Record::line_type, record);
}

template <class Record>
Record read_record(const Json& json) {
  return read_value<Record>(json);
}

#define ETENDUE_LINES_OF(Record)                    \
  template std::string to_json_line(const Record&); \
  template Record read_record<Record>(const Json&);
ETENDUE_LINES_OF(ManifestRecord)
ETENDUE_LINES_OF(PlanRecord)
ETENDUE_LINES_OF(SceneRecord)
ETENDUE_LINES_OF(ReferenceRecord)
ETENDUE_LINES_OF(StructureRecord)
ETENDUE_LINES_OF(CheckpointRecord)
ETENDUE_LINES_OF(CellRecord)
ETENDUE_LINES_OF(ProductsRecord)
ETENDUE_LINES_OF(StatedRecord)

std::vector<LineFields> log_line_fields() {
  const auto lines_of = []<class... Records>(std::type_identity<Records>...) {
    return std::vector<LineFields>{{Records::line_type, fields_of<Records>()}...};
  };
  using std::type_identity;
  std::vector<LineFields> lines =
      lines_of(type_identity<ManifestRecord>{}, type_identity<PlanRecord>{}, type_identity<SceneRecord>{},
               type_identity<ReferenceRecord>{}, type_identity<StructureRecord>{}, type_identity<CheckpointRecord>{},
               type_identity<CellRecord>{}, type_identity<ProductsRecord>{}, type_identity<StatedRecord>{});
  lines.push_back({"finished", {{"took_s", "number", true}}});
  return lines;
}

std::string finished_line(double took_s) {
  Json json{{"type", "finished"}};
  if (took_s > 0) json["took_s"] = logged(took_s);
  return dump(json);
}

}  // namespace etendue
