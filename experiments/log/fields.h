// The fields of a record, listed once for both directions: `list_fields(fields, record)` puts them into a JSON object when
// `fields` is a FieldsOut, and takes them out of one when it is a FieldsIn.
//
//   void list_fields(auto& f, FieldsOf<CellRecord> auto& r) {
//     f("status", r.status);      // every line has it
//     f.maybe("strip", r.strip);  // left out where it has its default value, as in lines older than the field
//     FIELDS(status, error);      // of r, into f, under the names of the members
//     MAYBE_FIELDS(strip, note);
//   }
//
// Fields are numbers, text, points, vectors and maps of them, and records with a list of their own. A number that is not finite
// is the caller's mistake (CHECK); reading throws what the JSON library throws.
#pragma once

#include "experiments/config/cell_name.h"
#include "experiments/log/json_line.h"
#include "experiments/log/values.h"
#include "framework/core/vec.h"
#include "framework/io/whole_file.h"

#include <algorithm>
#include <concepts>
#include <iterator>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace etendue {

#define ETENDUE_FIELD(name) f(#name, r.name);
#define ETENDUE_MAYBE_FIELD(name) f.maybe(#name, r.name);
#define FIELDS(...) NLOHMANN_JSON_EXPAND(NLOHMANN_JSON_PASTE(ETENDUE_FIELD, __VA_ARGS__))
#define MAYBE_FIELDS(...) NLOHMANN_JSON_EXPAND(NLOHMANN_JSON_PASTE(ETENDUE_MAYBE_FIELD, __VA_ARGS__))

// T is the record, or const where it is only written.
template <class T, class Record>
concept FieldsOf = std::same_as<std::remove_const_t<T>, Record>;

class FieldsOut;
class FieldsIn;

template <class T>
concept HasFields = requires(FieldsOut& fields, const T& record) {
  list_fields(fields, record);
};
template <class T>
inline constexpr bool is_vector = false;
template <class T>
inline constexpr bool is_vector<std::vector<T>> = true;
template <class T>
inline constexpr bool is_map = false;
template <class T>
inline constexpr bool is_map<std::map<std::string, T>> = true;
template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;

template <class T>
Json written(const T& value);
template <class T>
T read_value(const Json& json);

class FieldsOut {
 public:
  Json json = Json::object();

  template <class T>
  void operator()(const char* key, const T& value) {
    json[key] = written(value);
  }
  template <class T>
  void maybe(const char* key, const T& value) {
    if constexpr (is_optional<T>) {
      if (value) (*this)(key, *value);
    } else if (value != T{}) {
      (*this)(key, value);
    }
  }
  // Counts by name, of which those that are 0 have no key.
  void counts(const char* key, std::map<std::string, std::uint64_t> counts) {
    std::erase_if(counts, [](const auto& count) { return count.second == 0; });
    (*this)(key, counts);
  }
  // An enumerator or a flag by its name.
  template <class T>
  void choice(const char* key, const T& value, std::span<const char* const> names) {
    json[key] = names[static_cast<std::size_t>(value)];
  }
  // An end of an interval, which has no key where it is infinite.
  void end(const char* key, const double& value, double) {
    if (std::isfinite(value)) json[key] = logged(value);
  }
  void cell(const CellName& cell, const char* accel = "accel", const char* integrator = "integrator") {
    json["scene"] = cell.scene;
    json[accel] = cell.accel;
    json[integrator] = cell.integrator;
    json["seed"] = cell.seed;
  }
  // A figure that was measured stands under its key, its quartiles beside it; one that was not has no keys.
  void measured(const std::string& key, const Measured& value) {
    if (value.median == 0) return;
    json[key] = logged(value.median);
    json[key + "_low"] = logged(value.low);
    json[key + "_high"] = logged(value.high);
  }
  // The size and the hash of the file that stands under `key`.
  void stamp(const std::string& key, const FileStamp& stamp) {
    if (stamp.hash.empty()) return;
    json[key + "_bytes"] = stamp.bytes;
    json[key + "_xxh3"] = stamp.hash;
  }
};

class FieldsIn {
 public:
  explicit FieldsIn(const Json& json) : json_(json) {}

