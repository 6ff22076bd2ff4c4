#include "experiments/kinds/structures/accel_check.h"

#include "framework/core/check.h"
#include "framework/core/parallel.h"
#include "framework/core/rng.h"

#include <atomic>

namespace etendue {

namespace {

constexpr std::size_t block = 1024;  // rays of a task

// Sums count(begin, end) over blocks of rays.
template <class Count>
std::uint64_t count_in_blocks(std::size_t rays, const Count& count) {
  std::atomic<std::uint64_t> sum = 0;
  parallel_for((rays + block - 1) / block, 1, [&](std::size_t i) { sum += count(i * block, std::min(rays, (i + 1) * block)); });
  return sum;
}

bool same(const Hit& a, const Hit& b) { return a.t == b.t && a.primitive == b.primitive && a.instance == b.instance; }

class AimedRays {
 public:
  explicit AimedRays(const Scene& scene) : scene_(scene), bounds_(scene.bounds()) {
    if (bounds_.empty() || !is_finite(bounds_.lower) || !is_finite(bounds_.upper)) bounds_ = {vec3(-1), vec3(1)};
  }

  Ray operator()(std::uint64_t index) const {
    Pcg32 rng(hash_keys(index), 1);
    for (;;) {
      Ray ray = draw(rng, index);
      if (is_finite(ray.origin) && is_finite(ray.direction) && ray.direction != vec3(0)) return ray;
    }
  }

 private:
  vec3 point(Pcg32& rng, float enlarged) const {
    const vec3 u(rng.next_float(), rng.next_float(), rng.next_float());
    return bounds_.centre() + enlarged * (u - 0.5f) * bounds_.diagonal();
  }

  // A vertex, or a point of an edge, of a random valid triangle; nothing where there is none to be found.
  std::optional<vec3> feature(Pcg32& rng, bool edge) const {
    for (int attempt = 0; attempt < 16; ++attempt) {
      const Instance& instance = scene_.instances[rng.next() % scene_.instances.size()];
      const Geometry& g = scene_.objects[instance.object].geometry;
      if (g.triangles.empty()) continue;
      const auto id = static_cast<std::uint32_t>(rng.next() % g.triangles.size());
      if (!g.is_valid(id)) continue;
      const std::uint32_t corner = rng.next() % 3;
      const vec3 a = g.positions[g.triangles[id][corner]], b = g.positions[g.triangles[id][(corner + 1) % 3]];
      return instance.to_world.point(edge ? a + rng.next_float() * (b - a) : a);
    }
    return std::nullopt;
  }

  Ray draw(Pcg32& rng, std::uint64_t index) const {
    const std::optional<vec3> aimed = index % 3 == 2 ? std::nullopt : feature(rng, index % 3 == 1);
    const vec3 target = aimed ? *aimed : point(rng, 1);
    Ray ray{.origin = point(rng, 2.5f), .direction = {}};
    if (aimed && rng.next() % 6 == 0) {
      const int axis = static_cast<int>(rng.next() % 3);
      ray.origin = target;
      ray.origin[axis] += (rng.next() % 2 ? 1.0f : -1.0f) * max_component(bounds_.diagonal());
    }
    ray.direction = target - ray.origin;
    if (rng.next() % 5 == 0) ray.t_max = 0.5f + rng.next_float();
    return ray;
  }

