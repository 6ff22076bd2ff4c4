// Tells which parts of a log may be believed: its files are compared with the sizes and hashes it states, its scenes with the
// files they were read from, and its shards with their number.
#pragma once

#include "experiments/log/log.h"

#include <string>
#include <vector>

namespace etendue {

// Says what is wrong with the files that a cell of the log in `directory` names; "" where nothing is.
std::string damage(const CellRecord& cell, const std::string& directory);
std::string damage(KindRecord& record, const std::string& directory);
// Says what is wrong with its image; "" as well where none was kept.
std::string damage(const ReferenceRecord& reference, const std::string& directory);

// Marks as failed each cell whose files, reference or scene are not what the log says, each with its reason, leaves out the
// ray structures of such a scene, and returns what to tell. Paths in the log are relative to `directory` still. `scenes`: those
// that lie in files are read again where they are found from here.
std::vector<std::string> distrust(RunLog& log, const std::string& directory, bool scenes);

// Whether something of the runs is not there: a run that did not finish, or (`shards`) one that is not among the directories.
std::vector<std::string> missing_parts(const std::vector<RunLog>& logs, const std::vector<std::string>& directories,
                                       bool shards);

}  // namespace etendue
