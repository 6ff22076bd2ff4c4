// The directory an experiment writes: runs.jsonl, images/, references/, pictures/, and what `report` derives from them. One
// process writes it at a time, and it holds one experiment only.
//
// A file is on the disk before the log names it, with its size and hash; what the log says is believed only after the file was
// held against them.
#pragma once

#include "experiments/config/budget.h"
#include "experiments/log/log.h"
#include "experiments/run/file_lock.h"
#include "framework/image/film.h"

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace etendue {

// A file of the directory that is on disk.
struct StoredFile {
  std::string path;  // relative to the directory
  FileStamp stamp;
};

class RunObserver;  // run.h

class RunDirectory {
 public:
  // Makes the directory, locks it, reads what an earlier run left (`fresh`: deletes that), sets aside what of the log is
  // damaged, and appends manifest and plan if they are new ones. Throws Error where another process holds the lock, or where
  // the log is of another experiment or thread count: figures of both would be mixed. WriteError as all that follows. The
  // observer is warned of what is wrong with the log, and of what no longer counts.
  RunDirectory(const std::string& path, const ManifestRecord& manifest, const PlanRecord& plan, bool fresh,
               RunObserver& observer);

  const std::string& path() const { return path_; }
  const RunLog& earlier() const { return earlier_; }
  // Logs the scene as it is now. Where the log has it otherwise, what it holds of the scene is dropped, here and there.
  void note_scene(const std::string& scene, const std::string& path, std::uint64_t hash, const std::string& pixel_filter);
  // Reads the log anew: `earlier` has what this run has logged as well, then.
  void read_again();
  // Logs what the scene's cells are measured against from now on, if that is new. Where it is another than before, what was
  // measured against that one is dropped, here and there. To be called after read_again().
  void note_reference(const ReferenceRecord& record);
  // Finds the cells that are done and whose files are what the log says.
  std::set<CellName> believed_cells() const;
  bool has_structures(const std::string& scene, std::size_t count) const;

  StoredFile write_image(const CellName& cell, const Image& image, const std::map<std::string, std::string>& attributes);
  // Images one below the other, as `image` is named.
  StoredFile write_strip(const CellName& cell, const std::vector<Image>& images);
  StoredFile write_reference(const std::string& scene, const Image& image,
                             const std::map<std::string, std::string>& attributes);
  void append(const std::vector<std::string>& lines);
  // Notes that all that was to run did.
  void finish();

 private:
  std::string path_, manifest_id_;
  RunObserver& observer_;
  FileLock lock_;
  RunLog earlier_;
  std::unique_ptr<LogWriter> writer_;
  bool finished_ = false;
  bool follows_stopped_ = false;  // nobody knows for how long that one ran
  const double opened_ = now_s();
};

// Reads the log without touching the directory, for --dry-run and reports of progress; an empty log where there is none.
RunLog read_directory_log(const std::string& path);

}  // namespace etendue
