// Embree 3 as a ray structure: the baseline that every user asks for ([Wald2014]). It is present where the library was
// found.
//
// Vertices are copied into a buffer of Embree's, quadrics become user geometry with our own test, instances are Embree's own.
// What it does not share with the other structures: ties in distance go to whichever primitive it tests last, and, unless
// `robust`, its triangle test may let a ray through an edge. Embree knows no coordinate beyond 1.844e18: larger triangles are
// not in it, and larger rays miss. Scenes of instances are asked ray by ray: Embree 3.13 never returns from rtcOccluded1M of
// some streams over them.
#pragma once

#include "accel/scene/memory_budget.h"
#include "framework/scene/scene.h"

#include <memory>
#include <span>
#include <string>

namespace etendue {

struct EmbreeParams {
  bool robust = false;
  std::string quality = "medium";
  std::string batches = "stream";
  const MemoryWatch* watch = nullptr;  // asked for whatever Embree would allot
};

template <class Visitor>
void describe(Visitor& v, EmbreeParams& params) {
  v.flag("robust", params.robust, "watertight triangle test (RTC_SCENE_FLAG_ROBUST)");
  v.choice("quality", params.quality, {"low", "medium", "high"},
           "of the build: Morton order, binned SAH, SAH with spatial splits");
  v.choice("batches", params.batches, {"single", "stream", "coherent"},
           "how Embree is asked for many rays at once: one by one (always where there are instances), as a stream, or as a "
           "stream said to be coherent");
}

class Embree {
 public:
  // Over all objects and instances; planes are not included. Throws Error where Embree fails, OverMemory where the watch does.
  // `scene` must outlive it.
  Embree(const Scene& scene, const EmbreeParams& params);

  Hit closest(const Ray& ray) const;
  bool occluded(const Ray& ray) const;
  // Where streams are asked for, Embree gathers rays into packets, whose triangle test may round otherwise than that of one
  // ray.
  void closest(std::span<const Ray> rays, std::span<Hit> hits) const;
  void occluded(std::span<const Ray> rays, std::span<bool> occluded) const;
  // Embree does not tell its work: nothing is counted.
  Hit closest_counted(const Ray& ray, TraversalCounters&) const { return closest(ray); }
  bool occluded_counted(const Ray& ray, TraversalCounters&) const { return occluded(ray); }
  RayStructureStats stats() const;

 private:
  struct State;
  std::shared_ptr<const State> state_;
};

struct RayEntry embree_entry();  // its row of the registry

}  // namespace etendue
