// Values that records hold besides numbers and texts.
#pragma once

#include "experiments/config/method.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <variant>

namespace etendue {

// The median of repetitions and their quartiles; 0: not measured.
struct Measured {
  double median = 0, low = 0, high = 0;
};

// A method's parameters: by name, those that the experiment sets, integers spelt out.
using ParameterValue = std::variant<bool, std::int64_t, double, std::string>;
using Parameters = std::map<std::string, ParameterValue>;

inline Parameters parameters_of(const Method& method) {
  Parameters parameters;
  for (const auto& [name, parameter] : method.params) parameters[name] = parameter.value;
  return parameters;
}

// The purposes of rays: structures are timed on each kind by itself. primary: from the camera. diffuse: a path's bounces.
// shadow: from a surface towards a light. photon: from a light on. gather: the rays of a final gather, bundles from one point.
enum class RayKind : std::uint8_t { primary, diffuse, shadow, photon, gather };
inline constexpr std::array ray_kinds{RayKind::primary, RayKind::diffuse, RayKind::shadow, RayKind::photon, RayKind::gather};

template <class T>
using ByRayKind = std::array<T, ray_kinds.size()>;

constexpr std::size_t index_of(RayKind kind) { return static_cast<std::size_t>(kind); }
const char* ray_kind_name(RayKind kind);

}  // namespace etendue
