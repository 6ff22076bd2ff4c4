#include "experiments/harness/config_tree.h"

#include "framework/core/units.h"
#include "framework/io/text.h"

#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <optional>

namespace etendue {
[[noreturn]] static void fail_assumption() { throw Error("a key or table that is malformed"); }
}  // namespace etendue

// The parser assumes of some inputs what they do not hold ("[[[a]"), and anything may follow: what it assumes is checked.
#include <toml++/impl/preprocessor.h>
#undef TOML_ASSERT_ASSUME
#define TOML_ASSERT_ASSUME(condition) ((condition) ? static_cast<void>(0) : ::etendue::fail_assumption())
#include <toml++/toml.h>

namespace etendue {

namespace {

Location location(const std::string& file, const toml::source_region& region) {
  return {file, static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
}

ConfigNode convert(const toml::node& node, const std::string& file) {
  ConfigNode result;
  result.where = location(file, node.source());
  if (const auto* table = node.as_table()) {
    ConfigNode::Table entries;
    for (const auto& [key, value] : *table) {
      ConfigNode entry = convert(value, file);
      entry.key_where = location(file, key.source());
      entries.emplace(std::string(key.str()), std::move(entry));
    }
    result.value = std::move(entries);
  } else if (const auto* array = node.as_array()) {
    ConfigNode::Array elements;
    for (const auto& element : *array) elements.push_back(convert(element, file));
    result.value = std::move(elements);
  } else if (const auto* boolean = node.as_boolean()) {
    result.value = boolean->get();
  } else if (const auto* integer = node.as_integer()) {
    result.value = integer->get();
  } else if (const auto* number = node.as_floating_point()) {
    result.value = number->get();
  } else if (const auto* text = node.as_string()) {
    if (text->get().find('\0') != std::string::npos)
      throw Error(result.where, "text with the character U+0000; expected text without");
    result.value = text->get();
  } else {
    throw Error(result.where, "a date or time has no meaning here; expected a boolean, a number, text, an array or a table");
  }
  return result;
}

// The value of `text` if it is TOML, with every location naming the override.
std::optional<ConfigNode> parse_override_value(const std::string& text, const std::string& origin) {
  try {
    const toml::table parsed = toml::parse(std::string_view("v = " + text), std::string_view(origin));
    if (parsed.size() != 1) return std::nullopt;
    ConfigNode node = convert(*parsed.get("v"), origin);
    return node;
  } catch (const toml::parse_error&) {
    return std::nullopt;
  }
}

void forget_positions(ConfigNode& node) {
  node.where.line = node.where.column = node.key_where.line = node.key_where.column = 0;
  if (auto* array = std::get_if<ConfigNode::Array>(&node.value))
    for (ConfigNode& element : *array) forget_positions(element);
  if (auto* table = std::get_if<ConfigNode::Table>(&node.value))
    for (auto& [key, entry] : *table) forget_positions(entry);
}

std::string element_name(const ConfigNode& element) {
  if (const auto* text = element.text()) return *text;
  if (const auto* table = element.table())
    if (const auto found = table->find("name"); found != table->end())
      if (const auto* text = found->second.text()) return *text;
  return {};
}

ConfigNode& array_element(ConfigNode& node, const std::string& part, const Location& origin) {
  auto& array = std::get<ConfigNode::Array>(node.value);
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), index);
  if (error == std::errc() && end == part.data() + part.size()) {
    if (index < array.size()) return array[index];
    throw Error(origin, fmt::format("index {} is out of range; expected 0 .. {}", part, std::ptrdiff_t(array.size()) - 1));
  }
  std::vector<std::string> names;
  for (ConfigNode& element : array) {
    if (element_name(element) == part) return element;
    names.push_back(element_name(element));
  }
  throw Error(origin, unknown_name("element", part, names));
}

// The node one step down, made where it is absent, so that `budget.time=5s` works without a budget.
ConfigNode& descend(ConfigNode& node, const std::string& part, const Location& origin) {
  if (std::holds_alternative<ConfigNode::Array>(node.value)) return array_element(node, part, origin);
  // A method named by its text alone becomes a table when it gets a parameter.
  if (const auto* name = node.text()) {
    ConfigNode entry{*name, node.where, node.where};
    node.value = ConfigNode::Table{{"name", std::move(entry)}};
  }
  auto* table = std::get_if<ConfigNode::Table>(&node.value);
  if (!table) throw Error(origin, fmt::format("'{}' goes into {}; expected a table or an array there", part, type_name(node)));
  const auto [found, inserted] = table->try_emplace(part);
  if (inserted) found->second = {ConfigNode::Table{}, origin, origin};
  return found->second;
}

}  // namespace

const char* type_name(const ConfigNode& node) {
  static constexpr const char* names[] = {"a boolean", "an integer", "a number", "text", "an array", "a table"};
  return names[node.value.index()];
}

ConfigNode parse_config(std::string_view text, const std::string& path) {
  const auto parse = [&] {
    try {
      return toml::parse(text, std::string_view(path));
    } catch (const toml::parse_error& e) {
      throw Error(location(path, e.source()), fmt::format("not TOML: {}", e.description()));
    } catch (const Error& e) {  // of fail_assumption, which knows no place
      throw Error(Location{path}, fmt::format("not TOML: {}", e.what()));
    }
  };
  return convert(parse(), path);
}

std::string read_config_text(const std::string& path) {
  try {
    return read_file(path);
  } catch (const Error& e) {
    throw Error(Location{path}, fmt::format("cannot open the experiment; expected a .toml file: {}", e.what()));
  }
}

