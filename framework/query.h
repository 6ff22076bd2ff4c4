// The three questions a method asks of space, and the contract each structure signs.
//
//   RayQuery    which surface does this ray meet?
//   PointQuery  which photons lie near this point?
//   RecordQuery  which cached records cover this point?
//
// A structure is a plain class satisfying RayStructure, PointStructure or RecordStructure: no virtual function, no allocation
// per query. `RayAdapter` and its kin put it behind the interface, so an integrator pays one indirect call per query.
#pragma once

#include "framework/core/vec.h"

#include <concepts>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace etendue {

struct Ray {
  vec3 origin;
  float t_min = 0;  // not negative
  vec3 direction;   // need not be unit: t counts in its length
  float t_max = infinity;

  vec3 at(float t) const { return origin + t * direction; }
};

inline constexpr std::uint32_t no_id = 0xffffffffu;
inline constexpr std::uint32_t plane_instance = 0xfffffffeu;  // Hit::instance of an infinite plane

// `uv`: barycentric weights of a triangle's second and third vertex; a quadric's surface parameters in [0,1]^2.
// Ties in t go to the lowest (instance, primitive).
struct Hit {
  float t = infinity;
  vec2 uv{0};
  std::uint32_t instance = no_id;
  std::uint32_t primitive = no_id;

  explicit operator bool() const { return primitive != no_id; }
};

// Figures that a structure reports about itself.
struct RayStructureStats {
  std::uint64_t bytes = 0;  // all that the structure holds beyond the geometry it was built over
  std::uint64_t nodes = 0;
  std::uint64_t depth = 0;
  std::uint64_t references = 0;   // primitive references in leaves (more than primitives when a structure duplicates)
  double sah_cost = 0;            // expected cost of a random ray, 1 per node visit and primitive test; 0: not defined
  std::string_view layout = "-";  // how a tree lies in memory; "-" for structures that have one form only
  std::string fallback = {};      // what was built in place of the structure asked for, and why; empty: nothing replaced it
};

// Work of one traversal, filled by the counting variant only.
struct TraversalCounters {
  std::uint64_t nodes = 0;
  std::uint64_t primitives = 0;
};

class RayQuery {
 public:
  virtual ~RayQuery() = default;
  // The nearest hit with t in (t_min, t_max], or one with no primitive. NaN or infinite rays miss.
  virtual Hit closest(const Ray& ray) const = 0;
  virtual bool occluded(const Ray& ray) const = 0;
  // Many rays at once; each gets the answer it would get alone. The two spans have the same length.
  virtual void closest(std::span<const Ray> rays, std::span<Hit> hits) const = 0;
  virtual void occluded(std::span<const Ray> rays, std::span<bool> occluded) const = 0;
  // The nearest light with t in (t_min, t_max] that the ray passes: a surface that emits and does not stop it (Shape::mask).
  virtual Hit passed_light(const Ray& ray) const = 0;
  // The same answers; these add the nodes visited and primitives tested (0 where a structure cannot tell).
  virtual Hit closest_counted(const Ray& ray, TraversalCounters& counters) const = 0;
  virtual bool occluded_counted(const Ray& ray, TraversalCounters& counters) const = 0;
  virtual RayStructureStats stats() const = 0;

  // Set where this structure replaces another one: RayStructureStats::fallback.
  std::string fallback;
};

// A structure may also have closest and occluded over spans, where it answers many rays faster than one by one.
template <class S>
concept RayStructure = requires(const S& s, const Ray& ray, TraversalCounters& counters) {
  { s.closest(ray) } -> std::same_as<Hit>;
  { s.occluded(ray) } -> std::same_as<bool>;
  { s.closest_counted(ray, counters) } -> std::same_as<Hit>;
  { s.occluded_counted(ray, counters) } -> std::same_as<bool>;
  { s.stats() } -> std::same_as<RayStructureStats>;
};

