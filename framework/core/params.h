// Parameters of methods: one struct per method, read, checked and listed by one table.
//
// A method writes
//
//     struct PathParams { int max_depth = 0; std::string mis = "power"; };
//     template <class Visitor> void describe(Visitor& v, PathParams& p) {
//       v.integer("max_depth", p.max_depth, 0, 65536, "bounces", "scattering events at most; 0: as the scene states");
//       v.choice("mis", p.mis, {"power", "balance", "light", "bsdf"}, "how light and BSDF sampling are combined");
//     }
//
// and gets `read_params<PathParams>(map)`, which throws on an unknown key, a wrong type or a value out of range, and
// `list_params<PathParams>()`, which `etendue list` prints.
#pragma once

#include "framework/core/error.h"

#include <cstdint>
#include <initializer_list>
#include <map>
#include <string>
#include <variant>
#include <vector>

namespace etendue {

struct ParamValue {
  std::variant<bool, std::int64_t, double, std::string> value;
  Location where;
};

using ParamMap = std::map<std::string, ParamValue>;  // ordered, so that a cell's name does not depend on typing order

std::string to_text(const ParamValue& value);
// "7", "0.5", "true" become numbers and booleans, all else stays text (the command line's `-p key=value`).
ParamValue parse_param_value(const std::string& text, const Location& where);

struct ParamInfo {
  std::string name, type, default_value, range, unit, help;
};

class ParamLister {
 public:
  std::vector<ParamInfo> infos;

  void integer(const char* name, int& value, std::int64_t low, std::int64_t high, const char* unit, const char* help);
  void number(const char* name, float& value, double low, double high, const char* unit, const char* help);
  void flag(const char* name, bool& value, const char* help);
  void choice(const char* name, std::string& value, std::initializer_list<const char*> options, const char* help);
  void bytes(const char* name, std::uint64_t& value, const char* help);
};

// Reads what `describe` names out of a map. Integers also take "200k", seconds are numbers, sizes are text with a unit
// ("512MiB") or "none", which is 0. `finish` throws on keys that nobody read.
class ParamReader {
 public:
  ParamReader(const ParamMap& map, std::string owner) : map_(map), owner_(std::move(owner)) {}

  void integer(const char* name, int& value, std::int64_t low, std::int64_t high, const char* unit, const char* help);
  void number(const char* name, float& value, double low, double high, const char* unit, const char* help);
  void flag(const char* name, bool& value, const char* help);
  void choice(const char* name, std::string& value, std::initializer_list<const char*> options, const char* help);
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
