// What ran: the program, how it was built, and the machine.
#pragma once

#include "experiments/log/log.h"

#include <string>

namespace etendue {

// The record comes with its id. `title` and `experiment_hash` may be empty (a single render).
ManifestRecord make_manifest(const std::string& title, const std::string& experiment_hash, int threads);

std::string version_text();  // "etendue 0.1.0 (commit)"

}  // namespace etendue
