// The fields of a line of the log by name and type, from the same lists that write and read it (fields.h). docs/log.md names
// each of them, which a test checks.
#pragma once

#include "experiments/log/fields.h"

#include <array>
#include <string>
#include <utility>
#include <vector>

namespace etendue {

// A field of a record within a list is named for both: "figures.value".
struct Field {
  std::string name, type;  // the type in JSON's words; "measured" stands for three numbers (FieldsOut::measured)
  bool optional = false;   // whether a line may lack it
};

struct LineFields {
  std::string type;  // of the line
  std::vector<Field> fields;
};

template <class T>
inline constexpr bool is_array = false;
template <class T, std::size_t n>
inline constexpr bool is_array<std::array<T, n>> = true;

template <class T>
std::string json_type() {
  if constexpr (HasFields<T>)
    return "object";
  else if constexpr (is_optional<T>)
    return json_type<typename T::value_type>();
  else if constexpr (is_vector<T> || is_array<T>)
    return "array of " + json_type<typename T::value_type>();
  else if constexpr (is_map<T>)
    return "object of " + json_type<typename T::mapped_type>();
  else if constexpr (std::is_same_v<T, dvec2>)
    return "array of number";
  else if constexpr (std::is_same_v<T, ParameterValue>)
    return "boolean, number or string";
  else if constexpr (std::is_same_v<T, bool>)
    return "boolean";
  else if constexpr (std::is_arithmetic_v<T>)
    return std::is_integral_v<T> ? "integer" : "number";
  else
    return "string";
}

// Visits a record with all of its fields, those included that stand only beside a flag: it sets flags.
class FieldLister {
 public:
  std::vector<Field> fields;

  template <class T>
  void operator()(const std::string& key, T& value) {
    add(key, value, false);
  }
  template <class T>
  void maybe(const std::string& key, T& value) {
    add(key, value, true);
  }
  void counts(const std::string& key, std::map<std::string, std::uint64_t>& value) { add(key, value, false); }
  template <class T>
  void choice(const std::string& key, T&, std::span<const char* const>) {
    fields.push_back({key, "string"});
  }
  void end(const std::string& key, double&, double) { fields.push_back({key, "number", true}); }
  void cell(CellName&, const char* accel = "accel", const char* integrator = "integrator") {
    for (const char* key : {"scene", accel, integrator}) fields.push_back({key, "string"});
    fields.push_back({"seed", "integer"});
  }
  void measured(const std::string& key, Measured&) { fields.push_back({key, "measured", true}); }
  void stamp(const std::string& key, FileStamp&) {
    fields.push_back({key + "_bytes", "integer", true});
    fields.push_back({key + "_xxh3", "string", true});
  }

 private:
  template <class T>
  void add(const std::string& key, T& value, bool optional) {
    fields.push_back({key, json_type<T>(), optional});
    if constexpr (std::is_same_v<T, bool>) value = true;
    if constexpr (HasFields<T>) {
      add_within(key, value);
    } else if constexpr (is_vector<T> || is_optional<T>) {
      if constexpr (HasFields<typename T::value_type>) {
        typename T::value_type element{};
        add_within(key, element);
      }
    }
  }
  void add_within(const std::string& key, auto& record) {
    FieldLister within;
    list_fields(within, record);
    for (Field& field : within.fields) fields.push_back({key + "." + field.name, field.type, field.optional});
  }
};

template <HasFields Record>
std::vector<Field> fields_of() {
  FieldLister lister;
  Record record{};
  list_fields(lister, record);
  return std::move(lister.fields);
}

std::vector<LineFields> log_line_fields();  // of the lines that log.h lists; each kind of experiment knows its own

}  // namespace etendue
