#include "experiments/log/log.h"

#include "experiments/config/cells.h"
#include "experiments/log/json_line.h"
#include "framework/core/check.h"
#include "framework/core/error.h"
#include "framework/io/text.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <tuple>
#include <typeindex>

namespace etendue {

std::string dump(const Json& json, int indent) { return json.dump(indent, ' ', false, Json::error_handler_t::replace); }

void throw_not_whole(const Json& json) {
  throw nlohmann::detail::type_error::create(302, "expected a whole number in range, not " + dump(json), &json);
}

namespace {

// The last of several records with one key counts.
auto key(const ManifestRecord& r) { return std::tie(r.id); }
auto key(const SceneRecord& r) { return std::tie(r.scene); }
auto key(const ReferenceRecord& r) { return std::tie(r.scene); }
auto key(const StructureRecord& r) { return std::tie(r.scene, r.structure, r.layout); }
auto key(const ProductsRecord& r) { return std::tie(r.scene, r.accel, r.integrator, r.region, r.at_checkpoints); }
std::tuple<std::type_index, const CellName&> key(const std::shared_ptr<KindRecord>& record) {
  const KindRecord& r = *record;
  return {typeid(r), r.cell};
}

template <class Record>
void put(std::vector<Record>& records, Record record) {
  find_or_add(
      records, [&](const Record& r) { return key(r) == key(record); }, record) = record;
}

void put(std::vector<PlanRecord>& plans, PlanRecord record) {
  std::erase(plans, record);
  plans.push_back(std::move(record));
}

template <class Record>
void put_all(std::vector<Record>& records, const std::vector<Record>& others) {
  for (const Record& record : others) put(records, record);
}

// A cell's checkpoints and closing line, in the place of any that it left before.
class CellBlocks {
 public:
  void put(const CellRecord& cell, std::vector<CheckpointRecord> checkpoints) {
    const auto [found, inserted] = position_.try_emplace(cell.cell, blocks_.size());
    if (inserted) blocks_.emplace_back();
    blocks_[found->second] = {cell, std::move(checkpoints)};
  }
  void drop_scene(const std::string& scene) {
    std::vector<Block> kept;
    position_.clear();
    for (Block& block : blocks_) {
      if (block.first.cell.scene == scene) continue;
      position_[block.first.cell] = kept.size();
      kept.push_back(std::move(block));
    }
    blocks_ = std::move(kept);
  }
  void move_into(RunLog& log) {
    for (auto& [cell, checkpoints] : blocks_) {
      log.cells.push_back(std::move(cell));
      std::move(checkpoints.begin(), checkpoints.end(), std::back_inserter(log.checkpoints));
    }
  }

 private:
  using Block = std::pair<CellRecord, std::vector<CheckpointRecord>>;
  std::map<CellName, std::size_t> position_;
  std::vector<Block> blocks_;
};

// Tells where cells of several logs would stand in the log of one process.
class CellPlaces {
 public:
  void add(const RunLog& log) {
    const PlanRecord plan = log.plans.empty() ? PlanRecord{} : log.plans.back();
    const bool is_shard = plan.shard >= 0 && plan.shard < plan.shards && plan.shards > 1 && plan.shards <= most_shards;
    const Shard shard = is_shard ? Shard{plan.shard, plan.shards} : Shard{};
    const std::string run = is_shard ? fmt::format("{} {} {}", plan.experiment_hash, plan.filter, plan.shards)
                                     : fmt::format("log {}", runs_.size());
    const std::size_t of_run = runs_.try_emplace(run, runs_.size()).first->second;
    std::size_t next = 0;
    const auto place = [&](const CellName& cell) {
      while (!in_shard(next, shard)) ++next;
      if (places_.try_emplace(cell, of_run, next).second) ++next;
    };
    for (const CellRecord& record : log.cells) place(record.cell);
    for (const auto& record : log.records) place(record->cell);
  }
  void sort(RunLog& log) const {
    std::ranges::stable_sort(log.cells, {}, [&](const CellRecord& record) { return places_.at(record.cell); });
    std::ranges::stable_sort(log.records, {}, [&](const auto& record) { return places_.at(record->cell); });
  }

 private:
  static constexpr int most_shards = 1'000'000;  // of more, places are not worth the time

