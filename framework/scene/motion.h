// Motions that animate a geometry frame by frame: deformations of its surface, and rigid transforms of objects it is cut into.
//
//   wave     a travelling wave along x and z lifts and lowers the surface, or the part of it at one end of its longest axis
//   twist    about the vertical axis, by an angle that grows with height and time
//   explode  objects fly outward, spinning
//   scatter  some objects, others each frame, are put at random places in the geometry's box, turned at random
//
// Objects are as many runs of primitives that lie together, equal in number: the geometry halved again and again at the median
// of its primitives' centres. Their vertices are their own.
#pragma once

#include "framework/core/params.h"
#include "framework/scene/geometry.h"

#include <functional>
#include <memory>
#include <span>

namespace etendue {

class Motion {
 public:
  virtual ~Motion() = default;
  // The geometry at frame 0. Motions of objects split vertices that objects share; triangles stay in their order.
  virtual const Geometry& rest() const = 0;
  // Takes a geometry from the frame before to `frame` (1, 2, …, in order; the first starts from rest()) and gives the ids of
  // the primitives that moved, ascending.
  virtual std::vector<std::uint32_t> pose(int frame, Geometry& geometry) = 0;
};

struct MotionTask {
  const Geometry& geometry;
  int frames = 1;  // over which motions with an end reach it
  std::uint64_t seed = 1;
};

struct MotionEntry {
  std::string name, summary;
  std::vector<ParamInfo> params;
  std::function<std::unique_ptr<Motion>(const MotionTask&, const ParamMap&)> make;
};

// A row of the table, for a class constructed from a task and its parameters.
template <class M, class Params>
MotionEntry motion_entry(const char* name, const char* summary) {
  const auto make = [name](const MotionTask& task, const ParamMap& map) -> std::unique_ptr<Motion> {
    return std::make_unique<M>(task, read_params<Params>(map, name));
  };
  return {name, summary, list_params<Params>(), make};
}

std::span<const MotionEntry> motions();
const MotionEntry& find_motion(const std::string& name, const Location& where);  // throws Error

// The rows of the table, by file.
MotionEntry wave_entry();
MotionEntry twist_entry();
MotionEntry explode_entry();
MotionEntry scatter_entry();

// The point that places a quadric: its centre, or a cylinder's base.
const vec3& anchor(const Quadric& quadric);
Bounds bounds_of(const Geometry& geometry);  // of the valid primitives; a single point if there are none

}  // namespace etendue
