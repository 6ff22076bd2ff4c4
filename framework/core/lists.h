// Short words for loops over lists and texts that the standard library has none for.
#pragma once

#include "framework/core/error.h"

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <ranges>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace etendue {

template <std::ranges::range List, class Value>
requires std::equality_comparable_with<std::ranges::range_value_t<List>, Value>
bool contains(const List& list, const Value& value) { return std::ranges::find(list, value) != std::ranges::end(list); }

// Answers what `of`, a function or a member, makes of each element, in their order.
template <class List, class Of>
auto mapped(List&& list, const Of& of) {
  using Element = std::ranges::range_reference_t<List>;
  std::vector<std::remove_cvref_t<std::invoke_result_t<const Of&, Element>>> result;
  for (auto&& element : list) result.push_back(std::invoke(of, std::forward<Element>(element)));
  return result;
}

// The values of a map, in the order of their keys.
template <class Map>
auto values_of(const Map& map) {
  return mapped(map, [](const auto& entry) { return entry.second; });
}

// The first element for which `is` holds; where there is none, `fresh` joins them.
template <class Element, class Is>
Element& find_or_add(std::vector<Element>& elements, const Is& is, Element fresh) {
  const auto found = std::ranges::find_if(elements, is);
  return found != elements.end() ? *found : elements.emplace_back(std::move(fresh));
}

// The place of a name among others, which it joins where it is missing.
inline std::size_t index_in(std::vector<std::string>& names, const std::string& name) {
  const auto index = static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
  if (index == names.size()) names.push_back(name);
  return index;
}

// The value that a map holds under a name, if it does.
template <class Value>
std::optional<Value> find_value(const std::map<std::string, Value>& values, const std::string& name) {
  const auto found = values.find(name);
  return found == values.end() ? std::nullopt : std::optional(found->second);
}

// The texts that `of` makes of the elements, with a separator between them.
template <class List, class Of = std::identity>
std::string joined(List&& list, std::string_view separator, const Of& of = {}) {
  std::string text;
  bool first = true;
  for (auto&& element : list) {
    if (!std::exchange(first, false)) text += separator;
    text += std::invoke(of, element);
  }
  return text;
}

// The parts of a text before, between and behind its separators.
inline std::vector<std::string> split(std::string_view text, std::string_view separator) {
  std::vector<std::string> parts;
  for (std::size_t at; (at = text.find(separator)) != std::string_view::npos; text.remove_prefix(at + separator.size()))
    parts.emplace_back(text.substr(0, at));
  parts.emplace_back(text);
  return parts;
}

// Changes ASCII's letters alone.
inline std::string in_lower_case(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](char c) { return 'A' <= c && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return text;
}

// Throws Error unless the word is one of the names; its text is that of unknown_name, behind `before`.
inline void require_name(const Location& where, std::string_view kind, std::string_view word,
                         std::span<const std::string> names, std::string_view before = "") {
  if (!contains(names, word)) throw Error(where, std::string(before) + unknown_name(kind, word, names));
}

}  // namespace etendue
