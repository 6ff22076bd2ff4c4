// Parameters of methods: one struct per method, read, checked and listed by one table.
//
// A method writes
//
//     enum class Edges : std::uint8_t { disc, hull };
//     constexpr auto names_of(Edges) { return std::array{"disc", "hull"}; }
//     struct MapParams { int max_depth = 0; Edges edges = Edges::disc; };
//     template <class Visitor> void describe(Visitor& v, MapParams& p) {
//       v.integer("max_depth", p.max_depth, 0, 65536, "bounces", "scattering events at most; 0: as the scene states");
//       v.choice("edges", p.edges, "what photons are divided by");
//     }
//
// and gets `read_params<MapParams>(map)`, which throws on an unknown key, a wrong type or a value out of range, and
// `list_params<MapParams>()`, which `etendue list` prints.
#pragma once

#include "framework/core/error.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace etendue {

struct ParamValue {
  std::variant<bool, std::int64_t, double, std::string> value;
  Location where;
};

using ParamMap = std::map<std::string, ParamValue>;  // ordered, so that a cell's name does not depend on typing order

// The method or structure that `auto` chose to stand for it, and why: one sentence.
struct MethodChoice {
  std::string name;
  ParamMap params;
  std::string why;
};

std::string to_text(const ParamValue& value);
// "7", "0.5", "true" become numbers and booleans, all else stays text (the command line's `-p key=value`).
ParamValue parse_param_value(const std::string& text, const Location& where);

struct ParamInfo {
  std::string name, type, default_value, range, unit, help;
};

// An enum whose values have names, beside its definition and in its order: names_of(E) is an array of them.
template <class E>
concept NamedEnum = std::is_enum_v<E> && requires(E value) {
  names_of(value)[0];
};

template <NamedEnum E>
constexpr const char* name_of(E value) {
  return names_of(value)[static_cast<std::size_t>(value)];
}

using Names = std::span<const char* const>;

// Choices of a visitor of parameters, all by its `choose`: among an enum's values, or among texts that are data.
template <class Visitor>
class Choices {
 public:
  template <NamedEnum E>
  void choice(const char* name, E& value, const char* help) {
    static constexpr auto names = names_of(E{});
    std::string text = name_of(value);
    static_cast<Visitor*>(this)->choose(name, text, names, help);
    value = static_cast<E>(std::find(names.begin(), names.end(), text) - names.begin());
  }
  void choice(const char* name, std::string& value, std::initializer_list<const char*> options, const char* help) {
    static_cast<Visitor*>(this)->choose(name, value, {options.begin(), options.size()}, help);
  }
};

class ParamLister : public Choices<ParamLister> {
 public:
  std::vector<ParamInfo> infos;
  void integer(const char* name, int& value, std::int64_t low, std::int64_t high, const char* unit, const char* help);
  void number(const char* name, float& value, double low, double high, const char* unit, const char* help);
  void flag(const char* name, bool& value, const char* help);
  void choose(const char* name, std::string& value, Names options, const char* help);
  void bytes(const char* name, std::uint64_t& value, const char* help);
};

// Reads what `describe` names out of a map. Integers also take "200k", seconds are numbers, sizes are text with a unit
// ("512MiB") or "none", which is 0. `finish` throws on keys that nobody read.
class ParamReader : public Choices<ParamReader> {
 public:
  ParamReader(const ParamMap& map, std::string owner) : map_(map), owner_(std::move(owner)) {}

  void integer(const char* name, int& value, std::int64_t low, std::int64_t high, const char* unit, const char* help);
  void number(const char* name, float& value, double low, double high, const char* unit, const char* help);
  void flag(const char* name, bool& value, const char* help);
  void choose(const char* name, std::string& value, Names options, const char* help);
  void bytes(const char* name, std::uint64_t& value, const char* help);
  void finish() const;

 private:
  const ParamValue* find(const char* name);

  const ParamMap& map_;
  std::string owner_;
  std::vector<std::string> known_;
};

struct NoParams {};

template <class Visitor>
void describe(Visitor&, NoParams&) {}

template <class Params>
Params read_params(const ParamMap& map, const std::string& owner) {
  Params params;
  ParamReader reader(map, owner);
  describe(reader, params);
  reader.finish();
  return params;
}

template <class Params>
std::vector<ParamInfo> list_params() {
  Params params;
  ParamLister lister;
  describe(lister, params);
  return lister.infos;
}

}  // namespace etendue
