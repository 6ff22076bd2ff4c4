#include "experiments/harness/run_directory.h"

#include "experiments/harness/report_text.h"
#include "framework/core/error.h"
#include "framework/io/exr.h"

#include <fmt/format.h>
#include <xxhash.h>
#include <algorithm>
#include <filesystem>
#include <memory>

namespace etendue {

namespace {

namespace fs = std::filesystem;

constexpr const char* log_name = "runs.jsonl";

std::string log_path(const std::string& directory) { return (fs::path(directory) / log_name).string(); }

void make_directory(const fs::path& path) {
  std::error_code failed;
  fs::create_directories(path, failed);
  if (failed) throw Error(Location{path.string()}, "cannot make the directory: " + failed.message());
}

FileLock lock_directory(const std::string& path) {
  make_directory(path);
  auto lock = FileLock::try_lock((fs::path(path) / ".lock").string());
  if (!lock) throw Error(Location{path}, "another run is writing there; expected a free directory (--out DIR)");
  return std::move(*lock);
}

// Only what a run writes: a user's own files beside it stay.
void clear(const fs::path& directory) {
  for (const char* name : {log_name, "images", "references", "tables", "charts", "report.html", "report.files"})
    fs::remove_all(directory / name);
}

// What writers of images that were killed left behind. The lock is held, so nobody is writing now.
void remove_partial_images(const fs::path& directory) {
  std::vector<fs::path> partial;
  for (const auto& entry : fs::directory_iterator(directory))
    if (entry.path().extension() == ".part") partial.push_back(entry.path());
  for (const fs::path& path : partial) fs::remove(path);
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

// Readable, of bounded length, and unique by the hash of the whole name.
std::string safe_name(const CellName& cell) {
  std::string name;
  for (const std::string& part : {cell.scene, cell.accel, cell.integrator}) name += slug(part).substr(0, 48) + "_";
  const std::string key = cell.key();
  return fmt::format("{}seed-{}_{:08x}", name, cell.seed, XXH3_64bits(key.data(), key.size()) & 0xffffffffu);
}

}  // namespace

RunDirectory::RunDirectory(const std::string& path, const ManifestRecord& manifest, bool fresh)
    : path_(path), lock_(lock_directory(path)) {
  if (fresh) clear(path);
  earlier_ = read_directory_log(path);
  refuse_mixture(earlier_, manifest, path);
  for (const CellRecord& cell : earlier_.cells)
    if (cell.status == "done") done_.insert(cell.cell);
  for (const char* name : {"images", "references"}) {
    make_directory(fs::path(path) / name);
    remove_partial_images(fs::path(path) / name);
  }
  writer_ = std::make_unique<LogWriter>(log_path(path));
  // The id names neither the experiment's text nor what was typed beside it; of lines with one id the last counts.
  const std::string line = to_json_line(manifest);
  const auto same = [&](const ManifestRecord& other) { return to_json_line(other) == line; };
  if (std::none_of(earlier_.manifests.begin(), earlier_.manifests.end(), same)) append({line});
}

bool RunDirectory::has_structures(const std::string& scene, std::size_t count) const {
  return static_cast<std::size_t>(std::count_if(earlier_.structures.begin(), earlier_.structures.end(),
                                                [&](const auto& record) { return record.scene == scene; })) >= count;
}

std::string RunDirectory::write_image(const CellName& cell, const Image& image,
                                      const std::map<std::string, std::string>& attributes) {
  const std::string relative = "images/" + safe_name(cell) + ".exr";
  write_exr((fs::path(path_) / relative).string(), image, attributes);
  return relative;
}

std::string RunDirectory::write_strip(const CellName& cell, const std::vector<Image>& images) {
  const ivec2 size = images.front().size;
  Image strip({size.x, size.y * static_cast<int>(images.size())});
  auto to = strip.pixels.begin();
  for (const Image& image : images) to = std::copy(image.pixels.begin(), image.pixels.end(), to);
  const std::string relative = "images/" + safe_name(cell) + "_checkpoints.exr";
  write_exr((fs::path(path_) / relative).string(), strip, {{"etendue_cell", cell.key()}});
  return relative;
}

std::string RunDirectory::write_reference(const std::string& scene, const Image& image,
                                          const std::map<std::string, std::string>& attributes) {
  const std::string relative =
      fmt::format("references/{}_{:08x}.exr", slug(scene).substr(0, 80), XXH3_64bits(scene.data(), scene.size()) & 0xffffffffu);
  write_exr((fs::path(path_) / relative).string(), image, attributes);
  return relative;
}

RunLog read_directory_log(const std::string& path) {
  const std::string file = log_path(path);
  return fs::exists(file) ? read_log(file) : RunLog{};
}

}  // namespace etendue
