#include "integrators/visible_region.h"

#include "framework/core/parallel.h"
#include "framework/transport/bsdf.h"
#include "framework/transport/ray_tools.h"
#include "integrators/path.h"

#include <bit>

namespace etendue {

VisibleRegion::VisibleRegion(const Bounds& bounds, float reach) {
  const vec3 extent = bounds.empty() ? vec3(0) : bounds.diagonal();
  const float longest = std::max(max_component(extent), std::numeric_limits<float>::min());
  lower_ = bounds.empty() ? vec3(0) : bounds.lower;
  cells_per_metre_ = 1 / std::max(0.5f * reach, longest / 256);
  size_ = uvec3(glm::clamp(extent * cells_per_metre_, vec3(0), vec3(255))) + 1u;
  bits_ = std::vector<std::atomic<std::uint64_t>>((static_cast<std::size_t>(size_.x) * size_.y * size_.z + 63) / 64);
}

uvec3 VisibleRegion::cell(const vec3& position) const {
  return uvec3(glm::clamp((position - lower_) * cells_per_metre_, vec3(0), vec3(size_ - 1u)));
}

void VisibleRegion::mark(const vec3& position, float radius) {
  const uvec3 begin = cell(position - radius), end = cell(position + radius);
  for (unsigned z = begin.z; z <= end.z; ++z)
    for (unsigned y = begin.y; y <= end.y; ++y)
      for (unsigned x = begin.x; x <= end.x; ++x) {
        const std::size_t i = bit({x, y, z});
        const std::uint64_t mask = std::uint64_t{1} << i % 64;
        auto& word = bits_[i / 64];
        if (!(word.load(std::memory_order_relaxed) & mask)) word.fetch_or(mask, std::memory_order_relaxed);
      }
}

bool VisibleRegion::contains(const vec3& position) const {
  const std::size_t i = bit(cell(position));
  return bits_[i / 64].load(std::memory_order_relaxed) >> i % 64 & 1;
}

double VisibleRegion::share() const {
  std::size_t marked = 0;
  for (const auto& word : bits_) marked += static_cast<std::size_t>(std::popcount(word.load(std::memory_order_relaxed)));
  return static_cast<double>(marked) / (static_cast<double>(size_.x) * size_.y * size_.z);
}

namespace {

class Eye {
 public:
  Eye(const RenderContext& context, const Receivers& receivers, const SeenOptions& options, VisibleRegion& region)
      : context_(context), receivers_(receivers), options_(options), region_(region) {}

  // Marks the receivers along a ray, through what carries; or, with gather rays, what those see from there.
  void look(Ray ray, int depth, int gather_rays, Sampler& sampler) {
    for (; depth < options_.max_depth; ++depth) {
      const Hit hit = trace(context_, ray);
      if (!hit) return;
      const SurfacePoint point = context_.scene.surface_at(ray, hit);
      const Bsdf bsdf(context_.scene, point);
      const bool receiver = receivers_(point.material);
      if (receiver && gather_rays == 0) region_.mark(point.position, options_.reach);
      for (int i = 0; receiver && i < gather_rays; ++i) {
        const BsdfSample scattered = scatter(bsdf, ray, sampler);
        if (scattered && !scattered.specular) look(spawn_ray(point, scattered.wi), depth + 1, 0, sampler);
      }
      if (receiver && !bsdf.has_specular()) return;
      const BsdfSample scattered = scatter(bsdf, ray, sampler);
      if (!scattered || (receiver && !scattered.specular)) return;
      ray = spawn_ray(point, scattered.wi);
    }
  }

 private:
  static BsdfSample scatter(const Bsdf& bsdf, const Ray& ray, Sampler& sampler) {
    const float u_lobe = sampler.get_1d();
    return bsdf.sample(-ray.direction, u_lobe, sampler.get_2d());
  }

  const RenderContext& context_;
  const Receivers& receivers_;
  const SeenOptions& options_;
  VisibleRegion& region_;
};

}  // namespace

std::unique_ptr<VisibleRegion> find_seen(const RenderContext& context, const Receivers& receivers, const SeenOptions& options) {
  auto region = std::make_unique<VisibleRegion>(context.scene.bounds(), options.reach);
  parallel_pixels(context.resolution, [&](ivec2 pixel) {
    const auto key = static_cast<std::uint64_t>(pixel.y) * context.resolution.x + pixel.x;
    Eye eye(context, receivers, options, *region);
    for (int i = 0; i < options.samples; ++i) {
      Sampler sampler(options.sampler, context.seed, Stream::prefill, key, static_cast<std::uint32_t>(i));
      eye.look(sample_camera_ray(context, pixel, sampler), 0, options.gather_rays, sampler);
    }
  });
  return region;
}

}  // namespace etendue
