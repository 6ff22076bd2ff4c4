#include "experiments/report/ratios.h"

#include "experiments/report/report_text.h"
#include "framework/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace etendue {

namespace {

FoundRatio find_ratio(const Prediction& prediction, const SceneData& scene, const Configuration& method,
                      const Configuration& over) {
  FoundRatio found;
  found.prediction = &prediction;
  found.scene = scene.name;
  found.method = method.integrator;
  found.over = over.integrator;
  const double floor = subtracted_variance(scene, prediction.region);
  try {
    std::vector<double> above, below;
    for (const Replicate& a : method.replicates)
      for (const Replicate& b : over.replicates)
        if (a.seed == b.seed) {
          above.push_back(logged_mse(*a.last(), prediction.region) - floor);
          below.push_back(logged_mse(*b.last(), prediction.region) - floor);
        }
    found.seeds = above.size();
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
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
    double whole[2];
    figures(all, whole);
    if (std::ranges::all_of(below, [](double mse) { return mse == 0; })) throw Error("the other method has no error");
    if (!std::isfinite(whole[0]) || !std::isfinite(whole[1])) throw Error("an error below the reference's own noise");
    found.rmse = whole[0];
    found.ratio = whole[1];
    if (all.size() < 3) return found;
    const auto intervals = bootstrap_intervals(all.size(), 2, figures);
    found.rmse_interval = intervals[0];
    found.ratio_interval = intervals[1];
  } catch (const Error& e) {
    found.problem = e.what();
  }
  return found;
}

// Labels without the words that all of them have.
class ShortNames {
 public:
  explicit ShortNames(const std::vector<FoundRatio>& ratios) {
    if (!ratios.empty()) common_ = words_of(ratios.front().method);
    for (const FoundRatio& ratio : ratios)
      for (const std::string& label : {ratio.method, ratio.over})
        std::erase_if(common_, [words = words_of(label)](const std::string& word) { return !contains(words, word); });
  }

  std::string of(const std::string& label) const {
    std::vector<std::string> words = words_of(label);
    std::erase_if(words, [&](const std::string& word) { return contains(common_, word); });
    return words.empty() ? label : joined(words, " ");
  }

 private:
  std::vector<std::string> common_;
};

// A value is a figure of its source's own images: of ours it says which of the two methods is better.
Expected side_of_one(const Expected& expected) {
  if (!expected.is_value() || expected.low == 1) return expected;
  return expected.low > 1 ? Expected{1, endless} : Expected{0, 1};
}

JudgedPrediction judged(const FoundRatio& found, const ShortNames& names) {
  const Prediction& prediction = *found.prediction;
  JudgedPrediction row{.scene = found.scene,
                       .region = prediction.region,
                       .method = names.of(found.method),
                       .over = names.of(found.over),
                       .quantity = "ratio of RMSE",
                       .source = prediction.source,
                       .expected = prediction.expected,
                       .problem = found.problem};
  row.details = {{"seeds", found.seeds}};
  if (!found.problem.empty()) return row;
  row.measure(found.ratio, found.ratio_interval);
  if (row.verdict && found.ratio_interval)
    row.verdict = judge(found.ratio, *found.ratio_interval, side_of_one(*prediction.expected), 1.0);
  row.add_detail("rmse", found.rmse, found.rmse_interval);
  return row;
}

// Ratios that share a scene, a place and what they are over can be put in order.
using Group = std::vector<const FoundRatio*>;
std::vector<Group> expected_groups(const std::vector<FoundRatio>& ratios) {
  std::vector<Group> groups;
  for (const FoundRatio& ratio : ratios) {
    if (!ratio.prediction->expected || !ratio.problem.empty()) continue;
    const auto same = [&](const Group& group) {
      const FoundRatio& other = *group.front();
      return other.scene == ratio.scene && other.over == ratio.over && other.prediction->region == ratio.prediction->region;
    };
    find_or_add(groups, same, {}).push_back(&ratio);
  }
  return groups;
}

// How many pairs of methods are in the order expected, and the order found.
std::string order_of_ratios(const std::vector<FoundRatio>& ratios, const ShortNames& names) {
  std::string text;
  for (Group& group : expected_groups(ratios)) {
    std::size_t pairs = 0, kept = 0;
    for (std::size_t i = 0; i < group.size(); ++i)
      for (std::size_t j = i + 1; j < group.size(); ++j) {
        const double expected = group[i]->prediction->expected->low - group[j]->prediction->expected->low;
        if (expected == 0) continue;
        ++pairs;
        kept += expected > 0 ? group[i]->ratio > group[j]->ratio : group[i]->ratio < group[j]->ratio;
      }
    const FoundRatio& first = *group.front();
    const std::string place = first.prediction->region.empty() ? "" : ", " + first.prediction->region;
    text += fmt::format("{}{}{}, over {}: ", text.empty() ? "" : " ", first.scene, place, names.of(first.over));
    if (pairs > 0) text += fmt::format("of {} pairs of methods {} are in the order expected; ", pairs, kept);
    std::ranges::stable_sort(group, [](const auto* a, const auto* b) { return a->ratio > b->ratio; });
    const auto found = [&](const FoundRatio* r) { return names.of(r->method) + " " + format_figure(r->ratio); };
    text += fmt::format("found, worst first: {}.", joined(group, ", ", found));
  }
  return text;
}

}  // namespace

std::vector<FoundRatio> find_ratios(const ReportData& data) {
  std::vector<FoundRatio> ratios;
  for (const Prediction& prediction : data.log->stated.predictions)
    for (const SceneData& scene : data.scenes) {
      if (!prediction.is_ratio() || !data.log->stated.concerns(prediction, scene.name)) continue;
      const auto over = selected(scene, prediction.over, false);
      if (over.empty()) continue;
      for (const Configuration* method : selected(scene, prediction.method, false))
        if (method->integrator_index != over.front()->integrator_index)
          ratios.push_back(find_ratio(prediction, scene, *method, *over.front()));
    }
  return ratios;
}

Predictions ratio_predictions(const std::vector<FoundRatio>& ratios) {
  Predictions predictions;
  const ShortNames names(ratios);
  for (const FoundRatio& ratio : ratios) predictions.rows.push_back(judged(ratio, names));
  if (ratios.empty()) return predictions;
  predictions.notes.push_back(
      "Ratios: of RMSE at the end of each run, over the seeds that both methods have, the reference's own noise taken away; "
      "intervals are 95 % bootstraps over seeds (none below three). Judged is on which side of 1 they lie, for an expected "
      "value is one of its source's own images.");
  if (std::ranges::any_of(ratios, [](const FoundRatio& ratio) { return !ratio.prediction->region.empty(); }))
    predictions.notes.push_back("In regions the reference's own noise is left in: it is known for the image as a whole.");
  predictions.order = order_of_ratios(ratios, names);
  return predictions;
}

}  // namespace etendue