template <RayStructure S>
class RayAdapter final : public RayQuery {
 public:
  explicit RayAdapter(S structure) : structure_(std::move(structure)) {}
  Hit closest(const Ray& ray) const override { return structure_.closest(ray); }
  bool occluded(const Ray& ray) const override { return structure_.occluded(ray); }
  void closest(std::span<const Ray> rays, std::span<Hit> hits) const override {
    if constexpr (requires { structure_.closest(rays, hits); })
      structure_.closest(rays, hits);
    else
      for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = structure_.closest(rays[i]);
  }
  void occluded(std::span<const Ray> rays, std::span<bool> occluded) const override {
    if constexpr (requires { structure_.occluded(rays, occluded); })
      structure_.occluded(rays, occluded);
    else
      for (std::size_t i = 0; i < rays.size(); ++i) occluded[i] = structure_.occluded(rays[i]);
  }
  Hit passed_light(const Ray&) const override { return {}; }
  Hit closest_counted(const Ray& ray, TraversalCounters& counters) const override {
    return structure_.closest_counted(ray, counters);
  }
  bool occluded_counted(const Ray& ray, TraversalCounters& counters) const override {
    return structure_.occluded_counted(ray, counters);
  }
  RayStructureStats stats() const override {
    RayStructureStats stats = structure_.stats();
    stats.fallback = fallback;
    return stats;
  }

 private:
  S structure_;
};

struct Neighbour {
  std::uint32_t id;
  float distance_squared;
};
using Neighbours = std::vector<Neighbour>;  // a caller's buffer: cleared by each query, its capacity kept

// Once built, any number of threads may query it at once.
class PointQuery {
 public:
  virtual ~PointQuery() = default;
  // The structure may keep a reference to `points`: they must outlive it unchanged. Points that are not finite are never found.
  virtual void build(std::span<const vec3> points) = 0;
  // Every point with squared distance <= r^2, in no particular order.
  virtual void within(const vec3& p, float r, Neighbours& out) const = 0;
  // The k nearest among those with squared distance <= r_max^2, nearest first; ties by lowest id.
  virtual void nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const = 0;
  virtual std::uint64_t bytes() const = 0;
};

template <class S>
concept PointStructure = requires(S& s, const S& c, std::span<const vec3> points, const vec3& p, Neighbours& out) {
  s.build(points);
  c.within(p, 1.0f, out);
  c.nearest(p, std::size_t{1}, 1.0f, out);
  { c.bytes() } -> std::same_as<std::uint64_t>;
};

template <PointStructure S>
class PointAdapter final : public PointQuery {
 public:
  explicit PointAdapter(S structure) : structure_(std::move(structure)) {}
  void build(std::span<const vec3> points) override { structure_.build(points); }
  void within(const vec3& p, float r, Neighbours& out) const override { structure_.within(p, r, out); }
  void nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const override {
    structure_.nearest(p, k, r_max, out);
  }
  std::uint64_t bytes() const override { return structure_.bytes(); }

 private:
  S structure_;
};

// Many readers or one writer: any number of threads may call `covering` at once while none is in `insert`, and each sees all
// insertions that happened before. Answers depend on the set of spheres alone, not on the order of insertion.
class RecordQuery {
 public:
  virtual ~RecordQuery() = default;
  virtual void insert(const vec3& centre, float radius, std::uint32_t id) = 0;
  // Every sphere with squared distance from its centre <= radius^2, sorted by id.
  virtual void covering(const vec3& p, Neighbours& out) const = 0;
  virtual std::uint64_t bytes() const = 0;
};

template <class S>
concept RecordStructure = requires(S& s, const S& c, const vec3& p, Neighbours& out) {
  s.insert(p, 1.0f, 0u);
  c.covering(p, out);
  { c.bytes() } -> std::same_as<std::uint64_t>;
};

template <RecordStructure S>
class RecordAdapter final : public RecordQuery {
 public:
  explicit RecordAdapter(S structure) : structure_(std::move(structure)) {}
  void insert(const vec3& centre, float radius, std::uint32_t id) override { structure_.insert(centre, radius, id); }
  void covering(const vec3& p, Neighbours& out) const override { structure_.covering(p, out); }
  std::uint64_t bytes() const override { return structure_.bytes(); }

 private:
  S structure_;
};

}  // namespace etendue