  std::map<std::string, std::size_t> runs_;                         // their order
  std::map<CellName, std::pair<std::size_t, std::size_t>> places_;  // run, and place there
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

// Measures the log without a torn last line and without checkpoints that no `cell` line closed. Both come from a write that
// was cut short, so they stand at the end.
std::size_t whole_length(const std::string& text) {
  std::size_t kept = 0;
  for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    if (std::string_view(text).substr(begin, end - begin).find("\"type\":\"checkpoint\"") == std::string_view::npos)
      kept = end + 1;
  }
  return kept;
}

constexpr std::string_view checksum_start = ",\"xxh3\":\"", checksum_end = "\"}";
constexpr std::size_t checksum_digits = 16;

// Throws Error where a line is not what was written.
void check_seal(std::string_view line) {
  const std::size_t length = checksum_start.size() + checksum_digits + checksum_end.size();
  const std::string_view body = line.substr(0, line.size() - std::min(line.size(), length)), end = line.substr(body.size());
  if (end.size() != length || !end.starts_with(checksum_start) || !end.ends_with(checksum_end))
    throw Error("bad record: no checksum; expected a line that `etendue run` wrote");
  if (end.substr(checksum_start.size(), checksum_digits) != hash_text(body))
    throw Error("bad record: the checksum is wrong, so the line is not as `etendue run` wrote it");
}

class LogReader {
 public:
  RunLog read(const std::string& path, std::vector<DamagedLine>* damaged) {
    const std::string text = read_all(path);
    int number = 0;
    for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
      ++number;
      try {
        take(text.substr(begin, end - begin));
      } catch (const std::exception& e) {  // of ours, and of the JSON library
        const bool ours = dynamic_cast<const Error*>(&e) != nullptr;
        const std::string what =
            ours ? e.what() : fmt::format("bad record: {}; expected a line that `etendue run` wrote", e.what());
        const Error error(Location{path, number}, what);
        if (damaged == nullptr) throw error;
        damaged->push_back({number, error.what()});
        log_.finished = false;
      }
    }
    log_.torn = whole_length(text) < text.size();
    if (log_.torn) log_.finished = false;
    if (!log_.finished) log_.took_s = 0;
    blocks_.move_into(log_);
    return std::move(log_);
  }

 private:
  void take(const std::string& line) {
    check_seal(line);
    const Json json = Json::parse(line);
    const std::string type = json.at("type");
    log_.finished = type == "finished";
    if (log_.finished) {
      is_timed_ = is_timed_ && json.contains("took_s");
      log_.took_s = is_timed_ ? log_.took_s + json.value("took_s", 0.0) : 0;
    }
    if (!log_.finished)
      take_as<ManifestRecord, PlanRecord, SceneRecord, ReferenceRecord, StructureRecord, StatedRecord, CheckpointRecord,
              CellRecord, ProductsRecord>(type, json);
  }

  // The line is one of these records or of a kind's.
  template <class... Records>
  void take_as(const std::string& type, const Json& json) {
    const auto is_taken = [&]<class Record>(std::type_identity<Record>) {
      if (type != Record::line_type) return false;
      take(read_record<Record>(json));
      return true;
    };
    if ((is_taken(std::type_identity<Records>()) || ...)) return;
    if (auto record = read_kind_record(type, json)) {
      put(log_.records, std::move(record));
      return;
    }
    std::vector<std::string> types = kind_record_types();
    (types.emplace_back(Records::line_type), ...);
    types.emplace_back("finished");
    throw Error(unknown_name("record", type, types));
  }

  void take(ManifestRecord record) { put(log_.manifests, std::move(record)); }
  void take(PlanRecord record) { put(log_.plans, std::move(record)); }
  void take(StructureRecord record) { put(log_.structures, std::move(record)); }
  void take(ProductsRecord record) { put(log_.products, std::move(record)); }
  void take(StatedRecord record) { log_.stated = std::move(record); }
  void take(CheckpointRecord record) { open_[record.cell].push_back(std::move(record)); }

  void take(const CellRecord& record) {
    std::vector<CheckpointRecord> checkpoints = std::move(open_[record.cell]);
    open_.erase(record.cell);
    if (record.checkpoints) {
      if (checkpoints.size() < *record.checkpoints)
        throw Error(fmt::format("bad record: {} of the cell's {} checkpoints stand before it", checkpoints.size(),
                                *record.checkpoints));
      // What stands before them is left of a block whose end is gone.
      checkpoints.erase(checkpoints.begin(), checkpoints.end() - static_cast<std::ptrdiff_t>(*record.checkpoints));
    }
    blocks_.put(record, std::move(checkpoints));
  }

  void take(SceneRecord record) {
    const SceneRecord* known = log_.scene(record.scene);
    if (known == nullptr || known->hash != record.hash) drop_scene(record.scene);
    put(log_.scenes, std::move(record));
  }

  void take(ReferenceRecord record) {
    const ReferenceRecord* known = log_.reference(record.scene);
    if (known == nullptr || known->stamp != record.stamp) {
      blocks_.drop_scene(record.scene);
      std::erase_if(log_.records, [&](const auto& other) { return other->uses_reference_of(record.scene); });
    }
    put(log_.references, std::move(record));
  }

