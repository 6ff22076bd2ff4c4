#include "experiments/harness/log.h"

#include "experiments/harness/json_line.h"
#include "experiments/harness/log_lines.h"
#include "framework/core/error.h"
#include "framework/io/text.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iterator>

namespace etendue {

namespace {

// Appends a record, or replaces the one that is the same by `same`.
template <class Record, class Same>
void put(std::vector<Record>& records, Record record, const Same& same) {
  const auto found = std::find_if(records.begin(), records.end(), [&](const Record& other) { return same(other, record); });
  if (found == records.end())
    records.push_back(std::move(record));
  else
    *found = std::move(record);
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
// Animations, claims and searches: a record each for a cell.
template <class Record>
void put_by_cell(std::vector<Record>& records, Record record) {
  put(records, std::move(record), [](const auto& a, const auto& b) { return a.cell == b.cell; });
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
  try {
    return read_file(path);
  } catch (const Error& e) {
    throw Error(Location{path},
                fmt::format("cannot open the log; expected a runs.jsonl that `etendue run` wrote: {}", e.what()));
  }
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
        put_by_cell(log.animations, read_animation_line(text.substr(begin, end - begin)));
      } else if (type == "claim") {
        put_by_cell(log.claims, read_claim_line(text.substr(begin, end - begin)));
      } else if (type == "rates") {
        log.rates = read_rate_line(text.substr(begin, end - begin));
      } else if (type == "search") {
        put_by_cell(log.searches, read_search_line(text.substr(begin, end - begin)));
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
    for (const auto& record : log.animations) put_by_cell(merged.animations, record);
    for (const auto& record : log.claims) put_by_cell(merged.claims, record);
    merged.rates.merge(log.rates);
    for (const auto& record : log.searches) put_by_cell(merged.searches, record);
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
