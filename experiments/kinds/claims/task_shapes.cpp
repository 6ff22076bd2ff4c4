#include "experiments/kinds/claims/task_shapes.h"

#include "framework/core/parallel.h"
#include "framework/core/sampler.h"
#include "framework/core/sampling.h"
#include "framework/transport/ray_tools.h"

#include <atomic>
#include <queue>

namespace etendue {

std::string_view task_shape_name(TaskShape shape) {
  constexpr std::string_view names[] = {"tiles", "pixels", "rows", "blocks", "samples"};
  return names[static_cast<int>(shape)];
}

void TaskRenderer::add_tasks(std::vector<ImageTask>& tasks, ivec2 size, int first_sample, int last_sample) const {
  for (int y = 0; y < resolution_.y; y += size.y)
    for (int x = 0; x < resolution_.x; x += size.x)
      tasks.push_back({{x, y}, glm::min(ivec2(x, y) + size, resolution_), first_sample, last_sample});
}

std::vector<ImageTask> TaskRenderer::cut(TaskShape shape) const {
  std::vector<ImageTask> tasks;
  switch (shape) {
    case TaskShape::tiles:
      add_tasks(tasks, ivec2(tile_size), 0, samples_);
      break;
    case TaskShape::pixels:
      add_tasks(tasks, ivec2(1), 0, samples_);
      break;
    case TaskShape::rows:
      add_tasks(tasks, {resolution_.x, 1}, 0, samples_);
      break;
    case TaskShape::blocks:
      add_tasks(tasks, (resolution_ + 3) / 4, 0, samples_);
      break;
    case TaskShape::samples:
      for (int s = 0; s < samples_; ++s) add_tasks(tasks, ivec2(1), s, s + 1);
      break;
  }
  return tasks;
}

template <class Closest>
float TaskRenderer::sample(ivec2 pixel, int index, const Closest& closest) const {
  const auto key = pixel_index(pixel, resolution_);
  Sampler sampler(SamplerKind::independent, seed_, Stream::camera, key, static_cast<std::uint32_t>(index));
  Ray ray = scene_.camera.ray(resolution_, vec2(pixel) + sampler.get_2d(), vec2(0.5f));
  float sum = 0;
  for (int bounce = 0;; ++bounce) {
    const Hit hit = closest(ray);
    if (!hit) break;
    sum += hit.t;
    if (bounce == bounces_) break;
    const SurfacePoint point = scene_.surface_at(ray, hit);
    const vec3 normal = glm::dot(ray.direction, point.normal) > 0 ? -point.normal : point.normal;
    ray = {.origin = ray_origin(point, normal),
           .direction = Frame::from_normal(normal).to_world(sample_cosine_hemisphere(sampler.get_2d()))};
  }
  return sum;
}

void TaskRenderer::run(const std::vector<ImageTask>& tasks, int threads) const {
  std::vector<float> image(static_cast<std::size_t>(resolution_.x) * static_cast<std::size_t>(resolution_.y), 0);
  std::atomic<std::size_t> next{0};
  const auto closest = [&](const Ray& ray) { return structure_.closest(ray); };
  parallel_for(static_cast<std::size_t>(threads), 1, [&](std::size_t) {
    for (std::size_t i; (i = next++) < tasks.size();) {
      const ImageTask& task = tasks[i];
      for (int y = task.begin.y; y < task.end.y; ++y)
        for (int x = task.begin.x; x < task.end.x; ++x) {
          float sum = 0;
          for (int s = task.first_sample; s < task.last_sample; ++s) sum += sample({x, y}, s, closest);
          // Single samples of a pixel may meet here; what they write is not asked for, only that it is written.
          std::atomic_ref(image[index(x, y, 0) / static_cast<std::size_t>(samples_)]).store(sum, std::memory_order_relaxed);
        }
    }
  });
}

std::vector<std::uint64_t> TaskRenderer::costs() const {
  std::vector<std::uint64_t> costs(index(resolution_.x - 1, resolution_.y - 1, samples_ - 1) + 1);
  for (int y = 0; y < resolution_.y; ++y)
    for (int x = 0; x < resolution_.x; ++x)
      for (int s = 0; s < samples_; ++s) {
        TraversalCounters counters;
        sample({x, y}, s, [&](const Ray& ray) { return structure_.closest_counted(ray, counters); });
        costs[index(x, y, s)] = counters.nodes + counters.primitives;
      }
  return costs;
}

double TaskRenderer::makespan(const std::vector<ImageTask>& tasks, const std::vector<std::uint64_t>& costs, int workers) const {
  std::priority_queue<std::uint64_t, std::vector<std::uint64_t>, std::greater<>> free_at;
  for (int i = 0; i < workers; ++i) free_at.push(0);
  std::uint64_t end = 0;
  for (const ImageTask& task : tasks) {
    std::uint64_t done = free_at.top();
    free_at.pop();
    for (int y = task.begin.y; y < task.end.y; ++y)
      for (int x = task.begin.x; x < task.end.x; ++x)
        for (int s = task.first_sample; s < task.last_sample; ++s) done += costs[index(x, y, s)];
    free_at.push(done);
    end = std::max(end, done);
  }
  return static_cast<double>(end);
}

double TaskRenderer::ideal(const std::vector<std::uint64_t>& costs, int workers) const {
  std::uint64_t sum = 0;
  for (const std::uint64_t cost : costs) sum += cost;
  return static_cast<double>(sum) / workers;
}

}  // namespace etendue
