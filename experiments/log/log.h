// runs.jsonl, the log of an experiment. Every table, chart and page is derived from it.
//
// One JSON object a line, its "type" first, and last "xxh3", a checksum of the bytes before that key:
//
//   manifest    what ran: id (hash of what names the program, machine and settings), version, commit, compiler, flags, cpu,
//               threads, title and hash of the experiment, its file, options and text, the time each cell had
//   plan        what is to run into this directory: shard, of how many, cells of it and of all shards, the filter
//   scene       a scene as it is from here on: its hash, and its file relative to the directory ("": built in). Where the hash
//               is another than before, what was logged of the scene until then no longer counts
//   reference   what a scene's error is measured against: scene, scene_hash, source, file (relative, or "" for a closed form
//               evaluated on the spot) with its size and hash, mse_floor (variance of its mean), checks (text of the agreement
//               test), warnings of the scene's reader. Where the file's hash is another than before, the scene's cells until
//               then no longer count
//   structure   a structure built over a scene: keys of StructureRecord
//   checkpoint  one point of a cell's convergence: keys of CheckpointRecord
//   products    how the errors of a configuration's seeds go together: keys of ProductsRecord
//   predictions what the experiment predicts, and the regions that it speaks of (prediction.h); the last such line counts
//   cell        the end of a cell: status "done" or "failed" (with error), how many checkpoints stand before it, hash of the
//               image, files with size and hash, expectation
//   others      the end of a cell of another kind of experiment, with all of its figures (experiments/kind.h): animation,
//               claim, search, stress, throughput, ledger
//   finished    all that was to run did, in took_s seconds, unless an earlier run was stopped; whatever is logged later takes
//               this back
//
// A cell's checkpoints and its closing `cell` line are appended in one write and flushed to disk, after the files that they
// name, so a killed run leaves whole cells and at most one torn last line, which the reader drops and the next writer cuts off.
#pragma once

#include "experiments/config/cell_name.h"
#include "experiments/config/prediction.h"
#include "experiments/log/json_fwd.h"
#include "experiments/log/values.h"
#include "framework/core/lists.h"
#include "framework/io/whole_file.h"

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <typeinfo>
#include <vector>

namespace etendue {

// The records, each with the type of its line.

struct ManifestRecord {
  static constexpr const char* line_type = "manifest";

  std::string id, version, commit, compiler, flags, cpu, title, experiment_hash;
  int threads = 0;
  std::string file = {}, options = {}, experiment = {};  // file ("": elsewhere), what was typed beside it, its text
  double budget_s = 0;                                   // of each cell, where time alone ended it; 0: not so, or not known
  // The machine: what CPUID says ("AuthenticAMD", family, model, stepping), the instruction set that was used ("AVX2"), its
  // processors and memory; and the day, in UTC. Older logs have none of it.
  std::string cpu_vendor = {}, isa = {}, date = {};
  int cpu_family = 0, cpu_model = 0, cpu_stepping = 0, cores = 0;
  std::uint64_t memory_bytes = 0;
};

// Names the program, how it was built, and the machine, and has an id. `title` and `experiment_hash` may be empty (a single
// render).
ManifestRecord make_manifest(const std::string& title, const std::string& experiment_hash, int threads);

std::string version_text();  // "etendue 0.1.0 (commit)"

struct PlanRecord {
  static constexpr const char* line_type = "plan";

  std::string experiment_hash, filter;
  int shard = 0, shards = 1;
  std::uint64_t cells = 0, all_cells = 0;  // of this shard, and of all of them

  bool operator==(const PlanRecord&) const = default;
};

struct SceneRecord {
  static constexpr const char* line_type = "scene";

  std::string scene, hash;
  std::string file = {};          // relative to the log's directory; "": built in, or nowhere that another machine has
  std::string pixel_filter = {};  // by name, in the place of the scene's; "": that one
};

struct ReferenceRecord {
  static constexpr const char* line_type = "reference";

  std::string scene, scene_hash, source, file, checks;
  double mse_floor = 0;
  int width = 0, height = 0;
  FileStamp stamp = {};
  std::vector<std::string> warnings = {};  // of the scene's reader: what was left out or replaced, and what is not finite
  double relmse_floor = 0;                 // the part of every relMSE that is the reference's noise; 0: none, or not known
};

struct CheckpointRecord {
  static constexpr const char* line_type = "checkpoint";

