// Rows of an experiment that have a number each, [[claims]] and [[stress]], and rows of the program's own tables by their
// names.
#pragma once

#include "experiments/config/config_tree.h"

#include <fmt/format.h>
#include <span>

namespace etendue {

// Reads [[owner]], of which there is at least one, each `id` once. Throws Error.
template <class Row, class Read>
std::vector<Row> read_rows(const ConfigNode& node, const std::string& owner, const Read& read) {
  std::vector<Row> rows;
  for (const ConfigNode& element : read_tables(node, owner)) {
    Row row = read(element);
    for (const Row& other : rows)
      if (other.id == row.id) throw Error(element.where, fmt::format("{}: id {} stands there twice", owner, row.id));
    rows.push_back(std::move(row));
  }
  return rows;
}

template <class Entries>
std::vector<std::string> entry_names(const Entries& entries) {
  return mapped(entries, [](const auto& entry) { return std::string(entry.name); });
}

// The entry of a table by its name; throws Error with the nearest names.
template <class Entry>
const Entry& find_by_name(std::span<const Entry> entries, const std::string& what, const std::string& name,
                          const Location& where) {
  for (const Entry& entry : entries)
    if (entry.name == name) return entry;
  throw Error(where, unknown_name(what, name, entry_names(entries)));
}

}  // namespace etendue
