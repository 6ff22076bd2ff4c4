// The memory budget of a ray structure: what it may take at any time, its build included, beyond the scene itself.
//
// The budget is checked three times. Before the build, an estimate from the number of primitives (memory_need.h) rejects what
// cannot fit. During it, structures whose size depends on the shape of the scene report to a watch how far they have grown.
// After it, the actual bytes are compared. A structure that does not fit is replaced by the next in a ladder of leaner ones,
// and RayStructureStats::fallback says so; or it is an error, as configured.
#pragma once

#include "framework/core/params.h"
#include "framework/query.h"

#include <exception>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace etendue {

// Bytes. `peak`: the most held during the build, including what is kept.
struct MemoryNeed {
  std::uint64_t kept = 0, peak = 0;
};

// The references to primitives that a spatial structure may hold, for each primitive.
inline constexpr std::uint64_t references_per_primitive = 32;

struct MemoryParams {
  std::uint64_t memory = 0;  // bytes; 0: without limit
  std::string over_memory = "leaner";
};

template <class Visitor>
void describe(Visitor& v, MemoryParams& params) {
  v.bytes("memory", params.memory, "budget beyond the scene, the build included; such as 512MiB");
  v.choice("over_memory", params.over_memory, {"leaner", "brute", "error"},
           "in the place of what exceeds it: the first that fits of a tree in bvh16 and brute force, or brute force at once");
}

// A structure's parameters with the two of its budget.
template <class Params>
struct WithMemory : Params {
  MemoryParams budget;
};

template <class Visitor, class Params>
void describe(Visitor& v, WithMemory<Params>& params) {
  describe(v, static_cast<Params&>(params));
  describe(v, params.budget);
}

// Thrown through a build that grew beyond its budget; build_within catches it.
class OverMemory : public std::exception {
 public:
  const char* what() const noexcept override { return "a ray structure grew beyond its memory budget"; }
};

class MemoryWatch {
 public:
  explicit MemoryWatch(std::uint64_t limit) : limit_(limit) {}

  bool allows(std::uint64_t bytes) const { return bytes <= limit_ && kept_ <= limit_ - bytes; }
  // Called from any thread by a structure under construction, with all bytes that it holds. Throws OverMemory.
  void check(std::uint64_t bytes) const {
    if (!allows(bytes)) throw OverMemory();
  }
  // A part is finished and keeps so many bytes. Several threads must not call this at once.
  void keep(std::uint64_t bytes) { kept_ += bytes; }

 private:
  std::uint64_t limit_, kept_ = 0;
};

struct MemoryRung {
  std::string name;
  MemoryNeed need;
  std::function<std::unique_ptr<RayQuery>(MemoryWatch*)> build;  // a null watch: no limit
};

// Builds the first rung, the structure asked for, or else the first that fits; the last one in any case. With `over_memory` =
// "error" throws Error at `where`, naming the scene, if the first does not fit.
std::unique_ptr<RayQuery> build_within(const MemoryParams& params, const Location& where, const std::string& scene,
                                       std::span<const MemoryRung> rungs);

}  // namespace etendue