  // Drops what was logged of a scene that has changed since.
  void drop_scene(const std::string& scene) {
    blocks_.drop_scene(scene);
    std::erase_if(log_.references, [&](const auto& record) { return record.scene == scene; });
    std::erase_if(log_.structures, [&](const auto& record) { return record.scene == scene; });
    std::erase_if(log_.records, [&](const auto& record) { return record->cell.is_of(scene); });
  }

  RunLog log_;
  bool is_timed_ = true;
  CellBlocks blocks_;
  std::map<CellName, std::vector<CheckpointRecord>> open_;
};

}  // namespace

std::string CellName::key() const { return fmt::format("{} | {} | {} | seed={}", scene, accel, integrator, seed); }

std::string sealed(const std::string& line) {
  CHECK(line.ends_with('}'));
  const std::string body = line.substr(0, line.size() - 1);
  return fmt::format("{}{}{}{}", body, checksum_start, hash_text(body), checksum_end);
}

RunLog read_log(const std::string& path) { return LogReader().read(path, nullptr); }

RunLog read_log(const std::string& path, std::vector<DamagedLine>& damaged) { return LogReader().read(path, &damaged); }

void set_aside(const std::string& path, const std::vector<DamagedLine>& damaged) {
  if (damaged.empty()) return;
  const std::string text = read_all(path), beside = path + ".damaged";
  std::string kept, removed = std::filesystem::exists(beside) ? read_all(beside) : "";
  int number = 0;
  auto next = damaged.begin();
  for (std::size_t begin = 0, end; begin < text.size(); begin = end) {
    end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    const bool bad = next != damaged.end() && next->line == ++number;
    (bad ? removed : kept).append(text, begin, end - begin);
    if (bad) ++next;
  }
  write_whole_file(beside, removed);
  write_whole_file(path, kept);
}

void add_products(RunLog& log, ProductsRecord record) { put(log.products, std::move(record)); }

RunLog merge_logs(const std::vector<RunLog>& logs) {
  RunLog merged;
  merged.finished = !logs.empty();
  CellBlocks blocks;
  CellPlaces places;
  bool is_timed = true;
  for (const RunLog& log : logs) {
    places.add(log);
    merged.finished = merged.finished && log.finished;
    merged.torn = merged.torn || log.torn;
    is_timed = is_timed && log.took_s > 0;
    merged.took_s = is_timed ? merged.took_s + log.took_s : 0;
    put_all(merged.manifests, log.manifests);
    put_all(merged.plans, log.plans);
    put_all(merged.scenes, log.scenes);
    put_all(merged.references, log.references);
    put_all(merged.structures, log.structures);
    put_all(merged.products, log.products);
    put_all(merged.records, log.records);
    merged.stated.merge(log.stated);
    std::map<CellName, std::vector<CheckpointRecord>> checkpoints;
    for (const auto& record : log.checkpoints) checkpoints[record.cell].push_back(record);
    for (const auto& record : log.cells) blocks.put(record, std::move(checkpoints[record.cell]));
  }
  blocks.move_into(merged);
  places.sort(merged);
  return merged;
}

LogWriter::LogWriter(const std::string& path) : path_(path) {
  const bool is_new = !std::filesystem::exists(path);
  file_ = open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file_ < 0) throw WriteError(Location{path}, "cannot write the log: " + system_error());
  try {
    if (is_new) sync_folder(std::filesystem::path(path).parent_path().string());
    const std::string text = read_all(path);
    const std::size_t kept = whole_length(text);
    if (kept < text.size() && (ftruncate(file_, static_cast<off_t>(kept)) != 0 || fsync(file_) != 0))
      throw WriteError(Location{path}, "cannot cut the log's torn end: " + system_error());
  } catch (const Error&) {
    close(file_);
    throw;
  }
}

LogWriter::~LogWriter() { close(file_); }

void LogWriter::append(const std::vector<std::string>& lines) {
  std::string block;
  for (const std::string& line : lines) block += sealed(line) + '\n';
  const off_t before = lseek(file_, 0, SEEK_END);
  const auto take_back = [&](std::string why) {
    if (ftruncate(file_, before) != 0) why += "; nor can the torn line be cut off";  // or the next one would begin in it
    throw WriteError(Location{path_}, "cannot write the log: " + why);
  };
  // A write to a file is cut short only by a full disk or a signal: go on from there, so that the block is whole or torn last.
  for (std::size_t written = 0; written < block.size();) {
    const ssize_t n = write(file_, block.data() + written, block.size() - written);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) take_back(system_error());
    written += static_cast<std::size_t>(n);
  }
  if (fsync(file_) != 0) take_back("cannot be flushed to disk: " + system_error());
}

}  // namespace etendue
