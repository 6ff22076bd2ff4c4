// A TOML file as plain values with their places in the file, and the `-o key=value` overrides of it.
#pragma once

#include "framework/core/error.h"

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

// "a boolean", "an integer", "a number", "text", "an array", "a table".
const char* type_name(const ConfigNode& node);

// Throw Error with file:line:col on anything that is not TOML 1.0. Dates and times are errors too.
ConfigNode parse_config(std::string_view text, const std::string& path);
std::string read_config_text(const std::string& path);

// Applies "budget.time=5s" to the root table. Keys descend by '.'; in an array of methods a part is an index or a method's name
// ("integrators.path.mis=bsdf"). The value is read as TOML; what is not TOML is text.
void apply_override(ConfigNode& root, const std::string& assignment);

// The values alone, in one order and one spelling: equal text means an equal experiment.
std::string canonical_text(const ConfigNode& node);

// nullptr where the table has no such key.
const ConfigNode* find_key(const ConfigNode& table, const std::string& key);

// Reads one table key by key; `finish` throws on the first key that was not read.
class TableReader {
 public:
  // `owner` names the table in messages: "experiment", "budget".
  TableReader(const ConfigNode& node, std::string owner);

  const ConfigNode* find(const std::string& key);  // nullptr where absent
  void finish() const;

 private:
  const ConfigNode::Table& table_;
  std::string owner_;
  std::vector<std::string> known_;
};

// One element or many: `accels = "sah"` is `accels = ["sah"]`. Throws Error on an empty array and on anything else.
std::vector<const ConfigNode*> list_elements(const ConfigNode& node, const std::string& key, const std::string& expected);

// Typed reads; they throw Error at the value, saying what was expected.
std::string read_text(const ConfigNode& node, const std::string& key, const char* expected = "text in quotes");
std::int64_t read_whole(const ConfigNode& node, const std::string& key, std::int64_t low, std::int64_t high);  // also "200k"
double read_number(const ConfigNode& node, const std::string& key, double low, double high);
double read_duration(const ConfigNode& node, const std::string& key);  // "60s", or plain seconds; above zero
[[noreturn]] void wrong_type(const ConfigNode& node, const std::string& key, const std::string& expected);

}  // namespace etendue
