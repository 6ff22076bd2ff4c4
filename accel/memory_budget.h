// The memory budget of a ray structure: what it may take at any time, its build included, beyond the scene itself.
//
// Three looks are taken. Before the build an estimate from the number of primitives (memory_need.h) refuses what cannot fit;
// during it, structures whose size follows from the shape of the scene, not from its count, tell a watch how far they have
// grown; after it the bytes are what they are. What does not fit gives way to the next of a ladder of leaner structures, and
// RayStructureStats::fallback says so, or is an error, as configured.
#pragma once

#include "framework/core/params.h"
#include "framework/query.h"

#include <exception>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace etendue {

// Bytes. `peak`: at most while it is built, what is kept included.
struct MemoryNeed {
  std::uint64_t kept = 0, peak = 0;
};

struct MemoryParams {
  std::uint64_t memory = 0;  // bytes; 0: without limit
  std::string over_memory = "leaner";
};

template <class Visitor>
void describe(Visitor& v, MemoryParams& params) {
  v.bytes("memory", params.memory, "budget beyond the scene, the build included; such as 512MiB");
  v.choice("over_memory", params.over_memory, {"leaner", "brute", "error"},
           "in the place of what exceeds it: the first that fits of a tree in wide16 and brute force, or brute force at once");
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
  // To be asked from any thread by whatever is being built, with all that it holds: throws OverMemory.
  void check(std::uint64_t bytes) const {
    if (!allows(bytes)) throw OverMemory();
  }
  // Not from several threads: a part is done and holds so much for good.
  void keep(std::uint64_t bytes) { kept_ += bytes; }

 private:
  std::uint64_t limit_, kept_ = 0;
};

struct MemoryRung {
  std::string name;
  MemoryNeed need;
  std::function<std::unique_ptr<RayQuery>(MemoryWatch*)> build;  // without limit where there is no watch
};

// Builds the first rung, which is what was asked for, or the first that fits; the last one whether it fits or not. With
// `over_memory` = "error" throws Error at `where`, naming the scene, if the first does not fit.
std::unique_ptr<RayQuery> build_within(const MemoryParams& params, const Location& where, const std::string& scene,
                                       std::span<const MemoryRung> rungs);

}  // namespace etendue
