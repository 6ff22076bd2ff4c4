#include "integrators/photons/incident_directions.h"

#include "framework/core/elementary.h"
#include "framework/core/sampling.h"

namespace etendue {

namespace {

// Inverse of sample_unit_disk.
vec2 concentric_square(const vec2& disk) {
  const float radius = glm::length(disk);
  if (radius == 0) return vec2(0.5f);
  const bool wide = std::abs(disk.x) > std::abs(disk.y);
  // The coordinate that has the radius, and the other one, an angle's share of it.
  const float major = std::copysign(radius, wide ? disk.x : disk.y);
  const float minor = major * (4 * inv_pi) * math::atan(wide ? disk.y / disk.x : disk.x / disk.y);
  return 0.5f * (wide ? vec2(major, minor) : vec2(minor, major)) + 0.5f;
}

}  // namespace

IncidentDirections::IncidentDirections(const PhotonMap& map, const GatherPoint& at, int k)
    : frame_(Frame::from_normal(at.normal())) {
  map.visit_nearest(at, k, [&](const vec3& direction, const Rgb& reflected) {
    const vec3 local = frame_.to_local(direction);
    if (!(local.z > 0)) return;
    // A square of two cells a side about the photon: few photons make a smooth density.
    const vec2 at_square = concentric_square(vec2(local)) * static_cast<float>(side);
    const float weight = mean_component(reflected);
    const auto overlap = [](float x, int cell) {  // of [x - 1, x + 1] with the cell
      return 0.5f * std::max(0.0f, std::min(x + 1, cell + 1.0f) - std::max(x - 1, static_cast<float>(cell)));
    };
    const ivec2 first = glm::max(ivec2(glm::floor(at_square - 1.0f)), 0), last = glm::min(ivec2(at_square + 1.0f), side - 1);
    for (int y = first.y; y <= last.y; ++y)
      for (int x = first.x; x <= last.x; ++x) {
        const float share = weight * overlap(at_square.x, x) * overlap(at_square.y, y);
        weight_[static_cast<std::size_t>(y) * side + x] += share;
        total_ += share;
      }
  });
}

vec3 IncidentDirections::sample(vec2 u) const {
  std::size_t cell = 0;
  float left = u.x * total_;
  while (cell + 1 < weight_.size() && left >= weight_[cell]) left -= weight_[cell++];
  while (weight_[cell] == 0) --cell;  // rounding went beyond the last photon
  u.x = std::clamp(left / weight_[cell], 0.0f, 0x1.fffffep-1f);
  const vec2 square = (vec2(cell % side, cell / side) + u) / static_cast<float>(side);
  return frame_.to_world(sample_cosine_hemisphere(square));
}

float IncidentDirections::pdf_solid_angle(const vec3& wi) const {
  const vec3 local = frame_.to_local(wi);
  if (!(local.z > 0)) return 0;
  const ivec2 cell = glm::clamp(ivec2(concentric_square(vec2(local)) * static_cast<float>(side)), 0, side - 1);
  return weight_[static_cast<std::size_t>(cell.y) * side + cell.x] / total_ * (side * side) * local.z * inv_pi;
}

}  // namespace etendue
