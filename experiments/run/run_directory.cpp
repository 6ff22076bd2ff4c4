#include "experiments/run/run_directory.h"

#include "experiments/log/trust.h"
#include "experiments/report/report_text.h"
#include "experiments/run/run.h"
#include "framework/core/error.h"
#include "framework/io/image/exr.h"

#include <fmt/format.h>
#include <xxhash.h>
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <span>

namespace etendue {

namespace {

namespace fs = std::filesystem;

constexpr const char* log_name = "runs.jsonl";

std::string log_path(const std::string& directory) { return (fs::path(directory) / log_name).string(); }

FileLock lock_directory(const std::string& path) {
  make_folders(path);
  auto lock = FileLock::try_lock((fs::path(path) / ".lock").string());
  if (!lock) throw Error(Location{path}, "another run is writing there; expected a free directory (--out DIR)");
  return std::move(*lock);
}

// Removes only what a run writes: a user's own files beside it stay.
void clear(const fs::path& directory) {
  for (const char* name :
       {log_name, "runs.jsonl.damaged", "images", "references", "pictures", "tables", "charts", "report.html", "report.files"})
    fs::remove_all(directory / name);
}

void refuse_mixture(const RunLog& log, const ManifestRecord& manifest, const std::string& path) {
  constexpr const char* cure = "expected --fresh to start over, or --out DIR for another directory";
  for (const ManifestRecord& other : log.manifests) {
    if (other.experiment_hash != manifest.experiment_hash)
      throw Error(Location{path},
                  fmt::format("holds results of another experiment or of other settings ('{}', {}; this is '{}', {}); {}",
                              other.title, other.experiment_hash, manifest.title, manifest.experiment_hash, cure));
    if (other.threads != manifest.threads)
      throw Error(Location{path},
                  fmt::format("holds results of {} threads, this run has {}, and times would be mixed; {}, or --threads {}",
                              other.threads, manifest.threads, cure, other.threads));
  }
}

// Without the manifest under which it was logged nobody knows what a record was measured with: its line was damaged.
void drop_nameless(RunLog& log, const std::string& own) {
  std::set<std::string> known{own};
  for (const ManifestRecord& manifest : log.manifests) known.insert(manifest.id);
  const auto nameless = [&](const auto& record) { return !known.contains(record.manifest); };
  std::set<CellName> cells;
  for (const CheckpointRecord& checkpoint : log.checkpoints)
    if (nameless(checkpoint)) cells.insert(checkpoint.cell);
  std::erase_if(log.cells, [&](const CellRecord& record) { return cells.contains(record.cell); });
  std::erase_if(log.checkpoints, nameless);
  std::erase_if(log.structures, nameless);
  std::erase_if(log.records, [&](const auto& record) { return nameless(*record); });
}

// Gives the path from the directory, unless the two have nothing in common but the root: no other machine has such a path.
std::string path_from(const fs::path& directory, const std::string& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return "";
  const fs::path from = fs::weakly_canonical(directory, error), to = fs::weakly_canonical(file, error);
  if (error || *std::next(from.begin()) != *std::next(to.begin())) return "";
  return to.lexically_relative(from).string();
}

// The name is readable, of bounded length, and unique by the hash of the whole name.
std::string safe_name(const CellName& cell) {
  std::string name;
  for (const std::string& part : {cell.scene, cell.accel, cell.integrator}) name += slug(part).substr(0, 48) + "_";
  const std::string key = cell.key();
  return fmt::format("{}seed-{}_{:08x}", name, cell.seed, XXH3_64bits(key.data(), key.size()) & 0xffffffffu);
}

}  // namespace

RunDirectory::RunDirectory(const std::string& path, const ManifestRecord& manifest, const PlanRecord& plan, bool fresh,
                           RunObserver& observer)
    : path_(path), manifest_id_(manifest.id), observer_(observer), lock_(lock_directory(path)) {
  if (fresh) clear(path);
  remove_partial_files(path);
  for (const char* name : {"images", "references", "pictures", "tables", "charts"})
    remove_partial_files((fs::path(path) / name).string());
  for (const char* name : {"images", "references"}) make_folders((fs::path(path) / name).string());
  const std::string log = log_path(path);
  if (fs::exists(log)) {
    std::vector<DamagedLine> damaged;
    earlier_ = read_log(log, damaged);
    refuse_mixture(earlier_, manifest, path);
    const bool nothing_left = earlier_.manifests.empty() && earlier_.plans.empty() && earlier_.scenes.empty();
    if (nothing_left && damaged.size() > 1)
      throw Error(Location{log},
                  "not a line of it is as `etendue run` writes them (older versions wrote no checksums); expected "
                  "--fresh to start over, or --out DIR for another directory");
    set_aside(log, damaged);
    constexpr std::size_t most = 10;
    for (const DamagedLine& line : std::span(damaged).first(std::min(damaged.size(), most)))
      observer_.warn(line.what + "; it is set aside in runs.jsonl.damaged, and what it was part of runs again");
    if (damaged.size() > most) observer_.warn(fmt::format("{}: so are {} more lines", log, damaged.size() - most));
    drop_nameless(earlier_, manifest_id_);
    if (earlier_.torn) observer_.warn(log + ": its end is torn, as a run that is killed leaves it; that is cut off");
  }
  finished_ = earlier_.finished;
  follows_stopped_ = !earlier_.finished && !earlier_.manifests.empty();
  writer_ = std::make_unique<LogWriter>(log);
  // The id names neither the experiment's text nor what was typed beside it; of lines with one id the last counts.
  ManifestRecord dated = manifest;  // on the day on which it first ran
  for (const ManifestRecord& other : earlier_.manifests)
    if (other.id == dated.id) dated.date = other.date;
  const std::string line = to_json_line(dated);
  const auto same = [&](const ManifestRecord& other) { return to_json_line(other) == line; };
  if (std::ranges::none_of(earlier_.manifests, same)) append({line});
  if (earlier_.plans.empty() || earlier_.plans.back() != plan) append({to_json_line(plan)});
}

void RunDirectory::read_again() {
  earlier_ = read_log(log_path(path_));
  drop_nameless(earlier_, manifest_id_);
}

void RunDirectory::append(const std::vector<std::string>& lines) {
  finished_ = false;
  writer_->append(lines);
}

void RunDirectory::finish() {
  if (!finished_) append({finished_line(follows_stopped_ ? 0 : now_s() - opened_)});
  finished_ = true;
}

void RunDirectory::note_scene(const std::string& scene, const std::string& path, std::uint64_t hash,
                              const std::string& pixel_filter) {
  const SceneRecord record{scene, fmt::format("{:016x}", hash), path_from(path_, path), pixel_filter};
  const SceneRecord* known = earlier_.scene(scene);
  if (known != nullptr && to_json_line(*known) == to_json_line(record)) return;
  const std::string before = known == nullptr ? "" : known->hash;
  const std::size_t had = earlier_.cell_count();
  append({to_json_line(record)});
  if (before == record.hash) return;
  read_again();  // where the rule stands by which records no longer count
  if (had != earlier_.cell_count())
    observer_.warn(fmt::format("{} has changed since its cells were run (hash {}, then {}): they run again", scene, record.hash,
                               before.empty() ? "not known" : before));
}

void RunDirectory::note_reference(const ReferenceRecord& record) {
  const ReferenceRecord* known = earlier_.reference(record.scene);
  // It is logged once: a run that goes on ends with the log of one that was not stopped.
  if (known != nullptr && to_json_line(*known) == to_json_line(record)) return;
  const bool differs = known == nullptr || known->stamp != record.stamp;
  const std::size_t had = earlier_.cell_count();
  append({to_json_line(record)});
  read_again();
  if (differs && had != earlier_.cell_count())
    observer_.warn(
        fmt::format("the reference of {} is not the one that its cells were measured against: they run again", record.scene));
}

std::set<CellName> RunDirectory::believed_cells() const {
  std::set<CellName> believed;
  const auto take = [&](auto& record) {
    if (record.status != "done") return;
    const std::string wrong = damage(record, path_);
    if (wrong.empty())
      believed.insert(record.cell);
    else
      observer_.warn(fmt::format("{}: {}; it runs again", record.cell.key(), wrong));
  };
  for (const CellRecord& cell : earlier_.cells) take(cell);
  for (const auto& record : earlier_.records) take(*record);
  return believed;
}

bool RunDirectory::has_structures(const std::string& scene, std::size_t count) const {
  return static_cast<std::size_t>(
             std::ranges::count_if(earlier_.structures, [&](const auto& record) { return record.scene == scene; })) >= count;
}

StoredFile RunDirectory::write_image(const CellName& cell, const Image& image,
                                     const std::map<std::string, std::string>& attributes) {
  const std::string relative = "images/" + safe_name(cell) + ".exr";
  return {relative, write_exr((fs::path(path_) / relative).string(), image, attributes)};
}

StoredFile RunDirectory::write_strip(const CellName& cell, const std::vector<Image>& images) {
  const ivec2 size = images.front().size;
  Image strip({size.x, size.y * static_cast<int>(images.size())});
  auto to = strip.pixels.begin();
  for (const Image& image : images) to = std::ranges::copy(image.pixels, to).out;
  const std::string relative = "images/" + safe_name(cell) + "_checkpoints.exr";
  return {relative, write_exr((fs::path(path_) / relative).string(), strip, {{"etendue_cell", cell.key()}})};
}

StoredFile RunDirectory::write_reference(const std::string& scene, const Image& image,
                                         const std::map<std::string, std::string>& attributes) {
  const std::string relative =
      fmt::format("references/{}_{:08x}.exr", slug(scene).substr(0, 80), XXH3_64bits(scene.data(), scene.size()) & 0xffffffffu);
  const std::string path = (fs::path(path_) / relative).string(), bytes = encode_exr(image, attributes);
  const FileStamp stamp = stamp_of(bytes);
  if (!difference(path, stamp).empty()) write_whole_file(path, bytes);
  return {relative, stamp};
}

RunLog read_directory_log(const std::string& path) {
  const std::string file = log_path(path);
  return fs::exists(file) ? read_log(file) : RunLog{};
}

}  // namespace etendue
