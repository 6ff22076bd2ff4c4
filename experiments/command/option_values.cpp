#include "experiments/command/commands.h"
#include "experiments/run/recipe.h"
#include "framework/core/units.h"
#include "framework/io/text.h"

#include <fmt/format.h>
#include <algorithm>
#include <optional>

namespace etendue {

namespace {

// Answers what `parse` makes of the text; its errors become those of the option.
auto parsed(const std::string& option, const std::string& text, const auto& parse) {
  try {
    return parse(text);
  } catch (const Error& e) {
    throw Error(Location{option}, e.what());
  }
}

}  // namespace

std::int64_t whole_option(const std::string& option, const std::string& text, std::int64_t low, std::int64_t high) {
  const std::int64_t value = parsed(option, text, parse_count);
  if (value < low || value > high)
    throw Error(Location{option}, fmt::format("{} is out of range; expected {} .. {}", text, low, high));
  return value;
}

double duration_option(const std::string& option, const std::string& text) {
  const double value = parsed(option, text, parse_seconds);
  if (!(value > 0)) throw Error(Location{option}, fmt::format("{}; expected a time above zero", text));
  return value;
}

std::uint64_t bytes_option(const std::string& option, const std::string& text) {
  const std::int64_t value = parsed(option, text, parse_bytes);
  if (value <= 0) throw Error(Location{option}, fmt::format("{}; expected a size above zero", text));
  return static_cast<std::uint64_t>(value);
}

double number_option(const std::string& option, const std::string& text, double low, double high) {
  const std::optional<double> value = parse_number(text);
  if (!value) throw Error(Location{option}, fmt::format("'{}' is no number; expected one such as 0.01", text));
  if (!(*value >= low && *value <= high))
    throw Error(Location{option}, fmt::format("{} is out of range; expected {:g} .. {:g}", text, low, high));
  return *value;
}

std::vector<Isa> isas_option(const std::string& option, const std::string& text) {
  const Location where{option};
  std::vector<Isa> isas;
  for (const std::string& name : split(text, ",")) {
    require_name(where, "instruction set", name, std::vector<std::string>(std::begin(isa_options), std::end(isa_options)));
    const Isa isa = isa_of_option(name);
    if (!is_supported(isa))
      throw Error(where,
                  fmt::format("this machine has no {}; its widest is {}", isa_name(isa), isa_option(supported_isas().back())));
    isas.push_back(isa);
  }
  return isas;
}

ivec2 resolution_option(const std::string& option, const std::string& text) {
  if (const auto size = parse_resolution(text); size && size->x <= 16384 && size->y <= 16384) return *size;
  throw Error(Location{option}, fmt::format("'{}'; expected WIDTHxHEIGHT such as 640x480, each in 1 .. 16384", text));
}

Window window_option(const std::string& option, const std::string& text) {
  const auto numbers = mapped(split(text, ","), [](const std::string& part) { return parse_whole<int>(part).value_or(-1); });
  const auto is_out = [](int number) { return number < 0 || number > 16384; };
  if (numbers.size() != 4 || std::ranges::any_of(numbers, is_out) || numbers[2] == 0 || numbers[3] == 0)
    throw Error(Location{option}, fmt::format("'{}'; expected X,Y,WIDTH,HEIGHT in pixels, such as 40,60,32,32", text));
  return {{numbers[0], numbers[1]}, {numbers[2], numbers[3]}};
}

}  // namespace etendue
