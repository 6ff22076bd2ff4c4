// Questions that warnings ask about a method and its parameters.
#pragma once

#include "framework/integrator.h"
#include "integrators/bidirectional/vcm.h"

#include <algorithm>
#include <array>
#include <span>

namespace etendue {

inline constexpr std::array by_caustic_map{"irradiance-cache", "radiance-cache", "hash-cache"};

inline bool is_among(std::span<const char* const> names, const std::string& method) {
  return std::ranges::find(names, method) != names.end();
}

inline bool is_set(const ParamMap& params, const char* name, std::string_view value) {
  const auto param = params.find(name);
  return param != params.end() && to_text(param->second) == value;
}

// Does the method do what bdpt does?
inline bool is_bdpt(const RenderContext& context, const std::string& method, const ParamMap& params) {
  const auto is_given = [&](const char* name) { return params.contains(name) && !is_set(params, name, "0"); };
  const bool asked = is_given("radius") || is_given("neighbours");
  return method == "bdpt" || (method == "vcm" && !asked && neighbours_by_need(context) == 0);
}

}  // namespace etendue
