#include "experiments/config/method.h"

#include "accel/bvh/dynamic/change_policy.h"
#include "accel/registry.h"
#include "framework/core/units.h"
#include "framework/scene/motion.h"
#include "integrators/registry.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <set>
#include <sstream>

namespace etendue {

namespace {

void normalise_integers(Method& method, const std::vector<ParamInfo>& infos) {
  for (const ParamInfo& info : infos) {
    const auto found = method.params.find(info.name);
    if (info.type != "integer" || found == method.params.end()) continue;
    if (const auto* text = std::get_if<std::string>(&found->second.value)) found->second.value = parse_count(*text);
  }
}

ParamValue read_param(const ConfigNode& node, const std::string& key, const char* expected) {
  if (const auto* b = std::get_if<bool>(&node.value)) return {*b, node.where};
  if (const auto* i = std::get_if<std::int64_t>(&node.value)) return {*i, node.where};
  if (const auto* d = std::get_if<double>(&node.value)) return {*d, node.where};
  if (const auto* s = node.text()) return {*s, node.where};
  wrong_type(node, key, expected);
}

// Reads a single value, or those of an array.
std::vector<ParamValue> read_values(const ConfigNode& node, const std::string& key) {
  const auto* array = node.array();
  if (!array) return {read_param(node, key, "a boolean, a number, text or an array of these")};
  if (array->empty()) throw Error(node.where, key + " is empty; expected one value or more");
  return mapped(*array, [&](const ConfigNode& element) { return read_param(element, key, "a boolean, a number or text"); });
}

constexpr std::size_t most_combinations = 10'000;
constexpr const char* label_key = "label";

// An experiment's own label of a method.
std::string read_label(const ConfigNode& node, const std::string& key) {
  constexpr std::size_t longest = 80;
  std::string label = read_text(node, key + "." + label_key);
  const bool plain = std::ranges::none_of(label, [](char c) { return static_cast<unsigned char>(c) < ' '; });
  if (label.find_first_not_of(' ') == std::string::npos || label.size() > longest || !plain)
    throw Error(node.where, fmt::format("{}.{}: '{}'; expected one line of 1 to {} bytes", key, label_key, label, longest));
  return label;
}

// A table stands for one method for each combination of the values that its arrays list: by name of parameter, the last
// changing fastest. Their own label tells them apart by those parameters. `find` is find_integrator or one of its kin.
template <class Find>
std::vector<Method> read_combinations(const ConfigNode& node, const std::string& key, const Find& find, OwnLabels own_labels) {
  if (const auto* text = node.text()) return {{*text, {}, node.where}};
  const auto* table = node.table();
  if (!table) wrong_type(node, key, "names or tables { name = \"…\", parameters… }");
  const auto name = table->find("name");
  if (name == table->end()) throw Error(node.where, key + ": a table without a name; expected { name = \"…\", parameters… }");
  Method bare{read_text(name->second, key + ".name"), {}, name->second.where};

  std::vector<std::string> known{"name"};
  const bool labels = own_labels == OwnLabels::allowed;
  if (labels) known.emplace_back(label_key);
  if (const auto label = table->find(label_key); labels && label != table->end())
    bare.shown_as = read_label(label->second, key);
  for (const ParamInfo& info : find(bare.name, bare.where).params) known.push_back(info.name);
  std::vector<Method> methods{bare};
  for (const auto& [parameter, value] : *table) {
    if (parameter == "name" || (labels && parameter == label_key)) continue;
    constexpr std::array of_the_file{"accels",  "budget",     "confidence", "metrics", "reference",
                                     "regions", "resolution", "scenes",     "seeds",   "threads"};
    if (contains(of_the_file, parameter) && !contains(known, parameter))
      throw Error(value.key_where, fmt::format("{}: '{}' is a key of the file, not a parameter; expected it before the first "
                                               "[table] or [[table]]",
                                               bare.name, parameter));
    require_name(value.key_where, "parameter", parameter, known, bare.name + ": ");
    const std::vector<ParamValue> values = read_values(value, key + "." + parameter);
    if (methods.size() * values.size() > most_combinations)
      throw Error(value.where, fmt::format("{}.{} makes {} combinations of the arrays so far; expected {} at most", key,
                                           parameter, methods.size() * values.size(), most_combinations));
    std::vector<Method> combined;
    for (const Method& method : methods)
      for (const ParamValue& choice : values) {
        Method& one = combined.emplace_back(method);
        one.params.emplace(parameter, choice);
        if (!one.shown_as.empty() && values.size() > 1) one.shown_as += fmt::format(" {}={}", parameter, to_text(choice));
      }
    methods = std::move(combined);
  }
  return methods;
}

// Names the place of the error: that element where an array of one table lists a value twice ("3" is 3), else the name.
[[noreturn]] void refuse_repetition(const std::string& key, const Method& earlier, const Method& method, bool of_one_table) {
  if (of_one_table)
    for (const auto& [parameter, value] : method.params)
      if (value.where.text() != earlier.params.at(parameter).where.text())
        throw Error(value.where, fmt::format("{}: {} of {} lists {} twice; expected each value once", key, parameter,
                                             method.name, to_text(value)));
  throw Error(method.where, fmt::format("{}: '{}' stands there twice; expected each once", key, method.label()));
}

// Reports must tell the methods apart.
void refuse_equal_labels(const std::string& key, const std::vector<Method>& methods) {
  std::set<std::string> seen;
  for (const Method& method : methods)
    if (const std::string shown = method.shown_as.empty() ? method.label() : method.shown_as; !seen.insert(shown).second)
      throw Error(method.where, fmt::format("{}: two methods are shown as '{}'; expected labels that differ", key, shown));
}

template <class Find, class Validate>
std::vector<Method> read_methods(const ConfigNode& node, const std::string& key, const Find& find, const Validate& validate,
                                 OwnLabels own_labels = OwnLabels::refused) {
  std::vector<Method> methods;
  std::map<std::string, std::size_t> index_by_label;
  for (const ConfigNode* element : list_elements(node, key, "an array of names or tables")) {
    const std::size_t first_of_table = methods.size();
    for (Method& method : read_combinations(*element, key, find, own_labels)) {
      validate(method);
      const auto [found, is_new] = index_by_label.emplace(method.label(), methods.size());
      if (!is_new) refuse_repetition(key, methods[found->second], method, found->second >= first_of_table);
      methods.push_back(std::move(method));
    }
  }
  refuse_equal_labels(key, methods);
  return methods;
}

}  // namespace

std::vector<std::string> words_of(const std::string& label) {
  std::istringstream words(label);
  return {std::istream_iterator<std::string>(words), {}};
}

std::string Method::label() const {
  std::string text = name;
  for (const auto& [key, value] : params) text += fmt::format(" {}={}", key, to_text(value));
  return text;
}

void validate_integrator(Method& method) {
  const IntegratorEntry& entry = find_integrator(method.name, method.where);
  entry.make(method.params);
  normalise_integers(method, entry.params);
}

void validate_accel(Method& method) {
  const RayEntry& entry = find_ray_structure(method.name, method.where);
  entry.make(Scene{}, method.params);
  normalise_integers(method, entry.params);
}

std::vector<Method> read_integrators(const ConfigNode& node, OwnLabels own_labels) {
  return read_methods(node, "integrators", find_integrator, validate_integrator, own_labels);
}

std::vector<Method> read_accels(const ConfigNode& node, OwnLabels own_labels) {
  if (!node.text() || *node.text() != "all")
    return read_methods(node, "accels", find_ray_structure, validate_accel, own_labels);
  return all_accels(node.where);
}

ConfigNode method_table(ConfigNode method) {
  make_table(method);
  if (!method.table()) wrong_type(method, "method", "a table { name, … }");
  for (const auto& [parameter, value] : *method.table())
    if (value.array()) wrong_type(value, "method." + parameter, "a single value");
  return method;
}

ConfigNode method_table(ConfigNode method, const ConfigNode& changes, const std::string& owner) {
  if (!changes.table()) wrong_type(changes, owner, "a table { parameters… }");
  make_table(method);
  if (auto* table = std::get_if<ConfigNode::Table>(&method.value))
    for (const auto& [key, value] : *changes.table()) table->insert_or_assign(key, value);
  return method_table(std::move(method));
}

Method read_method(const ConfigNode& table, bool of_structure) {
  const ConfigNode one{ConfigNode::Array{table}, table.where, table.key_where};
  return (of_structure ? read_accels(one) : read_integrators(one)).front();
}

void erase_own_labels(ConfigNode& node) {
  if (auto* array = std::get_if<ConfigNode::Array>(&node.value)) std::ranges::for_each(*array, erase_own_labels);
  if (auto* table = std::get_if<ConfigNode::Table>(&node.value)) table->erase(label_key);
}

std::vector<Method> read_motions(const ConfigNode& node) {
  return read_methods(node, "dynamic.motions", find_motion, [](Method& method) {
    const MotionEntry& entry = find_motion(method.name, method.where);
    entry.make({Geometry{}, 1, 1}, method.params);
    normalise_integers(method, entry.params);
  });
}

std::vector<Method> read_policies(const ConfigNode& node) {
  return read_methods(node, "dynamic.policies", find_change_policy,
                      [](Method& method) { find_change_policy(method.name, method.where).make(method.params); });
}

Method default_accel(const std::string& integrator) {
  if (integrator == "auto") return {"auto", {}, {}};
  return {"binned-sah", {{"layout", {std::string("auto"), {}}}}, {}};
}

std::vector<Method> all_accels(const Location& where) {
  std::vector<Method> methods;
  for (const RayEntry& entry : ray_structures()) {
    if (!entry.available || entry.name == "auto") continue;  // `auto` is one of the others
    methods.push_back({entry.name, {}, where});
    const auto add = [&](const char* parameter, const auto& value) {
      methods.push_back({entry.name, {{parameter, {value, where}}}, where});
    };
    if (entry.name == "binned-sah")
      for (const char* layout : {"bvh4", "bvh8"}) add("layout", std::string(layout));
    if (entry.name == "binned-sah" || entry.name == "sbvh" || entry.name == "ploc") add("layout", std::string("bvh16"));
    if (entry.name == "embree") {
      add("robust", true);
      add("batches", std::string("coherent"));
    }
  }
  return methods;
}

}  // namespace etendue
