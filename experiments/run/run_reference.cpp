#include "experiments/run/run_reference.h"

#include "experiments/log/trust.h"
#include "experiments/run/run.h"

#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <new>

namespace etendue {

namespace {

// Nothing has been measured by a reference that was refused.
bool is_measured_against(const RunLog& log, const std::string& scene) {
  return std::ranges::any_of(log.cells, [&](const CellRecord& c) { return c.cell.scene == scene && c.status == "done"; }) ||
         std::ranges::any_of(log.records, [&](const auto& r) { return r->done() && r->uses_reference_of(scene); });
}

}  // namespace

Reference make_run_reference(RunDirectory& directory, ReferenceRequest request, const ReferenceCache& cache) {
  directory.read_again();
  const ReferenceRecord* known = directory.earlier().reference(request.name);
  const std::string wrong = known != nullptr ? damage(*known, directory.path()) : "";
  if (!wrong.empty()) request.observer->warn(fmt::format("{}: the reference {}; it is made again", request.name, wrong));
  if (known != nullptr && wrong.empty() && is_measured_against(directory.earlier(), request.name))
    request.earlier = (std::filesystem::path(directory.path()) / known->file).string();
  Reference reference;
  try {
    reference = make_reference(request, cache);
  } catch (const std::bad_alloc&) {
    reference.failure = fmt::format("no reference of {}: out of memory", request.name);
  }
  const RenderedReference& rendered = reference.rendered;
  if (rendered.image.pixels.empty() || reference.earlier) return reference;  // where there is none, its cells will say why
  const StoredFile file = directory.write_reference(request.name, rendered.image, reference_attributes(rendered));
  directory.note_reference(reference_record(request.name, request.scene, rendered, file.path, file.stamp));
  return reference;
}

}  // namespace etendue
