// What rays are for: structures are timed on each kind by itself.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace etendue {

// primary: from the camera. diffuse: a path's bounces. shadow: from a surface towards a light. photon: from a light on.
// gather: the rays of a final gather, bundles from one point.
enum class RayKind : std::uint8_t { primary, diffuse, shadow, photon, gather };
inline constexpr std::array ray_kinds{RayKind::primary, RayKind::diffuse, RayKind::shadow, RayKind::photon, RayKind::gather};

template <class T>
using ByRayKind = std::array<T, ray_kinds.size()>;

constexpr std::size_t index_of(RayKind kind) { return static_cast<std::size_t>(kind); }
const char* ray_kind_name(RayKind kind);

}  // namespace etendue
