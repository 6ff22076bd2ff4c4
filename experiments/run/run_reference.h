// The reference that a run measures a scene against, kept in its directory and named in its log.
#pragma once

#include "experiments/run/reference.h"
#include "experiments/run/run_directory.h"

namespace etendue {

// Makes the reference as make_reference does, and notes it. A run goes on with the file that its cells were measured against
// as long as that is whole; the observer, which the request names, is warned where it is not. Where it is another than before,
// what was measured against that one is dropped (RunDirectory::note_reference).
Reference make_run_reference(RunDirectory& directory, ReferenceRequest request, const ReferenceCache& cache);

}  // namespace etendue
