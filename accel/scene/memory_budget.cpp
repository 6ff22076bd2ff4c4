#include "accel/scene/memory_budget.h"

#include "framework/core/check.h"
#include "framework/core/error.h"
#include "framework/core/units.h"

#include <fmt/core.h>

namespace etendue {

namespace {

std::string size_text(std::uint64_t bytes) { return format_bytes(static_cast<double>(bytes)); }

// Says why a rung does not fit. If it does, the text is empty and `built` is the structure.
std::string try_rung(const MemoryRung& rung, std::uint64_t limit, std::unique_ptr<RayQuery>& built) {
  if (rung.need.peak > limit)
    return fmt::format("{} would take about {}, of which it would keep {}", rung.name, size_text(rung.need.peak),
                       size_text(rung.need.kept));
  try {
    MemoryWatch watch(limit);
    built = rung.build(&watch);
  } catch (const OverMemory&) {
    return fmt::format("{} grew beyond it while it was built", rung.name);
  }
  const std::uint64_t bytes = built->stats().bytes;
  if (bytes <= limit) return {};
  built.reset();
  return fmt::format("{} took {}", rung.name, size_text(bytes));
}

}  // namespace

std::unique_ptr<RayQuery> build_within(const MemoryParams& params, const Location& where, const std::string& scene,
                                       std::span<const MemoryRung> rungs) {
  CHECK(!rungs.empty());
  std::unique_ptr<RayQuery> built;
  const std::string why = try_rung(rungs[0], params.memory, built);
  if (why.empty()) return built;
  const std::string told = fmt::format("beyond its memory of {}: {}", size_text(params.memory), why);
  if (params.over_memory == "error")
    throw Error(where, fmt::format("{}: {}; expected a larger memory, or over_memory = \"leaner\" or \"brute\"", scene, told));
  const auto stands_in = [&](const MemoryRung& rung, const char* remark) {
    built->fallback = fmt::format("{}; {} in its place, {}{}", told, rung.name, size_text(built->stats().bytes), remark);
    return std::move(built);
  };
  for (const MemoryRung& rung : rungs.subspan(1))
    if (&rung != &rungs.back() && try_rung(rung, params.memory, built).empty()) return stands_in(rung, "");
  const MemoryRung& last = rungs.back();
  built = last.build(nullptr);
  const bool fits = last.need.peak <= params.memory && built->stats().bytes <= params.memory;
  if (rungs.size() > 1) return stands_in(last, fits ? "" : ", beyond it too, but there is nothing leaner");
  built->fallback = told + "; built nonetheless, as there is nothing leaner";
  return built;
}

}  // namespace etendue