  CellName cell;
  std::string manifest;
  std::uint64_t iterations = 0;
  double time_s = 0;                       // wall time of build + prepare + iterations; metrics and images are off the clock
  double cpu_s = 0;                        // user + system, same span
  std::map<std::string, double> phases_s;  // "build", "emit", "trace", ..., "other"
  std::map<std::string, double> metrics;   // by metric name; against the scene's reference, its floor not subtracted
  std::map<std::string, std::uint64_t> counters;
  std::uint64_t peak_memory_bytes = 0;
  std::uint64_t non_finite = 0;
  std::map<std::string, std::map<std::string, double>> regions = {};  // the metrics of each region by its name
  std::map<std::string, double> confidence = {};  // as of declared.h; empty: the method knows no error of its own
};

struct CellRecord {
  static constexpr const char* line_type = "cell";

  CellName cell;
  std::string status;  // "done" | "failed"
  std::string error;   // of a failed cell
  std::string image;   // EXR, relative to the experiment's directory
  std::string image_hash;
  std::string bias;  // "unbiased" | "consistent" | "biased"
  double mse_exponent = 0;
  double bias_bound = 0;  // relative bias of the mean that the method declares
  std::string note;
  std::string fallback = {};          // what replaced the structure, and why; empty: nothing did
  std::string chosen = {}, why = {};  // by a method that chooses another: that one's label and the reason; empty: it does not
  std::string chosen_accel = {}, accel_why = {};  // likewise of the structure
  std::string out_of_reach = {};                  // light that the method practically never finds, a line for each kind
  std::string strip = {};                         // EXR of the images at all checkpoints, one below the other; empty: not kept
  FileStamp image_stamp = {}, strip_stamp = {};
  std::optional<std::uint64_t> checkpoints = {};  // that stand before it
  // The first ten non-finite samples are known by column, row and iteration, for replay.
  std::vector<std::array<std::uint32_t, 3>> non_finite_at = {};
  Parameters parameters = {}, accel_parameters = {};  // of integrator and structure
};

// The mean over pixels and channels of the product of two seeds' errors, G_ij, for each pair of seeds: squared bias, variance
// and their rates are computed from them (rate_fit.h). Found from the images as soon as a configuration's seeds are done.
struct ProductsRecord {
  static constexpr const char* line_type = "products";

  std::string scene, accel, integrator;
  std::string region;                              // empty: the whole image
  bool at_checkpoints = false;                     // a point for each checkpoint; otherwise one, of the last images
  std::string images;                              // hash of what names the images and the reference: current_products()
  std::vector<std::uint64_t> seeds = {};           // ascending
  std::vector<std::vector<double>> products = {};  // of each point: G_ij with i <= j, row by row
};

struct StructureRecord {
  static constexpr const char* line_type = "structure";

  std::string scene, structure, layout, manifest;
  std::string note;      // what was left out of the measurement, and why; empty: nothing
  std::string fallback;  // what was measured instead of the structure, and why; empty: the structure itself
  std::uint64_t triangles = 0, bytes = 0, nodes = 0, depth = 0;
  std::uint64_t checked = 0, disagreements = 0;  // answers that were checked, and wrong ones
  int threads = 1;                               // of parallel_build_s
  Measured build_s, parallel_build_s;            // the first on one thread
  double sah_cost = 0, epo_cost = 0;
  std::uint64_t epo_triangles = 0;  // that epo_cost was computed from
  double nodes_per_ray = 0, primitives_per_ray = 0;
  // Speeds are millions of rays a second on one thread, ray by ray and in batches.
  ByRayKind<Measured> mrays_per_s, batched_mrays_per_s;
  // Speed ray by ray over that of Embree, repetition by repetition: in its default mode, and with its watertight test.
  ByRayKind<Measured> to_embree, to_robust_embree;
  // The speed of batches over that of Embree's streams, told that rays are coherent or not, whichever is faster.
  ByRayKind<Measured> batched_to_embree;

  const Measured& speed(RayKind kind) const { return mrays_per_s[index_of(kind)]; }
  Measured& speed(RayKind kind) { return mrays_per_s[index_of(kind)]; }
};

// The end of a cell of any other kind of experiment: one line with all of its figures. Kinds derive their own.
struct KindRecord {
  CellName cell;
  std::string manifest;
  std::string status, error;  // as of a CellRecord

