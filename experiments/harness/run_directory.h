// The directory an experiment writes: runs.jsonl, images/, references/, and what `report` derives from them. One process writes
// it at a time, and it holds one experiment only.
#pragma once

#include "experiments/harness/file_lock.h"
#include "experiments/harness/log.h"
#include "framework/image/film.h"

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace etendue {

class RunDirectory {
 public:
  // Makes the directory, locks it, reads what an earlier run left (`fresh`: deletes that) and appends the manifest if it is a
  // new one. Throws Error where another process holds the lock, or where the log is of another experiment or thread count:
  // figures of both would be mixed.
  RunDirectory(const std::string& path, const ManifestRecord& manifest, bool fresh);

  const std::string& path() const { return path_; }
  const RunLog& earlier() const { return earlier_; }
  bool is_done(const CellName& cell) const { return done_.contains(cell); }
  bool has_structures(const std::string& scene, std::size_t count) const;

  // Relative path of an image; written whole or not at all.
  std::string write_image(const CellName& cell, const Image& image, const std::map<std::string, std::string>& attributes);
  // Images one below the other, as `image` is named.
  std::string write_strip(const CellName& cell, const std::vector<Image>& images);
  std::string write_reference(const std::string& scene, const Image& image,
                              const std::map<std::string, std::string>& attributes);
  void append(const std::vector<std::string>& lines) { writer_->append(lines); }

 private:
  std::string path_;
  FileLock lock_;
  RunLog earlier_;
  std::set<CellName> done_;
  std::unique_ptr<LogWriter> writer_;
};

// Reads the log without touching the directory, for --dry-run and reports of progress; an empty log where there is none.
RunLog read_directory_log(const std::string& path);

}  // namespace etendue
