#include "experiments/log/trust.h"

#include "framework/io/load_scene.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <set>
#include <tuple>

namespace etendue {

namespace {

namespace fs = std::filesystem;

std::string damage(const std::string& file, const FileStamp& stamp, const std::string& directory) {
  if (file.empty()) return "";
  if (stamp.hash.empty()) return file + " has no hash in the log";
  const std::string wrong = difference((fs::path(directory) / file).string(), stamp);
  return wrong.empty() ? "" : fmt::format("{} is not as the log says: {}", file, wrong);
}

// Calls with each record that ends a cell; all have a cell, a status and an error.
template <class Visit>
void each_cell(RunLog& log, const Visit& visit) {
  for (auto& record : log.cells) visit(record);
  for (const auto& record : log.records) visit(*record);
}

template <class IsMeant>
std::size_t fail_cells(RunLog& log, const std::string& why, const IsMeant& is_meant) {
  std::size_t count = 0;
  each_cell(log, [&](auto& record) {
    if (record.status != "done" || !is_meant(record)) return;
    record.status = "failed";
    record.error = why;
    ++count;
  });
  return count;
}

bool uses_reference(const CellRecord& record, const std::string& scene) { return record.cell.is_of(scene); }
bool uses_reference(const KindRecord& record, const std::string& scene) { return record.uses_reference_of(scene); }

// Says why a scene is not as it was logged; "" where it is, or where its file is not to be found.
std::string scene_damage(const SceneRecord& record, const std::string& directory) {
  const fs::path path = (fs::path(directory) / record.file).lexically_normal();
  std::error_code error;
  if (record.file.empty() || !fs::is_regular_file(path, error)) return "";
  try {
    // What was approximated is no change of its files.
    const SceneReading reading{.pixel_filter = record.pixel_filter, .approximate = true};
    const std::string hash = fmt::format("{:016x}", load_scene(path.string(), {"command line"}, reading).hash());
    if (hash == record.hash) return "";
    return fmt::format("{} has changed since: its hash is {}, and was {}", path.string(), hash, record.hash);
  } catch (const Error& e) {
    return fmt::format("{} has changed since and can no longer be read: {}", path.string(), e.what());
  }
}

}  // namespace

std::string damage(const CellRecord& cell, const std::string& directory) {
  const std::string image = damage(cell.image, cell.image_stamp, directory);
  return image.empty() ? damage(cell.strip, cell.strip_stamp, directory) : image;
}

std::string damage(KindRecord& record, const std::string& directory) {
  const KindRecord::File file = record.file();
  return file.path ? damage(*file.path, *file.stamp, directory) : "";
}

std::string damage(const ReferenceRecord& reference, const std::string& directory) {
  return damage(reference.file, reference.stamp, directory);
}

std::vector<std::string> distrust(RunLog& log, const std::string& directory, bool scenes) {
  std::vector<std::string> findings;
  const auto tell = [&](const std::string& what) { findings.push_back(fmt::format("{}: {}", directory, what)); };
  const auto check_files = [&](auto& record) {
    const std::string wrong = record.status == "done" ? damage(record, directory) : "";
    if (wrong.empty()) return;
    tell(fmt::format("{}: {}", record.cell.key(), wrong));
    record.status = "failed";
    record.error = wrong;
  };
  for (CellRecord& cell : log.cells) check_files(cell);
  for (const auto& record : log.records) check_files(*record);
  for (ReferenceRecord& reference : log.references) {
    const std::string wrong = damage(reference, directory);
    if (wrong.empty()) continue;
    reference.file.clear();
    const std::size_t cells = fail_cells(log, "its reference cannot be trusted: " + wrong,
                                         [&](const auto& record) { return uses_reference(record, reference.scene); });
    tell(fmt::format("{}: the reference {}; {} cells are not believed", reference.scene, wrong, cells));
  }
  if (!scenes) return findings;
  for (const SceneRecord& scene : log.scenes) {
    const std::string wrong = scene_damage(scene, directory);
    if (wrong.empty()) continue;
    const std::size_t cells = fail_cells(log, wrong, [&](const auto& record) { return record.cell.is_of(scene.scene); });
    const std::size_t structures =
        std::erase_if(log.structures, [&](const StructureRecord& record) { return record.scene == scene.scene; });
    std::vector<std::string> lost;
    if (cells > 0 || structures == 0) lost.push_back(fmt::format("{} cells", cells));
    if (structures > 0) lost.push_back(fmt::format("{} structures", structures));
    tell(fmt::format("{}; {} are not believed", wrong, joined(lost, " and ")));
  }
  return findings;
}

namespace {

// The cells of the last run, or of one before it of the same shard without a filter: a run with a filter may end where that one
// was stopped.
std::uint64_t planned_cells(const RunLog& log) {
  if (log.plans.empty()) return 0;
  const PlanRecord& last = log.plans.back();
  std::uint64_t cells = last.cells;
  for (const PlanRecord& plan : log.plans)
    if (plan.filter.empty() && plan.shards == last.shards && plan.shard == last.shard)
      cells = std::max<std::uint64_t>(cells, plan.cells);
  return cells;
}

}  // namespace

std::vector<std::string> missing_parts(const std::vector<RunLog>& logs, const std::vector<std::string>& directories,
                                       bool shards) {
  std::vector<std::string> findings;
  struct Shards {
    std::set<int> present;
    std::uint64_t cells = 0, all_cells = 0;
  };
  std::map<std::tuple<std::string, std::string, int>, Shards> runs;  // by experiment, filter and number of shards
  for (std::size_t i = 0; i < logs.size(); ++i) {
    const RunLog& log = logs[i];
    if (!log.finished) {
      const std::string planned = log.plans.empty() ? "" : fmt::format(" of {}", log.plans.back().cells);
      findings.push_back(fmt::format(
          "{}: the run has not finished, or its log was cut short: {}{} cells are there; the same `etendue run` goes on",
          directories[i], log.cell_count(), planned));
    } else if (const std::uint64_t planned = planned_cells(log); log.cell_count() < planned) {
      findings.push_back(
          fmt::format("{}: a run before was stopped, or lines of its log are missing: {} of {} cells are there; `etendue run` "
                      "without --filter makes the others",
                      directories[i], log.cell_count(), planned));
    }
    for (const PlanRecord& plan : log.plans) {
      Shards& run = runs[{plan.experiment_hash, plan.filter, plan.shards}];
      if (run.present.insert(plan.shard).second) run.cells += plan.cells;
      run.all_cells = plan.all_cells;
    }
  }
  if (!shards) return findings;
  for (const auto& [key, run] : runs) {
    const auto& [experiment, filter, count] = key;
    if (count > 1 && (runs.contains({experiment, filter, 1}) || runs.contains({experiment, "", 1})))
      continue;  // all of it is there
    for (int shard = 0; shard < count; ++shard)
      if (!run.present.contains(shard))
        findings.push_back(
            fmt::format("shard {}/{} is missing: {} of {} cells are in those that are there; expected its directory as well",
                        shard, count, run.cells, run.all_cells));
  }
  return findings;
}

}  // namespace etendue
