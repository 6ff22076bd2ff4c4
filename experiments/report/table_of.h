// A table filled column by column from records: each column says its key, its heading, and what its cells show of a record.
//
//   TableOf<const CellRecord*> table("failures", "Cells that failed", failed);
//   table.column("seed", "seed", [](const CellRecord* cell) { return cell->cell.seed; });
//   table.column("error", "error", &CellRecord::error);
//
// What it shows is whatever makes a TableCell; columns of text are set flush left, others right.
#pragma once

#include "experiments/report/table_format.h"

#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace etendue {

// A name that readers see otherwise than programs.
struct NameCell : TableCell {
  NameCell(std::string shown, std::string name) : TableCell(std::move(shown), std::move(name), std::nullopt) {}
};

template <class Record>
class TableOf {
 public:
  TableOf(std::string name, std::string title, std::vector<Record> records)
      : records_(std::move(records)), table_{std::move(name), std::move(title)} {
    table_.rows.resize(records_.size());
  }

  // The columns that follow belong to a group of this title; where there is nothing to show in it, to programs alone.
  void group(std::string title, bool shown = true) {
    if (shown) table_.group_titles.push_back(std::move(title));
    group_ = shown ? table_.group_titles.size() : 0;
    shown_ = shown;
  }

  template <class Show>
  void column(std::string key, std::string title, const Show& show, Audience audience = Audience::everyone) {
    using Shown = std::remove_cvref_t<std::invoke_result_t<const Show&, const Record&>>;
    constexpr bool is_text = std::is_convertible_v<Shown, std::string> || std::is_same_v<Shown, NameCell>;
    add_column(table_, std::move(key), std::move(title), !is_text, shown_ ? audience : Audience::machines, group_);
    for (std::size_t i = 0; i < records_.size(); ++i) add_cell(table_, i, std::invoke(show, records_[i]));
  }

  // A column for programs alone.
  template <class Show>
  void data(std::string key, const Show& show) {
    column(std::move(key), "", show, Audience::machines);
  }

  // A column for readers and one for programs by each key. show(record) gives their cells in this order, or none.
  template <class Show>
  void parts(std::string title, const std::vector<std::string>& keys, const Show& show) {
    if (shown_) table_.columns.push_back({"", std::move(title), true, Audience::people, group_});
    for (const std::string& key : keys) table_.columns.push_back({key, "", true, Audience::machines, group_});
    for (std::size_t i = 0; i < records_.size(); ++i) {
      std::vector<TableCell> cells = std::invoke(show, records_[i]);
      cells.resize(keys.size() + 1);
      table_.rows[i].insert(table_.rows[i].end(), cells.begin() + !shown_, cells.end());
    }
  }

  // Beneath a table that has rows.
  void note(std::string text) {
    if (!records_.empty()) table_.notes.push_back(std::move(text));
  }

  // `notes` are added, and stand there without rows as well.
  Table take(const std::vector<std::string>& notes = {}) {
    table_.notes.insert(table_.notes.end(), notes.begin(), notes.end());
    return std::move(table_);
  }

 private:
  std::vector<Record> records_;
  Table table_;
  std::size_t group_ = 0;
  bool shown_ = true;
};

}  // namespace etendue