  const Scene& scene_;
  Bounds bounds_;
};

Quadric moved(Quadric quadric, const CheckFrame& frame) {
  struct Visitor {
    const CheckFrame& frame;
    vec3 at(const vec3& p) const { return frame.scale * p + frame.offset; }
    void operator()(Sphere& s) const { s = {at(s.centre), s.radius * frame.scale}; }
    void operator()(Cylinder& c) const { c = {at(c.base), c.radius * frame.scale, c.axis, c.length * frame.scale, c.caps}; }
    void operator()(Disk& d) const { d = {at(d.centre), d.radius * frame.scale, d.normal, d.inner_radius * frame.scale}; }
  };
  std::visit(Visitor{frame}, quadric);
  return quadric;
}

}  // namespace

std::vector<std::optional<ExactHit>> exact_hits(const ExactTracer& tracer, std::span<const Ray> rays) {
  std::vector<std::optional<ExactHit>> hits(rays.size());
  parallel_for(rays.size(), block, [&](std::size_t i) { hits[i] = tracer.closest(rays[i]); });
  return hits;
}

std::uint64_t wrong_hits(const ExactTracer& tracer, const RayQuery& structure, std::span<const Ray> rays,
                         std::span<const std::optional<ExactHit>> exact) {
  CHECK_EQ(rays.size(), exact.size());
  return count_in_blocks(rays.size(), [&](std::size_t begin, std::size_t end) {
    std::vector<Hit> batch(end - begin);
    structure.closest(rays.subspan(begin, end - begin), batch);
    std::uint64_t wrong = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const Hit hit = structure.closest(rays[i]), &batched = batch[i - begin];
      wrong +=
          !tracer.is_right(rays[i], hit, exact[i]) || (!same(hit, batched) && !tracer.is_right(rays[i], batched, exact[i]));
    }
    return wrong;
  });
}

std::uint64_t wrong_occlusions(const ExactTracer& tracer, const RayQuery& structure, std::span<const Ray> rays,
                               std::span<const std::optional<ExactHit>> exact) {
  CHECK_EQ(rays.size(), exact.size());
  return count_in_blocks(rays.size(), [&](std::size_t begin, std::size_t end) {
    bool batch[block];
    structure.occluded(rays.subspan(begin, end - begin), std::span(batch, end - begin));
    // The structure does not tell what blocks a ray: at a vertex that borders nothing it may be a surface which the judge finds
    // within rounding only once it is named, as the nearest hit is.
    const auto is_right = [&](std::size_t i, bool occluded) {
      if (tracer.is_right(rays[i], occluded, exact[i])) return true;
      const Hit named = occluded ? structure.closest(rays[i]) : Hit{};
      return named && tracer.is_right(rays[i], named, exact[i]);
    };
    std::uint64_t wrong = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const bool occluded = structure.occluded(rays[i]);
      wrong += !is_right(i, occluded) || (batch[i - begin] != occluded && !is_right(i, batch[i - begin]));
    }
    return wrong;
  });
}

std::vector<CheckFrame> check_frames(const Scene& scene) {
  const Bounds bounds = scene.bounds();
  const float span = bounds.empty() ? 1 : max_component(bounds.diagonal());
  // A power of two, so that only the offset rounds the vertices.
  const float far_scale = span > 0 && std::isfinite(span) ? std::exp2(std::round(std::log2(1024 / span))) : 1;
  return {{"as it is", 1, 0}, {"1e6 m away", far_scale, 1e6f}, {"2^20 times", 0x1p20f, 0}, {"2^-20 times", 0x1p-20f, 0}};
}

Scene moved_scene(const Scene& scene, const CheckFrame& frame) {
  Scene result = scene;
  const Transform move = Transform::translate(vec3(frame.offset)) * Transform::scale(vec3(frame.scale));
  Geometry& world = result.objects[0].geometry;
  for (vec3& p : world.positions) p = frame.scale * p + frame.offset;
  for (Quadric& quadric : world.quadrics) quadric = moved(quadric, frame);
  for (std::size_t i = 1; i < result.instances.size(); ++i) result.instances[i].to_world = move * result.instances[i].to_world;
  for (InfinitePlane& plane : result.planes) plane.point = frame.scale * plane.point + frame.offset;
  return result;
}

std::vector<Ray> aimed_rays(const Scene& scene, std::uint64_t first, std::size_t count) {
  const AimedRays draw(scene);
  std::vector<Ray> rays(count);
  parallel_for(count, block, [&](std::size_t i) { rays[i] = draw(first + i); });
  return rays;
}

}  // namespace etendue
