// A method's parameters as logs hold them: by name, those that the experiment sets, integers spelt out.
#pragma once

#include "experiments/config/method.h"

#include <cstdint>
#include <map>
#include <string>
#include <variant>

namespace etendue {

using ParameterValue = std::variant<bool, std::int64_t, double, std::string>;
using Parameters = std::map<std::string, ParameterValue>;

inline Parameters parameters_of(const Method& method) {
  Parameters parameters;
  for (const auto& [name, parameter] : method.params) parameters[name] = parameter.value;
  return parameters;
}

}  // namespace etendue
