#include "experiments/kinds/search/search_config.h"

#include "accel/registry.h"

#include <fmt/format.h>
#include <algorithm>

namespace etendue {

namespace {

template <class Entries>
std::vector<std::string> names_of(const Entries& entries) {
  std::vector<std::string> names;
  for (const auto& entry : entries) names.push_back(entry.name);
  return names;
}

std::vector<std::string> read_structures(const ConfigNode* node, const std::string& key, bool records) {
  const std::vector<std::string> all = records ? names_of(record_structures()) : names_of(point_structures());
  if (!node || (node->text() && *node->text() == "all")) return all;
  std::vector<std::string> names;
  for (const ConfigNode* element : list_elements(*node, key, "\"all\" or an array of names")) {
    const std::string name = read_text(*element, key);
    if (records)
      find_record_structure(name, element->where);
    else
      find_point_structure(name, element->where);
    if (std::find(names.begin(), names.end(), name) != names.end())
      throw Error(element->where, fmt::format("{}: '{}' stands there twice", key, name));
    names.push_back(name);
  }
  return names;
}

// Ascending, each once.
template <class Number, class Read>
std::vector<Number> read_ascending(const ConfigNode& node, const std::string& key, const Read& read) {
  std::vector<Number> values;
  if (node.array() && node.array()->empty()) return values;
  for (const ConfigNode* element : list_elements(node, key, "an array of numbers")) {
    const auto value = static_cast<Number>(read(*element));
    if (!values.empty() && !(value > values.back()))
      throw Error(element->where, fmt::format("{}: {} behind {}; expected ascending numbers", key, value, values.back()));
    values.push_back(value);
  }
  return values;
}

}  // namespace

SearchChoice read_search(const ConfigNode& node, bool records) {
  const std::string owner = records ? "records" : "points";
  if (!node.table()) wrong_type(node, owner, "a table { structures, counts, … }");
  TableReader reader(node, owner);
  SearchChoice choice;
  choice.records = records;
  choice.structures = read_structures(reader.find("structures"), owner + ".structures", records);
  choice.counts = {10, 100, 1000, 10000, 100000};
  if (!records) choice.counts.push_back(1000000);
  choice.variations = records ? std::vector<double>{1, 10, 100} : std::vector<double>{};
  const auto numbers = [&](const char* key, auto& values, double low, double high) {
    using Number = typename std::remove_reference_t<decltype(values)>::value_type;
    const std::string name = owner + "." + key;
    if (const ConfigNode* n = reader.find(key))
      values = read_ascending<Number>(*n, name, [&](const ConfigNode& element) -> double {
        if constexpr (std::is_integral_v<Number>)
          return static_cast<double>(
              read_whole(element, name, static_cast<std::int64_t>(low), static_cast<std::int64_t>(high)));
        else
          return read_number(element, name, low, high);
      });
  };
  numbers("counts", choice.counts, 1, 1e8);
  if (choice.counts.empty()) throw Error(node.where, owner + ".counts: none; expected at least one number");
  if (records) {
    numbers("spreads", choice.variations, 1, 1e6);
    if (choice.variations.empty()) throw Error(node.where, "records.spreads: none; expected at least one number");
    if (const auto* n = reader.find("covering")) choice.covering = read_number(*n, "records.covering", 0.01, 1e6);
  } else {
    std::vector<std::uint64_t> neighbours{1, 10, 50, 500};
    numbers("neighbours", neighbours, 1, 1e6);
    choice.neighbours.assign(neighbours.begin(), neighbours.end());
    numbers("contrasts", choice.variations, 1, 1e8);
  }
  if (const auto* n = reader.find("queries"))
    choice.queries = static_cast<int>(read_whole(*n, owner + ".queries", 1, 10'000'000));
  if (const auto* n = reader.find("repetitions"))
    choice.repetitions = static_cast<int>(read_whole(*n, owner + ".repetitions", 1, 1000));
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
