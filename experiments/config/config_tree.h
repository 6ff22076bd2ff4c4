// A TOML file as plain values with their places in the file, and the `-o key=value` overrides of it.
#pragma once

#include "framework/core/error.h"
#include "framework/core/lists.h"

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace etendue {

struct ConfigNode {
  using Array = std::vector<ConfigNode>;
  using Table = std::map<std::string, ConfigNode>;

  std::variant<bool, std::int64_t, double, std::string, Array, Table> value;
  Location where;      // of the value
  Location key_where;  // of the key that names it

  const Array* array() const { return std::get_if<Array>(&value); }
  const Table* table() const { return std::get_if<Table>(&value); }
  const std::string* text() const { return std::get_if<std::string>(&value); }
};

// Says "a boolean", "an integer", "a number", "text", "an array" or "a table".
const char* type_name(const ConfigNode& node);

// Throw Error with file:line:col on anything that is not TOML 1.0. Dates and times are errors too.
ConfigNode parse_config(std::string_view text, const std::string& path);
std::string read_config_text(const std::string& path);

// Applies "budget.time=5s" to the root table. Keys descend by '.'; in an array of methods a part is an index or a method's name
// ("integrators.path.mis=bsdf"). The value is read as TOML; what is not TOML is text.
void apply_override(ConfigNode& root, const std::string& assignment);

// Makes a table of a method named by its text alone, so that it can get parameters.
void make_table(ConfigNode& method);

// The values alone, in one order and one spelling: equal text means an equal experiment.
std::string canonical_text(const ConfigNode& node);

// nullptr where the table has no such key.
const ConfigNode* find_key(const ConfigNode& table, const std::string& key);

// One element or many: `accels = "sah"` is `accels = ["sah"]`. Throws Error on an empty array and on anything else.
std::vector<const ConfigNode*> list_elements(const ConfigNode& node, const std::string& key, const std::string& expected);

// Typed reads; they throw Error at the value, saying what was expected.
std::string read_text(const ConfigNode& node, const std::string& key, const char* expected = "text in quotes");
// Answers what `parse` makes of a value's text; its errors, which know no place, become those of the value.
template <class Parse>
auto read_parsed(const ConfigNode& node, const std::string& key, const Parse& parse) {
  const std::string text = read_text(node, key);
  try {
    return parse(text);
  } catch (const Error& e) {
    throw Error(node.where, key + ": " + e.what());
  }
}
std::int64_t read_whole(const ConfigNode& node, const std::string& key, std::int64_t low, std::int64_t high);  // also "200k"
double read_number(const ConfigNode& node, const std::string& key, double low, double high);
double read_duration(const ConfigNode& node, const std::string& key);  // "60s", or plain seconds; above zero
bool read_flag(const ConfigNode& node, const std::string& key);
// Names among `valid`, each once; `kind` is what an error calls them.
std::vector<std::string> read_names(const ConfigNode& node, const std::string& key, const std::string& kind,
                                    const std::vector<std::string>& valid);
// Reads [[key]], of which there is at least one.
const ConfigNode::Array& read_tables(const ConfigNode& node, const std::string& key);
[[noreturn]] void wrong_type(const ConfigNode& node, const std::string& key, const std::string& expected);

// Reads one table key by key; `finish` throws on the first key that was not read.
class TableReader {
 public:
  // `owner` names the table in messages: "experiment", "budget"; what is no table is told what was `expected`.
  TableReader(const ConfigNode& node, std::string owner, const std::string& expected = "a table");

  const ConfigNode* find(const std::string& key);  // nullptr where absent
  const ConfigNode& need(const std::string& key);  // throws where absent
  void finish() const;

  // Each takes the value of a key where the table has it, and leaves `value` as it is where it has not.
  template <class Whole>
  void whole(const std::string& key, Whole& value, std::int64_t low, std::int64_t high) {
    if (const ConfigNode* node = find(key)) value = static_cast<Whole>(read_whole(*node, label(key), low, high));
  }
  template <class Number>
  void number(const std::string& key, Number& value, double low, double high) {
    if (const ConfigNode* node = find(key)) value = read_number(*node, label(key), low, high);
  }
  template <class Seconds>
  void duration(const std::string& key, Seconds& value) {
    if (const ConfigNode* node = find(key)) value = read_duration(*node, label(key));
  }
  void flag(const std::string& key, bool& value) {
    if (const ConfigNode* node = find(key)) value = read_flag(*node, label(key));
  }
  void text(const std::string& key, std::string& value) {
    if (const ConfigNode* node = find(key)) value = read_text(*node, label(key));
  }
  void names(const std::string& key, std::vector<std::string>& value, const std::string& kind,
             const std::vector<std::string>& valid) {
    if (const ConfigNode* node = find(key)) value = read_names(*node, label(key), kind, valid);
  }
  // Those that must be there.
  std::int64_t needed_whole(const std::string& key, std::int64_t low, std::int64_t high) {
    return read_whole(need(key), label(key), low, high);
  }
  std::string needed_text(const std::string& key) { return read_text(need(key), label(key)); }

 private:
  std::string label(const std::string& key) const { return owner_ == "experiment" ? key : owner_ + "." + key; }

  const ConfigNode& node_;
  std::string owner_;
  std::vector<std::string> known_;
};

}  // namespace etendue
