#include "experiments/kinds/claims/task_shapes.h"

#include "experiments/kinds/structures/accel_rays.h"
#include "framework/core/parallel.h"

#include <atomic>
#include <numeric>
#include <queue>

namespace etendue {

std::string_view task_shape_name(TaskShape shape) {
  constexpr std::string_view names[] = {"tiles", "pixels", "rows", "blocks", "samples"};
  return names[static_cast<int>(shape)];
}

std::vector<ImageTask> TaskRenderer::cut(TaskShape shape) const {
  const ivec2 sizes[] = {ivec2(tile_size), ivec2(1), {resolution_.x, 1}, (resolution_ + 3) / 4, ivec2(1)};
  const ivec2 size = sizes[static_cast<int>(shape)];
  const int at_once = shape == TaskShape::samples ? 1 : samples_;
  std::vector<ImageTask> tasks;
  for (int sample = 0; sample < samples_; sample += at_once)
    for (int y = 0; y < resolution_.y; y += size.y)
      for (int x = 0; x < resolution_.x; x += size.x)
        tasks.push_back({{x, y}, glm::min(ivec2(x, y) + size, resolution_), sample, sample + at_once});
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
    ray = cosine_bounce(scene_, ray, hit, sampler);
  }
  return sum;
}

void TaskRenderer::run(const std::vector<ImageTask>& tasks, int threads) const {
  std::vector<float> image(static_cast<std::size_t>(resolution_.x) * static_cast<std::size_t>(resolution_.y), 0);
  std::atomic<std::size_t> next{0};
  const auto closest = [&](const Ray& ray) { return structure_.closest(ray); };
  parallel_for(static_cast<std::size_t>(threads), 1, [&](std::size_t) {
    for (std::size_t i; (i = next++) < tasks.size();)
      for_pixels({tasks[i].begin, tasks[i].end}, [&](ivec2 pixel) {
        float sum = 0;
        for (int s = tasks[i].first_sample; s < tasks[i].last_sample; ++s) sum += sample(pixel, s, closest);
        // Single samples of a pixel may meet here; what they write is not asked for, only that it is written.
        std::atomic_ref(image[pixel_index(pixel, resolution_)]).store(sum, std::memory_order_relaxed);
      });
  });
}

std::vector<std::uint64_t> TaskRenderer::costs() const {
  std::vector<std::uint64_t> costs;
  for_pixels({ivec2(0), resolution_}, [&](ivec2 pixel) {
    for (int s = 0; s < samples_; ++s) {
      TraversalCounters counters;
      sample(pixel, s, [&](const Ray& ray) { return structure_.closest_counted(ray, counters); });
      costs.push_back(counters.nodes + counters.primitives);
    }
  });
  return costs;
}

double TaskRenderer::makespan(const std::vector<ImageTask>& tasks, const std::vector<std::uint64_t>& costs, int workers) const {
  std::priority_queue<std::uint64_t, std::vector<std::uint64_t>, std::greater<>> free_at;
  for (int i = 0; i < workers; ++i) free_at.push(0);
  std::uint64_t end = 0;
  for (const ImageTask& task : tasks) {
    std::uint64_t done = free_at.top();
    free_at.pop();
    for_pixels({task.begin, task.end}, [&](ivec2 pixel) {
      const std::size_t first = pixel_index(pixel, resolution_) * static_cast<std::size_t>(samples_);
      for (int s = task.first_sample; s < task.last_sample; ++s) done += costs[first + static_cast<std::size_t>(s)];
    });
    free_at.push(done);
    end = std::max(end, done);
  }
  return static_cast<double>(end);
}

double TaskRenderer::ideal(const std::vector<std::uint64_t>& costs, int workers) const {
  return static_cast<double>(std::accumulate(costs.begin(), costs.end(), std::uint64_t{0})) / workers;
}

}  // namespace etendue
