#include "integrators/photons/emission/visible_region.h"

#include "framework/core/parallel.h"
#include "framework/transport/bsdf.h"
#include "framework/transport/ray_tools.h"
#include "integrators/paths/path.h"

#include <numeric>

namespace etendue {

VisibleRegion::VisibleRegion(const Bounds& bounds, float reach) {
  constexpr float most = 1 << 24, most_a_side = 1023;
  const vec3 extent = bounds.empty() ? vec3(0) : bounds.diagonal();
  lower_ = bounds.empty() ? vec3(0) : bounds.lower;
  float width = std::max({0.5f * reach, max_component(extent) / most_a_side, std::numeric_limits<float>::min()});
  const auto cells = [&] { return glm::floor(extent / width) + 1.0f; };
  while (cells().x * cells().y * cells().z > most) width *= 1.1f;
  cells_per_metre_ = 1 / width;
  size_ = uvec3(cells());
  cells_ = std::vector<std::atomic<Octants>>(static_cast<std::size_t>(size_.x) * size_.y * size_.z);
}

// Octants that hold a unit vector whose cosine with the normal is 0.1 or more: the least that the side test lets pass.
VisibleRegion::Octants VisibleRegion::octants_facing(const vec3& normal) {
  Octants octants = 0;
  for (int octant = 0; octant < 8; ++octant) {
    const vec3 sign(octant & 1 ? -1 : 1, octant & 2 ? -1 : 1, octant & 4 ? -1 : 1);
    if (glm::length(glm::max(sign * normal, vec3(0))) >= 0.09f) octants |= static_cast<Octants>(1 << octant);
  }
  return octants;
}

uvec3 VisibleRegion::cell(const vec3& position) const {
  return uvec3(glm::clamp((position - lower_) * cells_per_metre_, vec3(0), vec3(size_ - 1u)));
}

void VisibleRegion::mark(const vec3& position, float radius, Octants octants) {
  const uvec3 begin = cell(position - radius), end = cell(position + radius);
  for (unsigned z = begin.z; z <= end.z; ++z)
    for (unsigned y = begin.y; y <= end.y; ++y)
      for (unsigned x = begin.x; x <= end.x; ++x) {
        auto& marked = cells_[index({x, y, z})];
        if (octants & ~marked.load(std::memory_order_relaxed)) marked.fetch_or(octants, std::memory_order_relaxed);
      }
}

bool VisibleRegion::contains(const vec3& position, const vec3& normal) const {
  const int octant = (normal.x < 0 ? 1 : 0) + (normal.y < 0 ? 2 : 0) + (normal.z < 0 ? 4 : 0);
  return cells_[index(cell(position))].load(std::memory_order_relaxed) >> octant & 1;
}

double VisibleRegion::share() const {
  const auto marked = std::count_if(cells_.begin(), cells_.end(), [](const auto& c) { return c.load() != 0; });
  return static_cast<double>(marked) / static_cast<double>(cells_.size());
}

namespace {

struct Eye {
  const RenderContext& context;
  const RoughMaterials& rough_materials;
  const SeenOptions& options;

  // Calls seen(point, bsdf, ray, distance) at the rough vertices along a ray with `depth` events before it, through
  // specular-like ones.
  template <class Seen>
  void look(Ray ray, int depth, Sampler& sampler, const Seen& seen) const {
    for (float distance = 0; depth < options.max_depth; ++depth) {
      const Hit hit = trace(context, ray);
      if (!hit) return;
      distance += hit.t;
      const SurfacePoint point = context.scene.surface_at(ray, hit);
      const Bsdf bsdf(context.scene, point);
      const bool rough = rough_materials(point.material);
      if (rough_materials.stores(point.material)) seen(point, bsdf, ray, distance);
      if (rough && !bsdf.has_specular()) return;
      const BsdfSample scattered = scatter(bsdf, ray, sampler);
      if (!scattered || (rough && !scattered.specular)) return;
      ray = spawn_ray(point, scattered.wi);
    }
  }
  static BsdfSample scatter(const Bsdf& bsdf, const Ray& ray, Sampler& sampler) {
    const float u_lobe = sampler.get_1d();
    return bsdf.sample(-ray.direction, u_lobe, sampler.get_2d());
  }
};

// body(pixel, ray, sampler) for each camera ray.
template <class Body>
void for_camera_rays(const RenderContext& context, const SeenOptions& options, const Body& body) {
  parallel_pixels(context.resolution, [&](ivec2 pixel) {
    const auto key = pixel_index(pixel, context.resolution);
    for (int i = 0; i < options.samples; ++i) {
      Sampler sampler(options.sampler, context.seed, Stream::initial_pass, key, static_cast<std::uint32_t>(i));
      const Ray ray = sample_camera_ray(context, pixel, sampler);
      body(key, ray, sampler);
    }
  });
}

}  // namespace

double seen_area(const RenderContext& context, const RoughMaterials& rough_materials, const SeenOptions& options) {
  const Camera& camera = context.scene.camera;
  const vec2 pixel = 2.0f * camera.half_extent(context.resolution) / vec2(context.resolution);
  const float solid_angle = pixel.x * pixel.y;  // on the axis
  std::vector<double> of_pixel(static_cast<std::size_t>(context.resolution.x) * context.resolution.y);
  const Eye eye{context, rough_materials, options};
  for_camera_rays(context, options, [&](std::uint64_t key, const Ray& ray, Sampler& sampler) {
    eye.look(ray, 0, sampler, [&](const SurfacePoint& point, const Bsdf&, const Ray& last, float distance) {
      const float cosine = std::abs(glm::dot(point.normal, last.direction));
      of_pixel[key] +=
          solid_angle * square(camera.spread(distance)) / (std::max(cosine, 0.05f) * static_cast<float>(options.samples));
    });
  });
  return std::accumulate(of_pixel.begin(), of_pixel.end(), 0.0);
}

std::unique_ptr<VisibleRegion> find_seen(const RenderContext& context, const RoughMaterials& rough_materials,
                                         const SeenOptions& options, float reach, int gather_rays, bool with_ends) {
  auto region = std::make_unique<VisibleRegion>(context.bounds, reach);
  const Eye eye{context, rough_materials, options};
  // The normal's side is chosen as GatherPoint::counts tests it.
  const auto mark = [&](const SurfacePoint& point, const Bsdf& bsdf, const Ray& last, float) {
    if (!options.side_test) return region->mark(point.position, reach);
    const vec3 normal = glm::dot(last.direction, point.normal) > 0 ? -point.normal : point.normal;
    region->mark(point.position, reach, normal);
    if (!bsdf.is_diffuse() || point.shading_normal != point.normal) region->mark(point.position, reach, -normal);
  };
  for_camera_rays(context, options, [&](std::uint64_t, const Ray& ray, Sampler& sampler) {
    if (gather_rays == 0) return eye.look(ray, 0, sampler, mark);
    eye.look(ray, 0, sampler, [&](const SurfacePoint& point, const Bsdf& bsdf, const Ray& last, float distance) {
      if (with_ends) mark(point, bsdf, last, distance);
      for (int i = 0; i < gather_rays; ++i) {
        const BsdfSample scattered = Eye::scatter(bsdf, last, sampler);
        if (scattered && !scattered.specular) eye.look(spawn_ray(point, scattered.wi), 1, sampler, mark);
      }
    });
  });
  return region;
}

}  // namespace etendue
