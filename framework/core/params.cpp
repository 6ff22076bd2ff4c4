#include "framework/core/params.h"

#include "framework/core/units.h"

#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <cmath>

namespace etendue {

namespace {

std::string range_text(double low, double high) { return fmt::format("{:g} .. {:g}", low, high); }

const char* type_name(const ParamValue& value) {
  static constexpr const char* names[] = {"a boolean", "an integer", "a number", "text"};
  return names[value.value.index()];
}

std::string join(Names options, const char* separator) {
  std::string text;
  for (const char* option : options) text += (text.empty() ? "" : separator) + std::string(option);
  return text;
}

Error wrong_type(const ParamValue& value, const std::string& owner, const char* name, const std::string& expected) {
  return Error(value.where,
               fmt::format("{}: {} = {} is {}; expected {}", owner, name, to_text(value), type_name(value), expected));
}

Error out_of_range(const ParamValue& value, const std::string& owner, const char* name, const std::string& range,
                   const char* unit) {
  return Error(value.where, fmt::format("{}: {} = {} is out of range; expected {}{}{}", owner, name, to_text(value), range,
                                        *unit ? " " : "", unit));
}

}  // namespace

std::string to_text(const ParamValue& value) {
  struct {
    std::string operator()(bool b) const { return b ? "true" : "false"; }
    std::string operator()(std::int64_t i) const { return std::to_string(i); }
    std::string operator()(double d) const { return fmt::format("{}", d); }
    std::string operator()(const std::string& s) const { return s; }
  } visitor;
  return std::visit(visitor, value.value);
}

ParamValue parse_param_value(const std::string& text, const Location& where) {
  if (text == "true" || text == "false") return {text == "true", where};
  const char* end = text.data() + text.size();
  std::int64_t integer = 0;
  if (const auto r = std::from_chars(text.data(), end, integer); r.ec == std::errc() && r.ptr == end) return {integer, where};
  double number = 0;
  if (const auto r = std::from_chars(text.data(), end, number); r.ec == std::errc() && r.ptr == end) return {number, where};
  return {text, where};
}

void ParamLister::integer(const char* name, int& value, std::int64_t low, std::int64_t high, const char* unit,
                          const char* help) {
  infos.push_back({name, "integer", std::to_string(value), fmt::format("{} .. {}", low, high), unit, help});
}

void ParamLister::number(const char* name, float& value, double low, double high, const char* unit, const char* help) {
  infos.push_back({name, "number", fmt::format("{:g}", value), range_text(low, high), unit, help});
}

void ParamLister::flag(const char* name, bool& value, const char* help) {
  infos.push_back({name, "boolean", value ? "true" : "false", "true | false", "", help});
}

void ParamLister::choose(const char* name, std::string& value, Names options, const char* help) {
  infos.push_back({name, "text", value, join(options, " | "), "", help});
}

void ParamLister::bytes(const char* name, std::uint64_t& value, const char* help) {
  infos.push_back(
      {name, "size", value == 0 ? "none" : fmt::format("{}B", value), "none | 1B ..", "(B, KB, MB, GB, KiB, MiB, GiB)", help});
}

const ParamValue* ParamReader::find(const char* name) {
  known_.emplace_back(name);
  const auto found = map_.find(name);
  return found == map_.end() ? nullptr : &found->second;
}

void ParamReader::integer(const char* name, int& value, std::int64_t low, std::int64_t high, const char* unit, const char*) {
  const ParamValue* given = find(name);
  if (!given) return;
  std::int64_t number = 0;
  if (const auto* i = std::get_if<std::int64_t>(&given->value)) {
    number = *i;
  } else if (const auto* s = std::get_if<std::string>(&given->value)) {
    try {
      number = parse_count(*s);
    } catch (const Error& e) {
      throw Error(given->where, fmt::format("{}: {}: {}", owner_, name, e.what()));
    }
  } else {
    throw wrong_type(*given, owner_, name, "an integer such as 1000 or \"200k\"");
  }
  if (number < low || number > high) throw out_of_range(*given, owner_, name, fmt::format("{} .. {}", low, high), unit);
  value = static_cast<int>(number);
}

void ParamReader::number(const char* name, float& value, double low, double high, const char* unit, const char*) {
  const ParamValue* given = find(name);
  if (!given) return;
  double number = 0;
  if (const auto* d = std::get_if<double>(&given->value)) {
    number = *d;
  } else if (const auto* i = std::get_if<std::int64_t>(&given->value)) {
    number = static_cast<double>(*i);
  } else {
    throw wrong_type(*given, owner_, name, "a number");
  }
  if (!(number >= low && number <= high)) throw out_of_range(*given, owner_, name, range_text(low, high), unit);
  value = static_cast<float>(number);
}

void ParamReader::flag(const char* name, bool& value, const char*) {
  const ParamValue* given = find(name);
  if (!given) return;
  const auto* b = std::get_if<bool>(&given->value);
  if (!b) throw wrong_type(*given, owner_, name, "true or false");
  value = *b;
}

void ParamReader::choose(const char* name, std::string& value, Names options, const char*) {
  const ParamValue* given = find(name);
  if (!given) return;
  const auto* s = std::get_if<std::string>(&given->value);
  if (!s) throw wrong_type(*given, owner_, name, "one of " + join(options, ", "));
  if (std::find_if(options.begin(), options.end(), [&](const char* o) { return *s == o; }) == options.end()) {
    const std::vector<std::string> names(options.begin(), options.end());
    throw Error(given->where, owner_ + ": " + unknown_name(name, *s, names));
  }
  value = *s;
}

void ParamReader::bytes(const char* name, std::uint64_t& value, const char*) {
  const ParamValue* given = find(name);
  if (!given) return;
  const auto* s = std::get_if<std::string>(&given->value);
  if (!s) throw wrong_type(*given, owner_, name, "a size with its unit, such as \"512MiB\", or \"none\"");
  if (*s == "none") {
    value = 0;
    return;
  }
  std::int64_t size = 0;
  try {
    size = parse_bytes(*s);
  } catch (const Error& e) {
    throw Error(given->where, fmt::format("{}: {}: {}", owner_, name, e.what()));
  }
  if (size < 1) throw out_of_range(*given, owner_, name, "1B or more", "");
  value = static_cast<std::uint64_t>(size);
}

void ParamReader::finish() const {
  for (const auto& [name, value] : map_) {
    if (std::find(known_.begin(), known_.end(), name) == known_.end())
      throw Error(value.where, owner_ + ": " + unknown_name("parameter", name, known_));
  }
}

}  // namespace etendue
