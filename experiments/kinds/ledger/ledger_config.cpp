#include "experiments/kinds/ledger/ledger_config.h"

#include "accel/registry.h"
#include "experiments/kinds/rows.h"
#include "framework/io/text.h"
#include "integrators/registry.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {

namespace {

bool same_value(const std::string& a, const std::string& b) {
  const auto x = parse_number(a), y = parse_number(b);
  return a == b || (x && y && *x == *y);
}

// Whether two methods are one and the same once defaults are written out.
bool same_method(const Method& a, const Method& b, const std::vector<ParamInfo>& params) {
  const auto value = [](const Method& method, const ParamInfo& info) {
    const auto found = method.params.find(info.name);
    return found == method.params.end() ? info.default_value : to_text(found->second);
  };
  return a.name == b.name &&
         std::ranges::all_of(params, [&](const ParamInfo& info) { return same_value(value(a, info), value(b, info)); });
}

void read_decision(TableReader& reader, const ConfigNode& node, LedgerRow& row) {
  if (const ConfigNode* decided = reader.find("decided")) {
    row.decision = &find_by_name(ledger_decisions(), "decision", read_text(*decided, "ledger.decided"), decided->where);
    return;
  }
  const Method& own = row.of_structure ? row.accel : row.method;
  const auto& params =
      row.of_structure ? find_ray_structure(own.name, own.where).params : find_integrator(own.name, own.where).params;
  reader.finish();  // a misspelt key is told as one
  row.always_on = same_method(own, *row.with, params);
  if (row.always_on == same_method(own, *row.without, params))
    throw Error(node.where, fmt::format("ledger: {} itself is {} of on = {{ … }} and off = {{ … }}; expected one of them, or "
                                        "decided = the name of a decision",
                                        own.label(), row.always_on ? "both" : "none"));
}

void read_switch(TableReader& reader, const ConfigNode& node, LedgerRow& row) {
  const ConfigNode *method = reader.find("method"), *accel = reader.find("accel"), *edit = reader.find("edit");
  if ((method != nullptr) + (accel != nullptr) + (edit != nullptr) > 1)
    throw Error(node.where, "ledger: expected one of method, accel and edit");
  if (edit != nullptr) {
    row.edit = &find_by_name(ledger_edits(), "edit", read_text(*edit, "ledger.edit"), edit->where);
    row.decision = &find_by_name(ledger_decisions(), "decision", row.edit->decision, edit->where);
    return;
  }
  row.of_structure = accel != nullptr;
  const ConfigNode path{std::string("path"), node.where, node.where};
  const ConfigNode own = method_table(accel != nullptr ? *accel : method != nullptr ? *method : path);
  const auto with = [&](const std::string& key) {
    return read_method(method_table(own, reader.need(key), "ledger." + key), row.of_structure);
  };
  (row.of_structure ? row.accel : row.method) = read_method(own, row.of_structure);
  row.with = with("on");
  row.without = with("off");
  if (row.with->label() == row.without->label())
    throw Error(node.where, "ledger: on and off are the same; expected parameters that differ");
  read_decision(reader, node, row);
}

LedgerRow read_row(const ConfigNode& node, std::uint64_t samples) {
  TableReader reader(node, "ledger", "tables { component, method, on, off, … }");
  LedgerRow row;
  row.component = reader.needed_text("component");
  row.method = {"path", {}, node.where};
  row.accel = default_accel();
  row.samples = samples;
  reader.whole("samples", row.samples, 1, 1'000'000);
  reader.text("kept", row.kept);
  read_switch(reader, node, row);
  reader.finish();
  return row;
}

}  // namespace

LedgerChoice read_ledger(const ConfigNode& ledger, std::uint64_t samples) {
  LedgerChoice choice;
  for (const ConfigNode& node : read_tables(ledger, "ledger")) {
    LedgerRow row = read_row(node, samples);
    for (const LedgerRow& other : choice.rows)
      if (other.component == row.component && other.owner() == row.owner())
        throw Error(node.where, fmt::format("ledger: '{}' of {} stands there twice", row.component, row.owner()));
    choice.rows.push_back(std::move(row));
  }
  return choice;
}

}  // namespace etendue
