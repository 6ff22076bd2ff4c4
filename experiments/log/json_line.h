// Everything that a record of a log needs to become a line of JSON.
#pragma once

#include "experiments/log/json_fwd.h"
#include "framework/core/check.h"

#include <fmt/format.h>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <utility>

namespace etendue {

// The text is on one line, or indented. Bytes that are not UTF-8, which the text of an error may hold, are replaced. The
// library's writer is instantiated in log.cpp alone.
std::string dump(const Json& json, int indent = -1);
// Throws the library's error of a number that is not whole or does not fit.
[[noreturn]] void throw_not_whole(const Json& json);

template <class T, class SFINAE>
struct CheckedNumber : nlohmann::adl_serializer<T> {};

template <class T>
struct CheckedNumber<T, std::enable_if_t<std::is_integral_v<T> && !std::is_same_v<T, bool>>> : nlohmann::adl_serializer<T> {
  static void from_json(const Json& json, T& value) {
    const bool fits = json.is_number_unsigned()  ? std::in_range<T>(*json.get_ptr<const std::uint64_t*>())
                      : json.is_number_integer() ? std::in_range<T>(*json.get_ptr<const std::int64_t*>())
                                                 : false;
    if (!fits) throw_not_whole(json);
    nlohmann::adl_serializer<T>::from_json(json, value);
  }
};

// A figure as logs keep it: to nine significant digits, more than anything that is measured has. JSON has no infinity and no
// NaN: a figure that is neither is the caller's duty.
inline double logged(double x) {
  CHECK(std::isfinite(x));
  return std::strtod(fmt::format("{:.9g}", x).c_str(), nullptr);
}

}  // namespace etendue
