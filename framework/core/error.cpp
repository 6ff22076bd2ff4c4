#include "framework/core/error.h"

#include "framework/core/lists.h"

#include <fmt/format.h>
#include <algorithm>
#include <numeric>

namespace etendue {

namespace {

// Levenshtein's distance with adjacent transpositions counted once (optimal string alignment).
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), previous(b.size() + 1), current(b.size() + 1);
  std::iota(previous.begin(), previous.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    current[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substitution = previous[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      current[j] = std::min({previous[j] + 1, current[j - 1] + 1, substitution});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) current[j] = std::min(current[j], before[j - 2] + 1);
    }
    std::swap(before, previous);
    std::swap(previous, current);
  }
  return previous[b.size()];
}

std::string quoted_list(std::span<const std::string> names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " or " : ", ";
    text += "'" + names[i] + "'";
  }
  return text;
}

}  // namespace

std::string Location::text() const {
  if (line == 0) return file;
  return column == 0 ? fmt::format("{}:{}", file, line) : fmt::format("{}:{}:{}", file, line, column);
}

Error::Error(const Location& where, const std::string& what)
    : std::runtime_error(where.file.empty() ? what : where.text() + ": " + what) {}

std::vector<std::string> nearest_names(std::string_view word, std::span<const std::string> names, std::size_t most) {
  const std::size_t farthest = std::max<std::size_t>(2, word.size() / 3);
  const std::string lower = in_lower_case(std::string(word));
  std::vector<std::pair<std::size_t, std::string>> ranked;
  for (const std::string& name : names) {
    // Lengths that differ by more need as many edits: a word of megabytes is not compared.
    const std::size_t lengths = std::max(word.size(), name.size()) - std::min(word.size(), name.size());
    const std::string lower_name = in_lower_case(name);
    std::size_t distance = lengths > farthest ? lengths : edit_distance(lower, lower_name);
    if (word.size() >= 3 && lower_name.find(lower) != std::string::npos) distance = std::min<std::size_t>(distance, 1);
    if (distance <= farthest) ranked.emplace_back(distance, name);
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> nearest;
  for (auto& [distance, name] : ranked)  // each once, also where two lists have it
    if (nearest.size() < most && !contains(nearest, name)) nearest.push_back(std::move(name));
  return nearest;
}

std::string unknown_name(std::string_view kind, std::string_view word, std::span<const std::string> names) {
  std::string text = fmt::format("unknown {} '{}'", kind, word.substr(0, 80));
  const auto nearest = nearest_names(word, names);
  if (!nearest.empty()) text += "; did you mean " + quoted_list(nearest) + "?";
  if (!names.empty() && (nearest.empty() || names.size() <= 8)) {
    text += nearest.empty() ? "; available:" : " (available:";
    constexpr std::size_t most_shown = 100;  // a scene may name a million things
    const bool spaced = std::ranges::any_of(names, [](const std::string& name) { return name.find(' ') != std::string::npos; });
    for (const std::string& name : names.first(std::min(names.size(), most_shown)))
      text += spaced ? fmt::format("{}'{}'", text.ends_with(':') ? " " : ", ", name) : " " + name;
    if (names.size() > most_shown) text += fmt::format(" and {} more", names.size() - most_shown);
    if (!nearest.empty()) text += ")";
  }
  return text;
}

}  // namespace etendue
