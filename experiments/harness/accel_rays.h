// The rays on which structures are compared: what a renderer would ask of a scene, recorded once.
#pragma once

#include "framework/scene/scene.h"

#include <array>
#include <vector>

namespace etendue {

enum class RayKind : std::uint8_t { primary, diffuse, shadow };
inline constexpr std::array ray_kinds{RayKind::primary, RayKind::diffuse, RayKind::shadow};

const char* ray_kind_name(RayKind kind);

using RaysByKind = std::array<std::vector<Ray>, ray_kinds.size()>;

// Primary: one through a random point of each of resolution^2 pixels. Diffuse: from each primary hit, cosine-weighted about the
// normal on the ray's side. Shadow: from each primary hit towards a sampled point of a light or, without lights, a random point
// of the scene's bounding sphere. `tracer` finds the primary hits; the same scene gives the same rays.
RaysByKind record_rays(const Scene& scene, const RayQuery& tracer, int resolution);

}  // namespace etendue
