// What every record of a log needs to become a line of JSON.
#pragma once

#include "framework/core/check.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace etendue {

using Json = nlohmann::ordered_json;  // keeps keys in the order they are written in, "type" first

// JSON has no infinity and no NaN: a figure that is neither is the caller's duty.
inline double finite(double x) {
  CHECK(std::isfinite(x));
  return x;
}

inline const std::vector<double>& finite(const std::vector<double>& values) {
  for (const double value : values) finite(value);
  return values;
}

// On one line. Bytes that are not UTF-8, which the text of an error may hold, are replaced.
inline std::string dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace etendue
