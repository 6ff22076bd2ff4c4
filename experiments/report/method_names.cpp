#include "experiments/report/method_names.h"

#include "experiments/config/method.h"
#include "experiments/report/report_data.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {
namespace {

using Words = std::vector<std::string>;

// Methods of one name by their words, of which the first is that name.
using Family = std::vector<Words>;

bool has_parameters(const Words& words) { return words.size() > 1; }

// The parameters that all methods with parameters have alike.
Words shared_parameters(const Family& family) {
  const auto first = std::ranges::find_if(family, has_parameters);
  if (first == family.end()) return {};
  Words shared(first->begin() + 1, first->end());
  for (const Words& words : family)
    if (has_parameters(words)) std::erase_if(shared, [&](const std::string& word) { return !contains(words, word); });
  return shared;
}

Words without(Words words, const Words& shared) {
  std::erase_if(words, [&](const std::string& word) { return contains(shared, word); });
  return words;
}

// Says in words what the names of a family leave out; empty: nothing.
std::string left_out_of(const Family& family, const Words& shared, bool name_too) {
  const bool plain_too = !std::ranges::all_of(family, has_parameters);
  if (shared.empty() && !name_too) return "";
  const std::string& name = family.front().front();
  return fmt::format("{}{}{}{}", name, plain_too ? " with parameters:" : "", shared.empty() ? "" : " ", joined(shared, " "));
}

void shorten(const Family& family, bool alone, ChartNames& names) {
  const Words shared = shared_parameters(family);
  const bool name_too = alone && family.size() > 1 &&
                        std::ranges::all_of(family, [&](const Words& words) { return without(words, shared).size() > 1; });
  std::map<std::string, std::string> shortened;
  std::map<std::string, int> uses;
  for (const Words& words : family) {
    Words kept = without(words, shared);
    if (name_too) kept.erase(kept.begin());
    ++uses[shortened[joined(words, " ")] = joined(kept, " ")];
  }
  if (uses.size() < family.size()) return;  // two would be called the same
  names.by_full_name.merge(shortened);
  if (std::string text = left_out_of(family, shared, name_too); !text.empty()) names.left_out.push_back(std::move(text));
}

std::string label_or_name(const std::string& full_name, const std::map<std::string, std::string>& labels) {
  return find_value(labels, full_name).value_or(full_name);
}

}  // namespace

ChartNames chart_names(const std::vector<std::string>& full_names, const std::map<std::string, std::string>& labels) {
  ChartNames names;
  std::vector<std::string> order;
  std::map<std::string, Family> families;
  for (const std::string& full_name : full_names) {
    if (const auto label = find_value(labels, full_name)) {
      names.by_full_name[full_name] = *label;
      continue;
    }
    const Words words = words_of(full_name);
    if (words.empty()) continue;
    index_in(order, words.front());
    families[words.front()].push_back(words);
  }
  for (const std::string& name : order) shorten(families[name], families.size() == 1 && names.by_full_name.empty(), names);
  for (const std::string& full_name : full_names) {
    std::string& name = names.by_full_name.try_emplace(full_name, full_name).first->second;
    const auto is_name = [&](const auto& label) { return label.second == name && label.first != full_name; };
    if (!labels.contains(full_name) && std::ranges::any_of(labels, is_name)) name = full_name;
  }
  return names;
}

void name_methods(ReportData& data) {
  const std::map<std::string, std::string>& labels = data.log->stated.labels;
  const ChartNames integrators = chart_names(data.integrators, labels), accels = chart_names(data.accels, labels);
  for (SceneData& scene : data.scenes)
    for (Configuration& configuration : scene.configurations) {
      configuration.shown_integrator = label_or_name(configuration.integrator, labels);
      configuration.shown_accel = label_or_name(configuration.accel, labels);
      configuration.short_integrator = integrators.by_full_name.at(configuration.integrator);
      configuration.short_accel = accels.by_full_name.at(configuration.accel);
    }
  for (const std::string& accel : data.accels) data.shown_accels.push_back(label_or_name(accel, labels));
  data.left_out_of_names = integrators.left_out;
  if (data.accels.size() > 1)
    data.left_out_of_names.insert(data.left_out_of_names.end(), accels.left_out.begin(), accels.left_out.end());
}

}  // namespace etendue
