// An image as tasks: ways to divide it, the cost of each task, and the time until a number of workers have done all.
//
// A sample is a primary ray and a few diffuse bounces. Workers take tasks from one queue, in order.
#pragma once

#include "framework/query.h"
#include "framework/scene/scene.h"

#include <string_view>
#include <vector>

namespace etendue {

enum class TaskShape : std::uint8_t { tiles, pixels, rows, blocks, samples };
inline constexpr TaskShape task_shapes[] = {TaskShape::tiles, TaskShape::pixels, TaskShape::rows, TaskShape::blocks,
                                            TaskShape::samples};
std::string_view task_shape_name(TaskShape shape);

struct ImageTask {
  ivec2 begin, end;  // pixels, half open
  int first_sample = 0, last_sample = 0;
};

class TaskRenderer {
 public:
  // Scene and structure must outlive this.
  TaskRenderer(const Scene& scene, const RayQuery& structure, ivec2 resolution, int samples, int bounces, std::uint64_t seed)
      : scene_(scene), structure_(structure), resolution_(resolution), samples_(samples), bounces_(bounces), seed_(seed) {}

  // Tiles of 8 x 8; sixteen blocks; single samples pass by pass over the image.
  std::vector<ImageTask> cut(TaskShape shape) const;
  void run(const std::vector<ImageTask>& tasks, int threads) const;

  // Nodes and primitives that each sample's rays meet; by pixel, sample innermost.
  std::vector<std::uint64_t> costs() const;
  // When the last of `workers` is done, in units of cost.
  double makespan(const std::vector<ImageTask>& tasks, const std::vector<std::uint64_t>& costs, int workers) const;
  double ideal(const std::vector<std::uint64_t>& costs, int workers) const;

 private:
  template <class Closest>
  float sample(ivec2 pixel, int index, const Closest& closest) const;

  const Scene& scene_;
  const RayQuery& structure_;
  ivec2 resolution_;
  int samples_, bounces_;
  std::uint64_t seed_;
};

}  // namespace etendue
