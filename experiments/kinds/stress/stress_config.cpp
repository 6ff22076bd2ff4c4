#include "experiments/kinds/stress/stress_config.h"

#include "experiments/kinds/rows.h"
#include "framework/io/load_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

namespace etendue {

namespace {

std::string replaced(std::string text, const std::string& variable, double value) {
  const std::string number = fmt::format("{:.6g}", value);
  for (std::size_t at = text.find(variable); at != std::string::npos; at = text.find(variable, at + number.size()))
    text.replace(at, variable.size(), number);
  return text;
}

// A variable in a table's texts, replaced; what was nothing else becomes a number.
ConfigNode substituted(ConfigNode node, const std::string& variable, double value, bool whole) {
  if (auto* table = std::get_if<ConfigNode::Table>(&node.value))
    for (auto& [key, entry] : *table) entry = substituted(std::move(entry), variable, value, whole);
  if (const std::string* text = node.text()) {
    if (*text != variable)
      node.value = replaced(*text, variable, value);
    else if (whole)
      node.value = static_cast<std::int64_t>(value);
    else
      node.value = value;
  }
  return node;
}

// A method's table with the parameters of `change` in the place of its own.
ConfigNode changed(ConfigNode method, const ConfigNode& change, const std::string& owner) {
  ConfigNode table = method_table(std::move(method), change, owner);
  if (const ConfigNode* name = find_key(change, "name"))
    throw Error(name->key_where, owner + ": parameters alone; expected another method to stand for itself");
  return table;
}

std::map<std::string, const ConfigNode*> entries_of(const ConfigNode* node, const std::string& owner,
                                                    const std::vector<std::string>& names) {
  std::map<std::string, const ConfigNode*> entries;
  if (!node) return entries;
  TableReader reader(*node, owner, "a table by methods' names");
  for (const std::string& name : names)
    if (const ConfigNode* entry = reader.find(name)) entries[name] = entry;
  reader.finish();
  return entries;
}

// The columns of the matrix.
struct Columns {
  std::vector<std::string> names;
  std::map<std::string, ConfigNode> nodes;
  std::map<std::string, std::uint64_t> samples;
};

void read_samples(const ConfigNode* node, const std::string& owner, Columns& columns) {
  for (const auto& [name, entry] : entries_of(node, owner, columns.names))
    columns.samples[name] = static_cast<std::uint64_t>(read_whole(*entry, owner + "." + name, 1, 1'000'000'000));
}

Columns read_columns(const ConfigNode& node, std::uint64_t samples) {
  const std::vector<Method> methods = read_integrators(node, OwnLabels::allowed);
  const std::vector<const ConfigNode*> elements = list_elements(node, "integrators", "an array of names or tables");
  Columns columns;
  for (const ConfigNode* element : elements) {
    ConfigNode table = method_table(*element);
    const ConfigNode* label = find_key(table, "label");
    std::string name = *(label ? label : find_key(table, "name"))->text();
    erase_own_labels(table);
    if (columns.nodes.contains(name))
      throw Error(element->where,
                  fmt::format("integrators: '{}' stands there twice; expected a label = \"…\" for one of them", name));
    columns.samples[name] = samples;
    columns.nodes.emplace(name, std::move(table));
    columns.names.push_back(std::move(name));
  }
  return columns;
}

std::optional<Expected> single_expectation(const ConfigNode* node, const std::string& owner) {
  if (!node) return std::nullopt;
  return read_expectations(*node, owner, {"threshold"}).at("threshold");
}

// A scene that {y} stands in is checked for each value of it.
void check_scene(const StressHazard& hazard, const std::string& scene, const Location& where) {
  if (!scene.starts_with(builtin_prefix) || scene.find(row_variable) != std::string::npos) return;
  for (const double t : {0.0, 1.0}) check_builtin(with_variable(scene, hazard.range.at(t)), where);
}

// The same image by another scene, for methods that the first one would shut out.
void read_alternative(TableReader& row, StressHazard& hazard, const Columns& columns) {
  const ConfigNode* node = row.find("alternative");
  if (!node) return;
  TableReader reader(*node, "stress.alternative");
  const std::string scene = reader.needed_text("scene");
  check_scene(hazard, scene, reader.need("scene").where);
  for (const std::string& name : read_names(reader.need("methods"), "stress.alternative.methods", "method", columns.names))
    std::ranges::find(hazard.trials, name, &StressTrial::method)->scene = scene;
  reader.finish();
}

// Both ends are made, so that a value out of range is an error of the file.
void check_trial(const StressHazard& hazard, const StressTrial& trial) {
  if (trial.inapplicable.empty())
    for (const double t : {0.0, 1.0}) method_at(hazard, trial, hazard.range.at(t));
}

StressTrial read_remedy(const ConfigNode& node, const StressHazard& hazard) {
  TableReader row(node, "stress.remedies");
  StressTrial trial{.method = row.needed_text("of"), .remedy = row.needed_text("name")};
  const auto found =
      std::ranges::find_if(hazard.trials, [&](const StressTrial& t) { return t.method == trial.method && t.remedy.empty(); });
  if (found == hazard.trials.end() || !found->inapplicable.empty())
    throw Error(row.need("of").where,
                fmt::format("stress.remedies.of: '{}'; expected a method that hazard {} applies to", trial.method, hazard.id));
  trial.scene = found->scene;
  trial.node = changed(found->node, row.need("change"), "change");
  trial.samples = found->samples;
  row.whole("samples", trial.samples, 1, 1'000'000'000);
  trial.expected = single_expectation(row.find("expect"), "stress.remedies.expect");
  row.finish();
  return trial;
}

void read_range(TableReader& row, StressHazard& hazard) {
  const ConfigNode& node = row.need("range");
  const auto* ends = node.array();
  if (!ends || ends->size() != 2) wrong_type(node, "stress.range", "[harmless, harmful]");
  hazard.range.from = read_number((*ends)[0], "stress.range", 1e-12, 1e12);
  hazard.range.to = read_number((*ends)[1], "stress.range", 1e-12, 1e12);
  row.flag("whole", hazard.range.whole);
  if (hazard.range.from == hazard.range.to) throw Error(node.where, "stress.range: expected two ends that differ");
}

// Which figure is taken, and between what it is that of a sound method.
void read_bound(TableReader& row, StressHazard& hazard) {
  const ConfigNode& node = row.need("holds");
  const auto bound = read_expectations(node, "stress.holds", entry_names(stress_figures()));
  if (bound.size() != 1) throw Error(node.where, "stress.holds: expected one figure, { relmse = [0, 0.1] }");
  hazard.figure = &find_stress_figure(bound.begin()->first, node.where);
  hazard.holds = bound.begin()->second;
}

void read_structures(TableReader& row, const ConfigNode& structures, StressHazard& hazard) {
  for (const Method& accel : read_accels(structures))
    hazard.trials.push_back(
        {.method = accel.label(), .scene = hazard.scene, .node = {accel.label(), accel.where, accel.where}});
  const std::vector<std::string> names = mapped(hazard.trials, &StressTrial::method);
  if (const ConfigNode* expect = row.find("expect"))
    for (const auto& [name, expected] : read_expectations(*expect, "stress.expect", names))
      std::ranges::find(hazard.trials, name, &StressTrial::method)->expected = expected;
}

void read_methods(TableReader& row, StressHazard& hazard, Columns columns) {
  read_samples(row.find("samples"), "stress.samples", columns);
  const auto settings = entries_of(row.find("settings"), "stress.settings", columns.names);
  const auto inapplicable = entries_of(row.find("inapplicable"), "stress.inapplicable", columns.names);
  std::map<std::string, Expected> expected;
  if (const ConfigNode* expect = row.find("expect")) expected = read_expectations(*expect, "stress.expect", columns.names);
  for (const std::string& name : columns.names) {
    StressTrial trial{
        .method = name, .scene = hazard.scene, .node = columns.nodes.at(name), .samples = columns.samples.at(name)};
    if (const auto own = settings.find(name); own != settings.end())
      trial.node = changed(std::move(trial.node), *own->second, "stress.settings." + name);
    if (const auto why = inapplicable.find(name); why != inapplicable.end())
      trial.inapplicable = read_text(*why->second, "stress.inapplicable." + name);
    if (const auto of = expected.find(name); of != expected.end()) trial.expected = of->second;
    check_trial(hazard, trial);
    hazard.trials.push_back(std::move(trial));
  }
  read_alternative(row, hazard, columns);
  if (const ConfigNode* remedies = row.find("remedies"))
    for (const ConfigNode& remedy : read_tables(*remedies, "stress.remedies")) {
      StressTrial trial = read_remedy(remedy, hazard);
      for (const StressTrial& other : hazard.trials)
        if (other.method == trial.method && other.remedy == trial.remedy)
          throw Error(remedy.where, fmt::format("stress.remedies: '{}' of {} stands there twice", trial.remedy, trial.method));
      check_trial(hazard, trial);
      hazard.trials.push_back(std::move(trial));
    }
}

std::vector<double> read_numbers(const ConfigNode& node, const std::string& key, std::size_t least) {
  const auto* array = node.array();
  if (!array || array->size() < least) wrong_type(node, key, fmt::format("an array of {} numbers or more", least));
  return mapped(*array, [&](const ConfigNode& value) { return read_number(value, key, 1e-12, 1e12); });
}

// The thresholds that theory expects, one for each value of y; empty: none.
std::vector<double> read_boundary(TableReader& table, std::size_t rows) {
  const ConfigNode* node = table.find("expect");
  if (!node) return {};
  std::vector<double> expected = read_numbers(*node, "stress.rows.expect", rows);
  if (expected.size() != rows)
    throw Error(node->where, fmt::format("stress.rows.expect: {} thresholds; expected one for each of {} values of y",
                                         expected.size(), rows));
  return expected;
}

// One method along x, for each value of a second parameter.
void read_rows_of_map(TableReader& row, const ConfigNode& node, StressHazard& hazard, Columns columns) {
  TableReader table(node, "stress.rows");
  const ConfigNode& of = table.need("of");
  const std::string method =
      read_names({ConfigNode::Array{of}, of.where, node.key_where}, "stress.rows.of", "method", columns.names).front();
  const ConfigNode* samples = row.find("samples");
  entries_of(samples, "stress.samples", {method});  // no other method has any here
  read_samples(samples, "stress.samples", columns);
  hazard.second = table.needed_text("y");
  table.text("unit", hazard.second_unit);
  const std::vector<double> values = read_numbers(table.need("values"), "stress.rows.values", 2);
  if (!std::ranges::is_sorted(values, std::less_equal<>()))
    throw Error(table.need("values").where, "stress.rows.values: expected them to ascend");
  const std::vector<double> expected = read_boundary(table, values.size());
  table.finish();
  ConfigNode method_node = columns.nodes.at(method);
  const auto settings = entries_of(row.find("settings"), "stress.settings", {method});
  if (!settings.empty()) method_node = changed(std::move(method_node), *settings.at(method), "stress.settings." + method);
  for (std::size_t i = 0; i < values.size(); ++i) {
    StressTrial trial{.method = method,
                      .scene = replaced(hazard.scene, row_variable, values[i]),
                      .node = substituted(method_node, row_variable, values[i], values[i] == std::round(values[i])),
                      .samples = columns.samples.at(method),
                      .y = values[i]};
    if (!expected.empty()) trial.expected = Expected{expected[i], expected[i]};
    check_scene(hazard, trial.scene, row.need("scene").where);
    check_trial(hazard, trial);
    hazard.trials.push_back(std::move(trial));
  }
  const auto differ = [&](double x) {
    return hazard.trials[0].scene != hazard.trials[1].scene ||
           method_at(hazard, hazard.trials[0], x).label() != method_at(hazard, hazard.trials[1], x).label();
  };
  if (!differ(hazard.range.from))
    throw Error(node.key_where, "stress.rows: {y} stands nowhere; expected it in scene or in the method's settings");
}

StressHazard read_hazard(const ConfigNode& node, const Columns& columns) {
  TableReader row(node, "stress");
  // Where an initialiser throws, GCC 12 frees the texts before it twice.
  const std::string scene_text = row.needed_text("scene");
  StressHazard hazard{{.id = static_cast<int>(row.needed_whole("id", 1, 9999)),
                       .hazard = row.needed_text("name"),
                       .failure = row.needed_text("failure"),
                       .source = row.needed_text("source"),
                       .parameter = row.needed_text("x"),
                       .unit = ""},
                      scene_text};
  row.text("unit", hazard.unit);
  read_range(row, hazard);
  const ConfigNode *rows = row.find("rows"), &scene = row.need("scene");
  if (!rows && hazard.scene.find(row_variable) != std::string::npos)
    throw Error(scene.where,
                fmt::format("stress: {} stands in scene = '{}'; expected [stress.rows] beside it", row_variable, hazard.scene));
  check_scene(hazard, hazard.scene, scene.where);
  read_bound(row, hazard);
  const ConfigNode* structures = row.find("structures");
  if (hazard.of_structures() != (structures != nullptr))
    throw Error(structures ? structures->key_where : row.need("holds").where,
                fmt::format("stress: {} is a figure of {}; expected {} structures", hazard.figure->name,
                            structures ? "images" : "structures", structures ? "no" : "a list of"));
  if (structures && rows)
    throw Error(rows->key_where, "stress.rows: there are no maps of structures; expected it beside a figure of images");
  if (structures)
    read_structures(row, *structures, hazard);
  else if (rows != nullptr)
    read_rows_of_map(row, *rows, hazard, columns);
  else
    read_methods(row, hazard, columns);
  row.finish();
  return hazard;
}

}  // namespace

std::string with_variable(const std::string& text, double x) {
  return replaced(replaced(text, sweep_variable, x), sweep_rest, 1 - x);
}

Method method_at(const StressHazard& hazard, const StressTrial& trial, double x) {
  const ConfigNode node = substituted(substituted(trial.node, sweep_variable, x, hazard.range.whole), sweep_rest, 1 - x, false);
  return read_method(node, hazard.of_structures());
}

StressChoice read_stress(const ConfigNode& hazards, const ConfigNode* sweep, const ConfigNode& integrators,
                         std::uint64_t samples) {
  StressChoice choice;
  Columns columns = read_columns(integrators, samples);
  if (sweep) {
    TableReader reader(*sweep, "sweep", "a table { factor, samples }");
    reader.number("factor", choice.factor, 1.01, 1e12);
    read_samples(reader.find("samples"), "sweep.samples", columns);
    reader.finish();
  }
  choice.hazards =
      read_rows<StressHazard>(hazards, "stress", [&](const ConfigNode& node) { return read_hazard(node, columns); });
  return choice;
}

}  // namespace etendue
