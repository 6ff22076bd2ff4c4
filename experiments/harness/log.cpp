#include "experiments/harness/log.h"

#include "framework/core/check.h"
#include "framework/core/error.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

namespace etendue {

namespace {

using Json = nlohmann::ordered_json;  // keeps "type" first

double finite(double x) {
  CHECK(std::isfinite(x));
  return x;
}

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

std::string dump(const Json& json) {
  // Foreign bytes in an error's text must not make the line unwritable.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

ManifestRecord read_manifest(const Json& j) {
  return {j.at("id"),  j.at("version"), j.at("commit"),          j.at("compiler"), j.at("flags"),
          j.at("cpu"), j.at("title"),   j.at("experiment_hash"), j.at("threads")};
}

ReferenceRecord read_reference(const Json& j) {
  return {j.at("scene"),  j.at("scene_hash"), j.at("source"), j.at("file"),
          j.at("checks"), j.at("mse_floor"),  j.at("width"),  j.at("height")};
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
  return r;
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

struct KindFigure {
  const char* suffix;
  ByRayKind<Measured> StructureRecord::*figures;
};
constexpr KindFigure kind_figures[] = {{"_mrays_per_s", &StructureRecord::mrays_per_s},
                                       {"_batched_mrays_per_s", &StructureRecord::batched_mrays_per_s},
                                       {"_to_embree", &StructureRecord::to_embree},
                                       {"_to_robust_embree", &StructureRecord::to_robust_embree},
                                       {"_batched_to_embree", &StructureRecord::batched_to_embree}};

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

template <class Record, class Same>
void put(std::vector<Record>& records, Record record, const Same& same) {
  for (Record& other : records) {
    if (!same(other, record)) continue;
    other = std::move(record);
    return;
  }
  records.push_back(std::move(record));
}

void put_manifest(RunLog& log, ManifestRecord record) {
  put(log.manifests, std::move(record), [](const auto& a, const auto& b) { return a.id == b.id; });
}
void put_reference(RunLog& log, ReferenceRecord record) {
  put(log.references, std::move(record), [](const auto& a, const auto& b) { return a.scene == b.scene; });
}
void put_structure(RunLog& log, StructureRecord record) {
  put(log.structures, std::move(record),
      [](const auto& a, const auto& b) { return a.scene == b.scene && a.structure == b.structure && a.layout == b.layout; });
}

void put_animation(RunLog& log, AnimationRecord record) {
  put(log.animations, std::move(record), [](const auto& a, const auto& b) { return a.cell == b.cell; });
}

void put_claim(RunLog& log, ClaimRecord record) {
  put(log.claims, std::move(record), [](const auto& a, const auto& b) { return a.cell == b.cell; });
}

void put_search(RunLog& log, SearchRecord record) {
  put(log.searches, std::move(record), [](const auto& a, const auto& b) { return a.cell == b.cell; });
}

// A cell's checkpoints and closing line, in the place of any that it left before.
class CellBlocks {
 public:
  void put(const CellRecord& cell, std::vector<CheckpointRecord> checkpoints) {
    const auto [found, inserted] = position_.try_emplace(cell.cell, blocks_.size());
    if (inserted) blocks_.emplace_back();
    blocks_[found->second] = {cell, std::move(checkpoints)};
  }
  void move_into(RunLog& log) {
    for (auto& [cell, checkpoints] : blocks_) {
      log.cells.push_back(std::move(cell));
      std::move(checkpoints.begin(), checkpoints.end(), std::back_inserter(log.checkpoints));
    }
  }

 private:
  std::map<CellName, std::size_t> position_;
  std::vector<std::pair<CellRecord, std::vector<CheckpointRecord>>> blocks_;
};

std::string read_all(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(Location{path}, "cannot open the log; expected a runs.jsonl that `etendue run` wrote");
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string system_error() { return std::strerror(errno); }

// Length of the log without a torn last line and without checkpoints that no `cell` line closed. Both come from a write that
// was cut short, so they stand at the end.
std::size_t whole_length(const std::string& text) {
  std::size_t kept = 0;
  for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    if (std::string_view(text).substr(begin, end - begin).find("\"type\":\"checkpoint\"") == std::string_view::npos)
      kept = end + 1;
  }
  return kept;
}

}  // namespace

std::string CellName::key() const { return fmt::format("{} | {} | {} | seed={}", scene, accel, integrator, seed); }

std::string to_json_line(const ManifestRecord& r) {
  return dump({{"type", "manifest"},
               {"id", r.id},
               {"version", r.version},
               {"commit", r.commit},
               {"compiler", r.compiler},
               {"flags", r.flags},
               {"cpu", r.cpu},
               {"threads", r.threads},
               {"title", r.title},
               {"experiment_hash", r.experiment_hash}});
}

std::string to_json_line(const ReferenceRecord& r) {
  return dump({{"type", "reference"},
               {"scene", r.scene},
               {"scene_hash", r.scene_hash},
               {"source", r.source},
               {"file", r.file},
               {"mse_floor", finite(r.mse_floor)},
               {"width", r.width},
               {"height", r.height},
               {"checks", r.checks}});
}

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
  if (!r.strip.empty()) json["strip"] = r.strip;
  return dump(json);
}

RunLog read_log(const std::string& path) {
  const std::string text = read_all(path);
  RunLog log;
  CellBlocks blocks;
  std::map<CellName, std::vector<CheckpointRecord>> open;
  int line = 0;
  for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    ++line;
    try {
      const Json json =
          Json::parse(text.begin() + static_cast<std::ptrdiff_t>(begin), text.begin() + static_cast<std::ptrdiff_t>(end));
      const std::string type = json.at("type");
      if (type == "manifest") {
        put_manifest(log, read_manifest(json));
      } else if (type == "reference") {
        put_reference(log, read_reference(json));
      } else if (type == "structure") {
        put_structure(log, read_structure(json));
      } else if (type == "animation") {
        put_animation(log, read_animation_line(text.substr(begin, end - begin)));
      } else if (type == "claim") {
        put_claim(log, read_claim_line(text.substr(begin, end - begin)));
      } else if (type == "rates") {
        log.rates = read_rate_line(text.substr(begin, end - begin));
      } else if (type == "search") {
        put_search(log, read_search_line(text.substr(begin, end - begin)));
      } else if (type == "checkpoint") {
        CheckpointRecord record = read_checkpoint(json);
        open[record.cell].push_back(std::move(record));
      } else if (type == "cell") {
        const CellRecord record = read_cell(json);
        blocks.put(record, std::move(open[record.cell]));
        open.erase(record.cell);
      } else {
        const std::vector<std::string> types{"manifest", "reference", "structure",  "animation", "claim",
                                             "rates",    "search",    "checkpoint", "cell"};
        throw Error(Location{path, line}, unknown_name("record", type, types));
      }
    } catch (const Json::exception& e) {
      throw Error(Location{path, line}, fmt::format("bad record: {}; expected a line that `etendue run` wrote", e.what()));
    }
  }
  blocks.move_into(log);
  return log;
}

RunLog merge_logs(const std::vector<RunLog>& logs) {
  RunLog merged;
  CellBlocks blocks;
  for (const RunLog& log : logs) {
    for (const auto& record : log.manifests) put_manifest(merged, record);
    for (const auto& record : log.references) put_reference(merged, record);
    for (const auto& record : log.structures) put_structure(merged, record);
    for (const auto& record : log.animations) put_animation(merged, record);
    for (const auto& record : log.claims) put_claim(merged, record);
    merged.rates.merge(log.rates);
    for (const auto& record : log.searches) put_search(merged, record);
    std::map<CellName, std::vector<CheckpointRecord>> checkpoints;
    for (const auto& record : log.checkpoints) checkpoints[record.cell].push_back(record);
    for (const auto& record : log.cells) blocks.put(record, std::move(checkpoints[record.cell]));
  }
  blocks.move_into(merged);
  return merged;
}

LogWriter::LogWriter(const std::string& path) : path_(path) {
  file_ = open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file_ < 0) throw Error(Location{path}, "cannot write the log: " + system_error());
  const std::string text = read_all(path);
  if (const std::size_t kept = whole_length(text); kept < text.size()) {
    if (ftruncate(file_, static_cast<off_t>(kept)) != 0 || fsync(file_) != 0) {
      const std::string why = system_error();
      close(file_);
      throw Error(Location{path}, "cannot cut the log's torn end: " + why);
    }
  }
}

LogWriter::~LogWriter() { close(file_); }

void LogWriter::append(const std::vector<std::string>& lines) {
  std::string block;
  for (const std::string& line : lines) block += line + '\n';
  const off_t before = lseek(file_, 0, SEEK_END);
  // A write to a file is cut short only by a full disk or a signal: go on from there, so that the block is whole or torn last.
  for (std::size_t written = 0; written < block.size();) {
    const ssize_t n = write(file_, block.data() + written, block.size() - written);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      std::string why = system_error();
      if (ftruncate(file_, before) != 0) why += "; nor can the torn line be cut off";  // or the next one would begin in it
      throw Error(Location{path_}, "cannot write the log: " + why);
    }
    written += static_cast<std::size_t>(n);
  }
  if (fsync(file_) != 0) throw Error(Location{path_}, "cannot flush the log to disk: " + system_error());
}

}  // namespace etendue