  virtual ~KindRecord() = default;
  virtual std::string line() const = 0;  // of the log, without its checksum
  // Names a file beside the log; null: there is none.
  struct File {
    std::string* path = nullptr;
    const FileStamp* stamp = nullptr;
  };
  virtual File file() { return {}; }
  // Whether its figures are measured against the reference of that scene: they count no more where it is another.
  virtual bool uses_reference_of(const std::string&) const { return false; }

  bool done() const { return status == "done"; }
};

struct RunLog {
  std::vector<ManifestRecord> manifests;
  std::vector<ReferenceRecord> references;
  std::vector<StructureRecord> structures;
  std::vector<CheckpointRecord> checkpoints;
  std::vector<CellRecord> cells;
  std::vector<ProductsRecord> products;
  std::vector<std::shared_ptr<KindRecord>> records;
  StatedRecord stated;
  std::vector<PlanRecord> plans;  // the last is the one that counts
  std::vector<SceneRecord> scenes;
  bool finished = false, torn = false;  // torn: its last block was cut short
  double took_s = 0;                    // of all its runs; 0: not known, as where one was stopped

  std::size_t cell_count() const { return cells.size() + records.size(); }
  // The log's lines about a scene; null where there is none.
  const SceneRecord* scene(const std::string& name) const { return of_scene(scenes, name); }
  const ReferenceRecord* reference(const std::string& scene) const { return of_scene(references, scene); }

 private:
  template <class Record>
  static const Record* of_scene(const std::vector<Record>& records, const std::string& scene) {
    for (const Record& record : records)
      if (record.scene == scene) return &record;
    return nullptr;
  }
};

// Gives those of one kind, in order of the log.
template <class Record>
std::vector<const Record*> records_of(const RunLog& log) {
  std::vector<const Record*> found;
  for (const auto& record : log.records)
    if (const KindRecord& r = *record; typeid(r) == typeid(Record)) found.push_back(static_cast<const Record*>(record.get()));
  return found;
}

// Gives those of them that are done.
template <class Record>
std::vector<const Record*> done_records_of(const RunLog& log) {
  std::vector<const Record*> found = records_of<Record>(log);
  std::erase_if(found, [](const Record* record) { return !record->done(); });
  return found;
}

// Reads a record of the kinds that are registered; null where `type` is none of theirs.
std::shared_ptr<KindRecord> read_kind_record(const std::string& type, const Json& json);
std::vector<std::string> kind_record_types();

// The line of any of the records above, without the newline. Figures have nine significant digits; non-finite ones are an error
// of the caller (CHECK).
template <class Record>
std::string to_json_line(const Record& record);
// Reads the record of a line. A missing key or one of the wrong type throws nlohmann::json::exception; keys that were added to
// the format later have defaults, so that older logs can still be read.
template <class Record>
Record read_record(const Json& json);
std::string finished_line(double took_s = 0);  // after so many seconds; 0: not known

// Gives the line as it stands in the file, with its checksum.
std::string sealed(const std::string& line);

struct DamagedLine {
  int line = 0;
  std::string what;  // "file:line: what is wrong"
};

// Reads a whole log. A torn last block is dropped; any other malformed line, and one whose checksum is wrong, throws
// Error{file:line}. Of a cell logged twice the last counts.
RunLog read_log(const std::string& path);
// Leaves such lines out and lists them instead.
RunLog read_log(const std::string& path, std::vector<DamagedLine>& damaged);
// Moves such lines to "<path>.damaged". Throws WriteError.
void set_aside(const std::string& path, const std::vector<DamagedLine>& damaged);
// The record takes the place of what the log has of the same configuration, region and points.
void add_products(RunLog& log, ProductsRecord record);
// Merges logs of shards, as one process would have written them; the same cell twice counts once (the last).
RunLog merge_logs(const std::vector<RunLog>& logs);

// Appends whole blocks, sealed. Opening cuts a torn last line and checkpoints that no `cell` line closed.
class LogWriter {
 public:
  explicit LogWriter(const std::string& path);
  ~LogWriter();
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;
  void append(const std::vector<std::string>& lines);  // one write, then fsync

 private:
  int file_ = -1;
  std::string path_;
};

}  // namespace etendue