void apply_override(ConfigNode& root, const std::string& assignment) {
  const Location origin{"-o " + assignment};
  const auto equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) throw Error(origin, "expected key=value, such as budget.time=5s");
  ConfigNode* node = &root;
  std::string_view path = std::string_view(assignment).substr(0, equals);
  while (true) {
    const auto dot = path.find('.');
    const std::string part(path.substr(0, dot));
    if (part.empty()) throw Error(origin, "empty part in the key; expected names separated by single dots");
    node = &descend(*node, part, origin);
    if (dot == std::string_view::npos) break;
    path.remove_prefix(dot + 1);
  }
  const std::string text = assignment.substr(equals + 1);
  ConfigNode value = parse_override_value(text, origin.file).value_or(ConfigNode{text, origin, origin});
  forget_positions(value);
  node->value = std::move(value.value);
  node->where = node->key_where = origin;
}

std::string canonical_text(const ConfigNode& node) {
  struct {
    std::string operator()(bool b) const { return b ? "true" : "false"; }
    std::string operator()(std::int64_t i) const { return std::to_string(i); }
    std::string operator()(double d) const { return fmt::format("{:.17g}", d); }
    std::string operator()(const std::string& s) const { return fmt::format("{}:{}", s.size(), s); }
    std::string operator()(const ConfigNode::Array& array) const {
      std::string text = "[";
      for (const ConfigNode& element : array) text += canonical_text(element) + ",";
      return text + "]";
    }
    std::string operator()(const ConfigNode::Table& table) const {
      std::string text = "{";
      for (const auto& [key, entry] : table) text += fmt::format("{}:{}={},", key.size(), key, canonical_text(entry));
      return text + "}";
    }
  } visitor;
  return std::visit(visitor, node.value);
}

TableReader::TableReader(const ConfigNode& node, std::string owner)
    : table_(node.table() ? *node.table() : (wrong_type(node, owner, "a table"), *node.table())), owner_(std::move(owner)) {}

const ConfigNode* TableReader::find(const std::string& key) {
  known_.push_back(key);
  const auto found = table_.find(key);
  return found == table_.end() ? nullptr : &found->second;
}

void TableReader::finish() const {
  // The first by place in the file, so that one sees the mistakes in reading order.
  const ConfigNode* first = nullptr;
  std::string first_key;
  for (const auto& [key, node] : table_) {
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    if (!first ||
        std::pair(node.key_where.line, node.key_where.column) < std::pair(first->key_where.line, first->key_where.column)) {
      first = &node;
      first_key = key;
    }
  }
  if (first) throw Error(first->key_where, owner_ + ": " + unknown_name("key", first_key, known_));
}

void wrong_type(const ConfigNode& node, const std::string& key, const std::string& expected) {
  throw Error(node.where, fmt::format("{} is {}; expected {}", key, type_name(node), expected));
}

std::vector<const ConfigNode*> list_elements(const ConfigNode& node, const std::string& key, const std::string& expected) {
  std::vector<const ConfigNode*> list;
  if (const auto* array = node.array()) {
    for (const ConfigNode& element : *array) list.push_back(&element);
  } else if (node.text()) {
    list.push_back(&node);
  } else {
    wrong_type(node, key, expected);
  }
  if (list.empty()) throw Error(node.where, key + " is empty; expected " + expected);
  return list;
}

std::string read_text(const ConfigNode& node, const std::string& key, const char* expected) {
  const auto* text = node.text();
  if (!text) wrong_type(node, key, expected);
  return *text;
}

std::int64_t read_whole(const ConfigNode& node, const std::string& key, std::int64_t low, std::int64_t high) {
  std::int64_t number = 0;
  if (const auto* integer = std::get_if<std::int64_t>(&node.value)) {
    number = *integer;
  } else if (const auto* text = node.text()) {
    try {
      number = parse_count(*text);
    } catch (const Error& e) {
      throw Error(node.where, fmt::format("{}: {}", key, e.what()));
    }
  } else {
    wrong_type(node, key, "a whole number such as 1000 or \"200k\"");
  }
  if (number < low || number > high)
    throw Error(node.where, fmt::format("{} = {} is out of range; expected {} .. {}", key, number, low, high));
  return number;
}

double read_number(const ConfigNode& node, const std::string& key, double low, double high) {
  double number = 0;
  if (const auto* d = std::get_if<double>(&node.value)) {
    number = *d;
  } else if (const auto* i = std::get_if<std::int64_t>(&node.value)) {
    number = static_cast<double>(*i);
  } else {
    wrong_type(node, key, "a number");
  }
  if (!(number >= low && number <= high))
    throw Error(node.where, fmt::format("{} = {:g} is out of range; expected {:g} .. {:g}", key, number, low, high));
  return number;
}

double read_duration(const ConfigNode& node, const std::string& key) {
  double seconds = 0;
  if (const auto* text = node.text()) {
    try {
      seconds = parse_seconds(*text);
    } catch (const Error& e) {
      throw Error(node.where, fmt::format("{}: {}", key, e.what()));
    }
  } else if (std::holds_alternative<double>(node.value) || std::holds_alternative<std::int64_t>(node.value)) {
    seconds = read_number(node, key, 0, 1e9);
  } else {
    wrong_type(node, key, "a time such as \"60s\" (units: s, ms, min, h)");
  }
  if (!(seconds > 0)) throw Error(node.where, fmt::format("{} = {:g} s; expected a time above zero", key, seconds));
  return seconds;
}

}  // namespace etendue