  template <class T>
  void operator()(const char* key, T& value) {
    value = read_value<T>(json_.at(key));
  }
  template <class T>
  void maybe(const char* key, T& value) {
    const auto found = json_.find(key);
    value = found == json_.end() ? T{} : read_value<T>(*found);
  }
  void counts(const char* key, std::map<std::string, std::uint64_t>& counts) { (*this)(key, counts); }
  template <class T>
  void choice(const char* key, T& value, std::span<const char* const> names) {
    const std::string name = json_.at(key);
    const auto found = std::ranges::find(names, name);
    if (found != names.end()) value = static_cast<T>(found - names.begin());
  }
  void end(const char* key, double& value, double otherwise) { value = json_.value(key, otherwise); }
  void cell(CellName& cell, const char* accel = "accel", const char* integrator = "integrator") {
    cell = {json_.at("scene"), json_.at(accel), json_.at(integrator), read_value<std::uint64_t>(json_.at("seed"))};
  }
  void measured(const std::string& key, Measured& value) {
    const double median = json_.value(key, 0.0);
    value = {median, json_.value(key + "_low", median), json_.value(key + "_high", median)};
  }
  void stamp(const std::string& key, FileStamp& stamp) {
    stamp = {json_.value(key + "_bytes", std::uint64_t{0}), json_.value(key + "_xxh3", "")};
  }

 private:
  const Json& json_;
};

// JSON has no infinity, which stands there as text.
inline Json written_parameter(const ParameterValue& value) {
  return std::visit(
      [](const auto& held) {
        if constexpr (std::is_same_v<std::decay_t<decltype(held)>, double>)
          if (!std::isfinite(held)) return Json(to_text(ParamValue{held, {}}));
        return Json(held);
      },
      value);
}

inline ParameterValue read_parameter(const Json& json) {
  if (json.is_boolean()) return json.get<bool>();
  if (json.is_number_integer()) return json.get<std::int64_t>();
  if (json.is_number()) return json.get<double>();
  return json.get<std::string>();
}

template <class T>
Json written(const T& value) {
  if constexpr (HasFields<T>) {
    FieldsOut fields;
    list_fields(fields, value);
    return std::move(fields.json);
  } else if constexpr (std::is_floating_point_v<T>) {
    return logged(value);
  } else if constexpr (std::is_same_v<T, dvec2>) {
    return Json::array({logged(value.x), logged(value.y)});
  } else if constexpr (std::is_same_v<T, ParameterValue>) {
    return written_parameter(value);
  } else if constexpr (is_vector<T>) {
    Json array = Json::array();
    for (const auto& element : value) array.push_back(written(element));
    return array;
  } else if constexpr (is_map<T>) {
    Json object = Json::object();
    for (const auto& [key, element] : value) object[key] = written(element);
    return object;
  } else {
    return value;
  }
}

template <class T>
T read_value(const Json& json) {
  if constexpr (HasFields<T>) {
    T record{};
    FieldsIn fields(json);
    list_fields(fields, record);
    return record;
  } else if constexpr (is_optional<T>) {
    return read_value<typename T::value_type>(json);
  } else if constexpr (std::is_same_v<T, dvec2>) {
    return {json.at(0).get<double>(), json.at(1).get<double>()};
  } else if constexpr (std::is_same_v<T, ParameterValue>) {
    return read_parameter(json);
  } else if constexpr (is_vector<T>) {
    T values;
    for (const Json& element : json) values.push_back(read_value<typename T::value_type>(element));
    return values;
  } else if constexpr (is_map<T>) {
    T values;
    for (const auto& [key, element] : json.items()) values[key] = read_value<typename T::mapped_type>(element);
    return values;
  } else {
    return json.get<T>();
  }
}

// These fields of a KindRecord say how its cell ended.
void list_ending(auto& f, auto& record) {
  f("manifest", record.manifest);
  f("status", record.status);
  f("error", record.error);
}

// Writes a record as a line of the log, without its checksum.
template <HasFields Record>
std::string line_of(const char* type, const Record& record) {
  FieldsOut fields;
  fields.json["type"] = type;
  list_fields(fields, record);
  return dump(fields.json);
}

}  // namespace etendue
