#include "experiments/kinds/search/search_config.h"

#include "accel/registry.h"
#include "experiments/config/config_keys.h"
#include "experiments/kinds/rows.h"

#include <fmt/format.h>

namespace etendue {

namespace {

// Ascending, each once, where the table has the key.
template <class Number>
void read_ascending(TableReader& reader, const std::string& owner, const char* key, std::vector<Number>& values, double low,
                    double high) {
  const ConfigNode* node = reader.find(key);
  if (!node) return;
  values.clear();
  if (node->array() && node->array()->empty()) return;
  const std::string name = owner + "." + key;
  for (const ConfigNode* element : list_elements(*node, name, "an array of numbers")) {
    Number value;
    if constexpr (std::is_integral_v<Number>)
      value = static_cast<Number>(read_whole(*element, name, static_cast<std::int64_t>(low), static_cast<std::int64_t>(high)));
    else
      value = read_number(*element, name, low, high);
    if (!values.empty() && !(value > values.back()))
      throw Error(element->where, fmt::format("{}: {} behind {}; expected ascending numbers", name, value, values.back()));
    values.push_back(value);
  }
}

}  // namespace

SearchChoice read_search(const ConfigNode& node, bool records) {
  const std::string owner = records ? "records" : "points";
  TableReader reader(node, owner, "a table { structures, counts, … }");
  SearchChoice choice;
  choice.records = records;
  const std::vector<std::string> all = records ? entry_names(record_structures()) : entry_names(point_structures());
  const ConfigNode* wanted = reader.find("structures");
  const bool every = !wanted || (wanted->text() && *wanted->text() == "all");
  choice.structures = every ? all : read_names(*wanted, owner + ".structures", "structure", all);
  choice.counts = {10, 100, 1000, 10000, 100000};
  if (!records) choice.counts.push_back(1000000);
  read_ascending(reader, owner, "counts", choice.counts, 1, 1e8);
  if (choice.counts.empty()) throw Error(node.where, owner + ".counts: none; expected at least one number");
  if (records) {
    choice.variations = {1, 10, 100};
    read_ascending(reader, owner, "spreads", choice.variations, 1, 1e6);
    if (choice.variations.empty()) throw Error(node.where, "records.spreads: none; expected at least one number");
    reader.number("covering", choice.covering, 0.01, 1e6);
  } else {
    choice.neighbours = {1, 10, 50, 500};
    read_ascending(reader, owner, "neighbours", choice.neighbours, 1, 1e6);
    read_ascending(reader, owner, "contrasts", choice.variations, 1, 1e8);
  }
  reader.whole("queries", choice.queries, 1, 10'000'000);
  reader.whole("repetitions", choice.repetitions, 1, 1000);
  reader.finish();
  return choice;
}

std::vector<SearchSet> search_sets(const SearchChoice& choice, const std::vector<std::string>& scenes) {
  std::vector<SearchSet> sets;
  const char* const varies = choice.records ? "spread" : "contrast";
  const auto add_variations = [&](const std::string& name, std::optional<std::size_t> scene) {
    for (const double v : choice.variations)
      sets.push_back({name, fmt::format("{} {}={:g}", name, varies, v), scene, varies, v});
  };
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    if (choice.records)
      add_variations(scenes[s], s);
    else
      sets.push_back({scenes[s], scenes[s], s, "", 0});
  }
  if (!choice.records) add_variations("clustered", std::nullopt);
  return sets;
}

}  // namespace etendue
