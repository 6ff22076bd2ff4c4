// Predictions beside what was measured: one table for all kinds of experiments, and what it comes to in words.
//
// A prediction is of a quantity of some cells, and has a source; which verdict it gets says experiments/statistics/verdict.h.
#pragma once

#include "experiments/report/table_format.h"
#include "experiments/statistics/verdict.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace etendue {

struct JudgedPrediction {
  // Says what was measured, and where. A field that is empty in all rows of a table has no column there.
  int id = 0;                      // of the statement that it belongs to
  std::string statement = {};      // in words
  std::string scene, region = {};  // region empty: the whole image
  std::string method, structure = {}, over = {}, remedy = {};
  std::string quantity, source;
  FigureKind kind = FigureKind::plain;
  std::optional<Expected> expected = {};  // empty: only measured
  std::optional<double> value = {};
  std::optional<Interval> interval = {};
  std::optional<Verdict> verdict = {};                          // empty: not to be judged
  std::string problem = {};                                     // why there is no value
  std::string marks = {};                                       // behind the value, explained in the notes
  std::vector<std::pair<std::string, TableCell>> details = {};  // further cells by the key of their column

  // Measured, with its verdict where one can be given.
  void measure(double measured, const std::optional<Interval>& around, std::optional<double> no_effect);
  void measure(double measured, const std::optional<Interval>& around) { measure(measured, around, no_effect_of(kind)); }
  // Adds a detail with its interval, under three keys for programs, and in one cell for people.
  void add_detail(const std::string& key, double centre, const std::optional<Interval>& around);

  std::string expected_text() const;  // "1.20×–1.30×", "above 2.00", "-2/3"; "" where nothing is
  std::string measured_text() const;  // "1.18× (1.17×–1.20×)"; the problem where there is no value
};

struct Predictions {
  std::vector<JudgedPrediction> rows;
  std::vector<std::string> notes;  // beneath the table, about what stands in it
  std::string order;               // whether what was measured comes in the order expected; empty: not asked

  void add(Predictions others);
};

// Writes "1.18×", "12 ms", "-0.667", "3.1 %" or "∞".
std::string figure_text(FigureKind kind, double value);

// Rows are sorted by id; those without keep their order.
Table predictions_table(const Predictions& predictions);

// Says how many came true, and which did not; empty where nothing is expected.
std::string predictions_finding(const Predictions& predictions);

// The same as briefly as a table's row asks: which did not, where that is short.
std::string predictions_answer(const Predictions& predictions);

// How verdicts are given, for people.
extern const char* const verdict_rule;

}  // namespace etendue
