#include "framework/core/units.h"

#include "framework/core/error.h"

#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <utility>

namespace etendue {

namespace {

struct Unit {
  std::string_view name;
  double factor;
};

double parse_with_unit(std::string_view text, std::initializer_list<Unit> units, const char* quantity, const char* example) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  std::string names;
  for (const Unit& unit : units) {
    if (!unit.name.empty()) names += (names.empty() ? "" : ", ") + std::string(unit.name);
  }
  const auto fail = [&](const char* what) -> Error {
    return Error(fmt::format("{} '{}': expected a {} such as \"{}\" (units: {})", what, text, quantity, example, names));
  };
  if (error != std::errc() || !std::isfinite(number)) throw fail("bad value");
  std::string_view suffix = text.substr(static_cast<std::size_t>(end - text.data()));
  while (!suffix.empty() && suffix.front() == ' ') suffix.remove_prefix(1);
  if (number < 0) throw fail("negative value");
  for (const Unit& unit : units)
    if (unit.name == suffix) return number * unit.factor;
  throw fail("unknown unit in");
}

std::int64_t to_whole(double value, std::string_view text) {
  if (value != std::floor(value) || value > 9e15) throw Error(fmt::format("'{}' is not a whole number below 9e15", text));
  return static_cast<std::int64_t>(value);
}

std::string scaled(double value, std::initializer_list<std::pair<double, const char*>> steps) {
  for (const auto& [factor, suffix] : steps)
    if (std::abs(value) >= factor) return fmt::format("{:.4g} {}", value / std::max(factor, 1.0), suffix);
  return fmt::format("{:.4g}", value);
}

}  // namespace

double parse_seconds(std::string_view text) {
  const double seconds = parse_with_unit(text, {{"", 1}, {"s", 1}, {"ms", 1e-3}, {"min", 60}, {"h", 3600}}, "time", "60s");
  if (seconds > 1e9) throw Error(fmt::format("'{}' is {:g} s; expected 1e9 s at most", text, seconds));
  return seconds;
}

std::int64_t parse_count(std::string_view text) {
  return to_whole(parse_with_unit(text, {{"", 1}, {"k", 1e3}, {"M", 1e6}, {"G", 1e9}}, "count", "200k"), text);
}

std::int64_t parse_bytes(std::string_view text) {
  return to_whole(
      parse_with_unit(
          text,
          {{"B", 1}, {"kB", 1e3}, {"KB", 1e3}, {"MB", 1e6}, {"GB", 1e9}, {"KiB", 0x1p10}, {"MiB", 0x1p20}, {"GiB", 0x1p30}},
          "size", "512MiB"),
      text);
}

std::string format_seconds(double seconds) {
  if (seconds < 60) {
    // What three digits round to a thousand is one of the next unit.
    if (seconds >= 0.9995) return fmt::format("{:.3g} s", seconds);
    if (seconds >= 0.9995e-3) return fmt::format("{:.3g} ms", seconds * 1e3);
    return fmt::format("{:.3g} us", seconds * 1e6);
  }
  const auto whole = static_cast<long long>(std::llround(seconds));
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

std::string format_count(double count) { return scaled(count, {{1e9, "G"}, {1e6, "M"}, {1e3, "k"}}); }

std::string format_bytes(double bytes) { return scaled(bytes, {{0x1p30, "GiB"}, {0x1p20, "MiB"}, {0x1p10, "KiB"}, {0, "B"}}); }

std::string format_percent(double share) { return fmt::format("{:.{}f} %", 100 * share, share < 0.0995 ? 1 : 0); }

}  // namespace etendue
