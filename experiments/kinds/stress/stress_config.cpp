#include "experiments/kinds/stress/stress_config.h"

#include "experiments/kinds/rows.h"
#include "framework/io/load_scene.h"

#include <fmt/format.h>

namespace etendue {

namespace {

// A table { name, parameters… }, or a name.
Method read_one_method(const ConfigNode& node) {
  if (!node.table() && !node.text()) wrong_type(node, "method", "a table { name, … }");
  if (node.table())
    for (const auto& [parameter, value] : *node.table())
      if (value.array()) wrong_type(value, "method." + parameter, "a single value");
  return read_integrators({ConfigNode::Array{node}, node.where, node.key_where}).front();
}

// The parameters of `change` in the place of those of the method's table.
Method changed_method(const ConfigNode& method, const ConfigNode& change) {
  if (!change.table()) wrong_type(change, "change", "a table of parameters");
  ConfigNode merged = method;
  if (const std::string* name = method.text()) merged.value = ConfigNode::Table{{"name", {*name, method.where, method.where}}};
  auto& table = std::get<ConfigNode::Table>(merged.value);
  for (const auto& [key, value] : *change.table()) {
    if (key == "name")
      throw Error(value.key_where, "change: parameters alone; expected method = { name, … } for another method");
    table.insert_or_assign(key, value);
  }
  return read_one_method(merged);
}

StressTrial read_remedy(const ConfigNode& node, const ConfigNode& method) {
  TableReader row(node, "stress.remedies");
  StressTrial trial{row.needed_text("name"), {}};
  const auto *change = row.find("change"), *other = row.find("method");
  if ((change != nullptr) == (other != nullptr))
    throw Error(node.where, "stress.remedies: expected one of change = { … } and method = { name, … }");
  trial.method = change ? changed_method(method, *change) : read_one_method(*other);
  row.finish();
  return trial;
}

void read_expected(TableReader& row, StressRow& stress) {
  const ConfigNode& expect = row.need("expect");
  const auto expected = read_expectations(expect, "stress.expect", {"fails", "holds"});
  if (expected.size() != 2) throw Error(expect.where, "stress.expect: expected { fails = [low, high], holds = [low, high] }");
  stress.fails = expected.at("fails");
  stress.holds = expected.at("holds");
  if (stress.fails.low <= stress.holds.high && stress.holds.low <= stress.fails.high)
    throw Error(expect.where, fmt::format("stress: fails and holds of row {} overlap; expected intervals apart", stress.id));
}

StressRow read_row(const ConfigNode& node) {
  for (const char* key : {"fails", "holds"}) refuse_old_key(node, key, fmt::format("expect = {{ {} = … }}", key));
  TableReader row(node, "stress");
  StressRow stress{.id = static_cast<int>(row.needed_whole("id", 1, 9999)),
                   .failure = row.needed_text("failure"),
                   .source = row.needed_text("source"),
                   .scene = row.needed_text("scene")};
  if (stress.scene.starts_with(builtin_prefix)) check_builtin(stress.scene, row.need("scene").where);
  stress.figure = &find_stress_figure(row.needed_text("figure"), row.need("figure").where);
  read_expected(row, stress);
  row.whole("samples", stress.samples, 1, 1'000'000'000);
  const ConfigNode& method = row.need("method");
  stress.trials.push_back({"", read_one_method(method)});
  if (const ConfigNode* remedies = row.find("remedies"))
    for (const ConfigNode& remedy : read_tables(*remedies, "stress.remedies"))
      stress.trials.push_back(read_remedy(remedy, method));
  row.finish();
  return stress;
}

}  // namespace

StressChoice read_stress(const ConfigNode& node) {
  StressChoice choice;
  choice.rows = read_rows<StressRow>(node, "stress", read_row);
  return choice;
}

}  // namespace etendue
