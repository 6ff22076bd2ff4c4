#include "integrators/photons/kernel_domain.h"

#include "framework/core/elementary.h"
#include "framework/core/error.h"
#include "framework/transport/ray_tools.h"

#include <numeric>

namespace etendue {

namespace {

float cross(const vec2& a, const vec2& b) { return a.x * b.y - a.y * b.x; }

// The kernel's integral over the triangle (0, a, b), negative where it is clockwise: three Gauss points in each piece of at
// most a quarter of a radian, of the part within the edge in that direction.
float over_triangle(Kernel kernel, float radius, const vec2& a, const vec2& b) {
  if (kernel == Kernel::box) return 0.5f * inv_pi * cross(a, b) / square(radius);
  const float angle = math::atan2(cross(a, b), glm::dot(a, b)), length_a = glm::length(a);
  if (angle == 0 || !(length_a > 0)) return 0;
  const vec2 along = b - a;
  const float line = cross(a, along);  // twice the triangle's area
  const int pieces = static_cast<int>(std::ceil(4 * std::abs(angle)));
  const float step = angle / static_cast<float>(pieces);
  const vec2 x_axis = a / length_a;
  float sum = 0;
  for (int i = 0; i < pieces; ++i)
    for (int k = -1; k <= 1; ++k) {
      const float theta = (static_cast<float>(i) + 0.5f + 0.5f * 0.774596669f * static_cast<float>(k)) * step;
      const vec2 towards = math::cos(theta) * x_axis + math::sin(theta) * vec2(-x_axis.y, x_axis.x);
      const float distance = line / cross(towards, along);
      sum += (k == 0 ? 8.0f : 5.0f) / 18 * kernel_within(kernel, std::min(1.0f, square(distance / radius)));
    }
  return sum * step * 0.5f * inv_pi;
}

// The part of its tangent plane that a point sees.
struct TangentView {
  const RenderContext& context;
  const vec3& position;
  const vec3& normal;
  float radius;

  // Surfaces that turn by less are no walls.
  bool same_surface(const Ray& ray, const Hit& hit) const {
    return std::abs(glm::dot(context.scene.surface_at(ray, hit).normal, normal)) > 0.7f;
  }
  float free_way(const vec3& direction) const {
    const Ray ray{.origin = position + (0.01f * radius + clearance_of(position, radius)) * normal,
                  .direction = direction,
                  .t_max = radius};
    const Hit hit = trace(context, ray);
    return hit && !same_surface(ray, hit) ? 0.99f * hit.t : radius;
  }
  float height() const { return 0.2f * radius; }
  Ray down_to(const vec3& at) const { return {.origin = at + height() * normal, .direction = -normal, .t_max = 2 * height()}; }
  bool is_surface(const Ray& ray, const Hit& hit) const {
    constexpr float level = 0.01f;  // of the radius: what lies so is the same plane, whose normal need not be asked for
    return hit && (std::abs(hit.t - height()) < level * radius || same_surface(ray, hit));
  }
  bool has_surface(const vec3& at) const {
    const Ray ray = down_to(at);
    return is_surface(ray, trace(context, ray));
  }
  float reach(const vec3& direction, bool alone) const {
    float far = alone ? radius : free_way(direction), near = 0;
    if (has_surface(position + far * direction)) return far;
    while (far - near > radius / 64) {
      const float middle = 0.5f * (near + far);
      (has_surface(position + middle * direction) ? near : far) = middle;
    }
    return near;
  }
};

}  // namespace

vec2 VisibleDomain::direction(int i) {
  static const auto all = [] {
    std::array<vec2, directions> made;
    for (int k = 0; k < directions; ++k) {
      const float angle = 2 * pi * static_cast<float>(k) / directions;
      made[k] = {math::cos(angle), math::sin(angle)};
    }
    return made;
  }();
  return all[i];
}

VisibleDomain::VisibleDomain(const RenderContext& context, const vec3& position, const vec3& normal, float radius, bool alone)
    : frame_(Frame::from_normal(normal)), radius_(radius) {
  const TangentView view{context, position, normal, radius};
  const auto towards = [&](int i) { return frame_.to_world(vec3(direction(i), 0)); };
  std::array<Ray, directions / 2> down;
  std::array<Hit, directions / 2> hits;
  for (int i = 0; i < directions; i += 2) down[i / 2] = view.down_to(position + radius * towards(i));
  trace(context, down, hits);
  reach_.fill(0);
  bool whole = true;
  for (int i = 0; i < directions; i += 2) {
    const bool free = view.is_surface(down[i / 2], hits[i / 2]) && (alone || view.free_way(towards(i)) == radius);
    if (free) reach_[i] = radius;
    whole = whole && free;
  }
  if (whole) reach_.fill(radius);
  // Never nothing: a sliver of the disc stays where no direction is free.
  for (int i = 0; i < directions; ++i)
    if (reach_[i] == 0) reach_[i] = std::max(view.reach(towards(i), alone), 0.02f * radius);
}

bool VisibleDomain::contains(const vec3& offset) const {
  const vec2 flat = in_tangent_plane(frame_, offset);
  const float turn = math::atan2(flat.y, flat.x) * (directions * 0.5f * inv_pi);
  const int i = (static_cast<int>(std::floor(turn)) + directions) % directions;
  return full(i) || cross(corner(i + 1) - corner(i), flat - corner(i)) >= 0;
}

float VisibleDomain::share(Kernel kernel) const {
  float sum = 0;
  for (int i = 0; i < directions; ++i)
    sum += full(i) ? 1.0f / directions : over_triangle(kernel, radius_, corner(i), corner(i + 1));
  return sum;
}

// Andrew's monotone chain. Points on an edge of the hull are not corners.
PhotonHull::PhotonHull(std::span<const vec2> points) : points_(points) {
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    const vec2 &a = points[i], &b = points[j];
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : i < j;
  });
  const auto chain = [&](auto begin, auto end) {
    const std::size_t first = corners_.size();
    for (auto it = begin; it != end; ++it) {
      while (corners_.size() >= first + 2 &&
             cross(points[corners_.back()] - points[corners_[corners_.size() - 2]], points[*it] - points[corners_.back()]) <= 0)
        corners_.pop_back();
      corners_.push_back(*it);
    }
    corners_.pop_back();  // the other chain begins with it
  };
  if (points.size() < 3) {
    corners_ = std::move(order);
    return;
  }
  chain(order.begin(), order.end());
  chain(order.rbegin(), order.rend());
}

float PhotonHull::share(Kernel kernel, float radius) const {
  float sum = 0;
  for (std::size_t i = 0; i < corners_.size(); ++i)
    sum += over_triangle(kernel, radius, points_[corners_[i]], points_[corners_[(i + 1) % corners_.size()]]);
  return sum;
}

void check_given_radius(const RenderContext& context, float radius) {
  if (!context.scene.planes.empty() || context.bounds.empty()) return;
  const float diagonal = glm::length(context.bounds.diagonal());
  if (radius > diagonal)
    throw Error(fmt::format("radius = {:.4g}: the scene measures {:.4g} m across; expected at most that", radius, diagonal));
}

}  // namespace etendue
