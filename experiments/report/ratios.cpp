#include "experiments/report/ratios.h"

#include "experiments/report/report_text.h"
#include "framework/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace etendue {

namespace {

// A value is a figure of its source's own images: of ours it says which of the two methods is better.
Expected side_of_one(const Expected& expected) {
  if (!expected.is_value() || expected.low == 1) return expected;
  return expected.low > 1 ? Expected{1, endless} : Expected{0, 1};
}

JudgedPrediction judged(const Prediction& prediction, const SceneData& scene, const Configuration& method,
                        const Configuration& over) {
  JudgedPrediction row{.scene = scene.name,
                       .region = prediction.region,
                       .method = method.integrator,
                       .over = over.integrator,
                       .quantity = "ratio of RMSE",
                       .source = prediction.source,
                       .expected = prediction.expected};
  const double floor = subtracted_variance(scene, prediction.region);
  std::vector<double> above, below;
  try {
    for (const Replicate& a : method.replicates)
      for (const Replicate& b : over.replicates)
        if (a.seed == b.seed) {
          above.push_back(logged_mse(*a.last(), prediction.region) - floor);
          below.push_back(logged_mse(*b.last(), prediction.region) - floor);
        }
    row.details.emplace_back("seeds", below.size());
    if (above.empty()) throw Error("no seed in common");
    const auto figures = [&](std::span<const std::size_t> seeds, std::span<double> out) {
      double a = 0, b = 0;
      for (const std::size_t seed : seeds) {
        a += above[seed];
        b += below[seed];
      }
      out[0] = std::sqrt(a / static_cast<double>(seeds.size()));
      // Where noise leaves both below zero, their quotient is above it and means nothing.
      out[1] = a < 0 || b < 0 ? std::numeric_limits<double>::quiet_NaN() : std::sqrt(a / b);
    };
    std::vector<std::size_t> all(above.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    double whole[2];
    figures(all, whole);
    if (std::ranges::all_of(below, [](double mse) { return mse == 0; })) throw Error("the other method has no error");
    if (!std::isfinite(whole[0]) || !std::isfinite(whole[1])) throw Error("an error below the reference's own noise");
    std::vector<std::optional<Interval>> intervals(2);
    if (all.size() >= 3) intervals = bootstrap_intervals(all.size(), 2, figures);
    row.measure(whole[1], intervals[1]);
    if (row.verdict && row.interval) row.verdict = judge(whole[1], *row.interval, side_of_one(*row.expected), 1.0);
    row.add_detail("rmse", whole[0], intervals[0]);
  } catch (const Error& e) {
    row.problem = e.what();
  }
  return row;
}

// Takes out of names the words that all of them have, but for a name that has no others.
void shorten_names(std::vector<JudgedPrediction>& rows) {
  std::vector<std::string> common = words_of(rows.front().method);
  for (const JudgedPrediction& row : rows)
    for (const std::string& name : {row.method, row.over})
      std::erase_if(common, [words = words_of(name)](const std::string& word) { return !contains(words, word); });
  for (JudgedPrediction& row : rows)
    for (std::string* name : {&row.method, &row.over}) {
      std::vector<std::string> words = words_of(*name);
      std::erase_if(words, [&](const std::string& word) { return contains(common, word); });
      if (!words.empty()) *name = joined(words, " ");
    }
}

// Ratios that share a scene, a place and what they are over can be put in order.
using Group = std::vector<const JudgedPrediction*>;
std::vector<Group> expected_groups(const std::vector<JudgedPrediction>& rows) {
  std::vector<Group> groups;
  for (const JudgedPrediction& row : rows) {
    if (!row.expected || !row.value) continue;
    const auto same = [&](const Group& group) {
      const JudgedPrediction& other = *group.front();
      return other.scene == row.scene && other.over == row.over && other.region == row.region;
    };
    find_or_add(groups, same, {}).push_back(&row);
  }
  return groups;
}

// How many pairs of methods are in the order expected, and the order found.
std::string order_of_ratios(const std::vector<JudgedPrediction>& rows) {
  std::string text;
  for (Group& group : expected_groups(rows)) {
    std::size_t pairs = 0, kept = 0;
    for (std::size_t i = 0; i < group.size(); ++i)
      for (std::size_t j = i + 1; j < group.size(); ++j) {
        const double expected = group[i]->expected->low - group[j]->expected->low;
        if (expected == 0) continue;
        ++pairs;
        kept += expected > 0 ? group[i]->value > group[j]->value : group[i]->value < group[j]->value;
      }
    const JudgedPrediction& first = *group.front();
    const std::string place = first.region.empty() ? "" : ", " + first.region;
    text += fmt::format("{}{}{}, over {}: ", text.empty() ? "" : " ", first.scene, place, first.over);
    if (pairs > 0) text += fmt::format("of {} pairs of methods {} are in the order expected; ", pairs, kept);
    std::ranges::stable_sort(group, [](const JudgedPrediction* a, const JudgedPrediction* b) { return a->value > b->value; });
    const auto found = [](const JudgedPrediction* row) { return row->method + " " + format_figure(*row->value); };
    text += fmt::format("found, worst first: {}.", joined(group, ", ", found));
  }
  return text;
}

}  // namespace

Predictions ratio_predictions(const ReportData& data) {
  Predictions predictions;
  std::vector<JudgedPrediction>& rows = predictions.rows;
  // How far a run gets in a time depends on its structure; else structures change nothing.
  const bool each_structure = data.accels.size() > 1 &&
                              std::ranges::any_of(data.log->manifests, [](const ManifestRecord& m) { return m.budget_s > 0; });
  for (const Prediction& prediction : data.log->stated.predictions)
    for (const SceneData& scene : data.scenes) {
      if (!prediction.is_ratio() || !data.log->stated.concerns(prediction, scene.name)) continue;
      for (const Configuration* over : selected(scene, prediction.over, each_structure))
        for (const Configuration* method : selected(scene, prediction.method, each_structure)) {
          if (method->integrator_index == over->integrator_index ||
              (each_structure && method->accel_index != over->accel_index))
            continue;
          rows.push_back(judged(prediction, scene, *method, *over));
          if (each_structure) rows.back().structure = method->shown_accel;
        }
    }
  if (rows.empty()) return predictions;
  shorten_names(rows);
  for (JudgedPrediction& row : rows)
    if (!row.structure.empty()) row.method += " · " + row.structure;
  predictions.notes.push_back(
      "Ratios: of RMSE at the end of each run, over the seeds that both methods have, the reference's own noise taken away; "
      "intervals are 95 % bootstraps over seeds (none below three). Judged is on which side of 1 they lie, for an expected "
      "value is one of its source's own images.");
  if (std::ranges::any_of(rows, [](const JudgedPrediction& row) { return !row.region.empty(); }))
    predictions.notes.emplace_back("In regions the reference's own noise is left in: it is known for the image as a whole.");
  predictions.order = order_of_ratios(rows);
  return predictions;
}

}  // namespace etendue
