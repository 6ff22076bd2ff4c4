#include "integrators/warnings/coinciding.h"

#include "framework/core/parallel.h"
#include "framework/core/units.h"
#include "framework/scene/triangle_point.h"
#include "framework/transport/area_light.h"
#include "framework/transport/ray_tools.h"
#include "integrators/warnings/seen_pixels.h"

#include <algorithm>
#include <atomic>

namespace etendue {

namespace {

// A point, in the space of an object.
struct Sought {
  vec3 position;
  float tolerance;  // metres there
  std::uint32_t material, list;
};

bool is_on(const TrianglePlane& t, const vec3& p, float tolerance) {
  if (!(t.doubled > 0)) return false;
  const vec3 d = p - t.p0;
  if (!(std::abs(glm::dot(d, t.normal)) < tolerance)) return false;
  const float u = glm::dot(glm::cross(d, t.e2), t.normal), v = glm::dot(glm::cross(t.e1, d), t.normal);
  return u >= 0 && v >= 0 && u + v <= t.doubled;
}

// A point within a quadric's bounds.
struct IsOnQuadric {
  vec3 p;
  float tolerance;

  bool operator()(const Sphere& s) const { return std::abs(glm::length(p - s.centre) - s.radius) < tolerance; }
  bool operator()(const Disk& d) const {
    const float r = glm::length(p - d.centre);
    return std::abs(glm::dot(p - d.centre, d.normal)) < tolerance && r <= d.radius && r >= d.inner_radius;
  }
  bool operator()(const Cylinder& c) const {
    const float along = glm::dot(p - c.base, c.axis), r = glm::length(p - c.base - along * c.axis);
    const bool on_tube = std::abs(r - c.radius) < tolerance && along >= 0 && along <= c.length;
    return on_tube || (c.caps && r <= c.radius && std::min(std::abs(along), std::abs(along - c.length)) < tolerance);
  }
};

bool is_glass(const Scene& scene, std::uint32_t material) {
  return std::holds_alternative<Dielectric>(scene.materials[material]);
}

class Search {
 public:
  Search(const Scene& scene, std::size_t lists) : scene_(scene), found_(lists) {}

  // Those of `points` that lie in the bounds of what the instance holds.
  void look_in(const Instance& instance, const Bounds& bounds, std::span<const std::vector<SurfacePoint>> points) {
    const Transform to_object = instance.to_world.inverse();
    sought_.clear();
    for (std::uint32_t list = 0; list < points.size(); ++list)
      for (const SurfacePoint& p : points[list]) {
        const float tolerance = glm::length(to_object.vector(p.clearance * p.normal));
        const vec3 position = to_object.point(p.position);
        if (glm::all(glm::lessThanEqual(bounds.lower - tolerance, position)) &&
            glm::all(glm::lessThanEqual(position, bounds.upper + tolerance)))
          sought_.push_back({position, tolerance, p.material, list});
      }
    if (sought_.empty()) return;
    std::ranges::sort(sought_, {}, [](const Sought& s) { return s.position.x; });
    widest_ = std::ranges::max(sought_, {}, &Sought::tolerance).tolerance;
    for (const Shape& shape : scene_.objects[instance.object].shapes)
      parallel_for(shape.primitive_count, 1024, [&](std::size_t i) {
        ask(scene_.objects[instance.object].geometry, shape.first_primitive + static_cast<std::uint32_t>(i), shape.material);
      });
  }
  void look_at(const InfinitePlane& plane, std::span<const std::vector<SurfacePoint>> points) {
    for (std::size_t list = 0; list < points.size(); ++list)
      for (const SurfacePoint& p : points[list])
        if (differ(p.material, plane.material) && std::abs(glm::dot(p.position - plane.point, plane.normal)) < p.clearance)
          found_[list] = 1;
  }
  std::vector<bool> found() const { return {found_.begin(), found_.end()}; }

 private:
  bool differ(std::uint32_t a, std::uint32_t b) const { return a != b && (is_glass(scene_, a) || is_glass(scene_, b)); }

  void ask(const Geometry& g, std::uint32_t primitive, std::uint32_t material) {
    const Bounds bounds = g.primitive_bounds(primitive);
    auto s = std::ranges::lower_bound(sought_, bounds.lower.x - widest_, {}, [](const Sought& x) { return x.position.x; });
    for (; s != sought_.end() && s->position.x <= bounds.upper.x + widest_; ++s)
      if (differ(s->material, material) && is_on(g, primitive, *s))
        std::atomic_ref(found_[s->list]).store(1, std::memory_order_relaxed);
  }
  static bool is_on(const Geometry& g, std::uint32_t primitive, const Sought& s) {
    if (!g.is_triangle(primitive)) return std::visit(IsOnQuadric{s.position, s.tolerance}, g.quadric(primitive));
    const uvec3 v = g.triangles[primitive];
    return etendue::is_on(TrianglePlane(g.positions[v.x], g.positions[v.y], g.positions[v.z]), s.position, s.tolerance);
  }

