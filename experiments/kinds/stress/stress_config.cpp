#include "experiments/kinds/stress/stress_config.h"

#include "experiments/kinds/claims/claims_config.h"
#include "framework/io/load_scene.h"

#include <fmt/format.h>

#include <algorithm>

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
  TableReader reader(node, "stress.remedies");
  StressTrial trial;
  trial.name = read_text(required(reader, node, "stress.remedies", "name"), "stress.remedies.name");
  const auto *change = reader.find("change"), *other = reader.find("method");
  if ((change != nullptr) == (other != nullptr))
    throw Error(node.where, "stress.remedies: expected one of change = { … } and method = { name, … }");
  trial.method = change ? changed_method(method, *change) : read_one_method(*other);
  reader.finish();
  return trial;
}

StressRow read_row(const ConfigNode& node) {
  for (const char* key : {"fails", "holds"}) refuse_old_key(node, key, fmt::format("expect = {{ {} = … }}", key));
  TableReader reader(node, "stress");
  const auto need = [&](const char* key) -> const ConfigNode& { return required(reader, node, "stress", key); };
  StressRow row;
  row.id = static_cast<int>(read_whole(need("id"), "stress.id", 1, 9999));
  row.failure = read_text(need("failure"), "stress.failure");
  row.source = read_text(need("source"), "stress.source");
  const ConfigNode& scene = need("scene");
  row.scene = read_text(scene, "stress.scene");
  if (row.scene.starts_with(builtin_prefix)) check_builtin(row.scene, scene.where);
  const ConfigNode& figure = need("figure");
  row.figure = &find_stress_figure(read_text(figure, "stress.figure"), figure.where);
  const ConfigNode& expect = need("expect");
  const auto expected = read_expectations(expect, "stress.expect", {"fails", "holds"});
  if (expected.size() != 2) throw Error(expect.where, "stress.expect: expected { fails = [low, high], holds = [low, high] }");
  row.fails = expected.at("fails");
  row.holds = expected.at("holds");
  if (row.fails.low <= row.holds.high && row.holds.low <= row.fails.high)
    throw Error(expect.where, fmt::format("stress: fails and holds of row {} overlap; expected intervals apart", row.id));
  if (const ConfigNode* n = reader.find("samples"))
    row.samples = static_cast<std::uint64_t>(read_whole(*n, "stress.samples", 1, 1'000'000'000));
  const ConfigNode& method = need("method");
  row.trials.push_back({"", read_one_method(method)});
  if (const ConfigNode* remedies = reader.find("remedies")) {
    if (!remedies->array()) wrong_type(*remedies, "stress.remedies", "[[stress.remedies]] tables");
    for (const ConfigNode& remedy : *remedies->array()) row.trials.push_back(read_remedy(remedy, method));
  }
  reader.finish();
  return row;
}

}  // namespace

StressChoice read_stress(const ConfigNode& node) {
  if (!node.array() || node.array()->empty()) wrong_type(node, "stress", "[[stress]] tables");
  StressChoice choice;
  std::vector<StressRow>& rows = choice.rows;
  for (const ConfigNode& element : *node.array()) {
    rows.push_back(read_row(element));
    for (std::size_t i = 0; i + 1 < rows.size(); ++i)
      if (rows[i].id == rows.back().id)
        throw Error(element.where, fmt::format("stress: id {} stands there twice", rows.back().id));
  }
  return choice;
}

}  // namespace etendue