  const Scene& scene_;
  std::vector<std::uint8_t> found_;  // by list
  std::vector<Sought> sought_;       // in the instance, by x
  float widest_ = 0;                 // tolerance of these
};

// Does a ray that looks straight at a point of the light meet something else there?
bool is_hidden(const RenderContext& context, const AreaLight& light, const AreaPoint& point, float afar) {
  const float tolerance = point.clearance + afar, height = 4 * tolerance;
  const auto is_hidden_from = [&](const vec3& side) {
    const Hit hit = trace(context, {.origin = point.position + height * side, .direction = -side, .t_max = 2 * height});
    return hit && (hit.instance != 0 || hit.primitive != light.primitive) && std::abs(hit.t - height) <= tolerance;
  };
  return is_hidden_from(point.normal) || (light.two_sided && is_hidden_from(-point.normal));
}

Bounds bounds_of(const Geometry& g) {
  Bounds bounds;
  for (std::uint32_t i = 0; i < g.primitive_count(); ++i)
    if (g.is_valid(i)) bounds.extend(g.primitive_bounds(i));
  return bounds;
}

// Tells of each list of points whether one of them lies, as far as rounding tells, on a surface of another material too, where
// one of the two is glass. Looks once at every primitive of the instances near which there are points, and at the first of
// these where they are very many.
std::vector<bool> coincide_with_others(const Scene& scene, std::span<const std::vector<SurfacePoint>> points) {
  std::vector<Bounds> bounds;
  for (const Object& object : scene.objects) bounds.push_back(bounds_of(object.geometry));
  Search search(scene, points.size());
  constexpr std::size_t most = 100'000'000;  // points and primitives asked: a second or so
  std::size_t count = 0, asked = 0;
  for (const auto& list : points) count += list.size();
  for (const Instance& instance : scene.instances) {
    asked += count + scene.objects[instance.object].geometry.primitive_count();
    if (asked > most) break;
    if (!bounds[instance.object].empty()) search.look_in(instance, bounds[instance.object], points);
  }
  for (const InfinitePlane& plane : scene.planes) search.look_at(plane, points);
  return search.found();
}

}  // namespace

std::string surfaces_coincide(const RenderContext& context) {
  constexpr int most = 8;
  const std::vector<Material>& materials = context.scene.materials;
  const auto is_glass = [](const Material& m) { return std::holds_alternative<Dielectric>(m); };
  const bool has_glass = std::ranges::any_of(materials, is_glass);
  std::vector<std::vector<SurfacePoint>> seen(has_glass ? asked_pixels : 0);
  // Straight on through glass, to what lies beneath.
  double share = share_of_pixels(context, [&](Ray ray, std::size_t pixel) {
    std::optional<SurfacePoint> last;
    for (int met = 0; met < most; ++met) {
      const Hit hit = trace(context, ray);
      if (!hit) return false;
      const SurfacePoint point = context.scene.surface_at(ray, hit);
      const auto height = [&] { return std::abs(glm::dot(point.position - last->position, point.normal)); };
      if (last && last->material != point.material && height() < point.clearance) return true;
      if (last && !is_glass(materials[last->material])) return false;
      if (has_glass) seen[pixel].push_back(point);
      last = point;
      ray.t_min = std::max(hit.t, std::nextafter(ray.t_min, infinity));
    }
    return false;
  });
  if (share < fewest_pixels && has_glass) {
    const std::vector<bool> exactly = coincide_with_others(context.scene, seen);
    share = static_cast<double>(std::ranges::count(exactly, true)) / asked_pixels;
  }
  if (share < fewest_pixels) return "";
  return fmt::format(
      "{} of what is seen are surfaces of different materials in one place, as far as rounding tells: "
      "which of them a ray meets is chance, and light is lost there; move one off the other",
      format_percent(share));
}

std::string lights_coincide(const RenderContext& context) {
  constexpr std::size_t most_points = 1024, most_of_light = 64;
  const Scene& scene = context.scene;
  std::vector<const AreaLight*> lights;
  for (const Light& light : scene.lights)
    if (const auto* area = std::get_if<AreaLight>(&light); area && !is_black(area->radiance)) lights.push_back(area);
  if (lights.empty()) return "";
  const std::size_t asked = std::min(lights.size(), most_points), of_each = std::min(most_points / asked, most_of_light);
  const float afar = clearance_from_afar(glm::length(context.bounds.diagonal()));
  std::vector<double> power(asked), hidden(asked);
  parallel_for(asked, 1, [&](std::size_t i) {
    const AreaLight& light = *lights[i * lights.size() / asked];
    const AreaEmitter emitter(scene, light);
    if (!(emitter.area() > 0)) return;
    power[i] = emitter.area() * luminance(light.radiance);
    Pcg32 random(i, 1);
    for (std::size_t j = 0; j < of_each; ++j) {
      const float u = random.next_float();
      if (is_hidden(context, light, emitter.sample({u, random.next_float()}), afar))
        hidden[i] += power[i] / static_cast<double>(of_each);
    }
  });
  constexpr double least = 0.01;  // of the light, that a warning is worth
  const double all = std::accumulate(power.begin(), power.end(), 0.0);
  const double share = all > 0 ? std::accumulate(hidden.begin(), hidden.end(), 0.0) / all : 0;
  if (share < least) return "";
  return fmt::format(
      "{} of the light of lamps comes from where they lie in one place with other surfaces, as far as rounding tells: rays "
      "meet "
      "these, light samples and photons do not, so that methods differ; move one off the other",
      format_percent(share));
}

}  // namespace etendue
