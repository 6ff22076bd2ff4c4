#include "experiments/report/ratios.h"

#include "experiments/report/report_text.h"
#include "framework/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

namespace etendue {

namespace {

double mse_at_end(const Replicate& replicate, const std::string& region) {
  if (replicate.last() == nullptr) throw Error("no checkpoint was logged");
  const CheckpointRecord& last = *replicate.last();
  const auto* metrics = &last.metrics;
  if (!region.empty()) {
    const auto found = last.regions.find(region);
    if (found == last.regions.end()) throw Error(fmt::format("region '{}' was not logged", region));
    metrics = &found->second;
  }
  const auto mse = metrics->find("mse");
  if (mse == metrics->end()) throw Error("mse was not logged");
  return mse->second;
}

FoundRatio find_ratio(const RatioClaim& claim, const SceneData& scene, const Configuration& method, const Configuration& over) {
  FoundRatio found;
  found.claim = &claim;
  found.scene = scene.name;
  found.method = method.integrator;
  found.over = over.integrator;
  // The reference's variance is known for the image as a whole; of a region it is left in.
  const double floor = claim.region.empty() && scene.reference != nullptr ? scene.reference->mse_floor : 0;
  try {
    std::vector<double> above, below;
    for (const Replicate& a : method.replicates)
      for (const Replicate& b : over.replicates)
        if (a.seed == b.seed) {
          above.push_back(mse_at_end(a, claim.region) - floor);
          below.push_back(mse_at_end(b, claim.region) - floor);
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
      out[1] = std::sqrt(a / b);
    };
    std::vector<std::size_t> all(above.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
    double whole[2];
    figures(all, whole);
    if (std::all_of(below.begin(), below.end(), [](double mse) { return mse == 0; }))
      throw Error("the other method has no error");
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

// The first configuration a selection has: one structure says it all, since structures change only the time.
std::vector<const Configuration*> selected(const SceneData& scene, const std::string& method) {
  std::vector<const Configuration*> configurations;
  std::set<std::size_t> seen;
  for (const Configuration& configuration : scene.configurations)
    if (!configuration.replicates.empty() && selects(method, configuration.integrator) &&
        seen.insert(configuration.integrator_index).second)
      configurations.push_back(&configuration);
  return configurations;
}

std::vector<std::string> parts(const std::string& label) {
  std::istringstream stream(label);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

// Labels without the words that all of them have.
class ShortNames {
 public:
  explicit ShortNames(const std::vector<FoundRatio>& ratios) {
    for (const FoundRatio& ratio : ratios)
      for (const std::string* label : {&ratio.method, &ratio.over}) {
        const auto words = parts(*label);
        const std::set<std::string> present(words.begin(), words.end());
        if (common_.empty() && !any_) common_ = present;
        std::erase_if(common_, [&](const std::string& word) { return !present.contains(word); });
        any_ = true;
      }
  }

  std::string of(const std::string& label) const {
    std::string name;
    for (const std::string& word : parts(label))
      if (!common_.contains(word)) name += (name.empty() ? "" : " ") + word;
    return name.empty() ? label : name;
  }

 private:
  std::set<std::string> common_;
  bool any_ = false;
};

std::string figure_with(double value, const std::optional<Interval>& interval) {
  std::string text = format_figure(value);
  if (interval) text += " (" + format_interval(interval->low, interval->high) + ")";
  return text;
}

void add_interval(std::vector<TableCell>& row, double value, const std::optional<Interval>& interval) {
  row.push_back(TableCell::number(value));
  row.push_back(interval ? TableCell::number(interval->low) : TableCell{});
  row.push_back(interval ? TableCell::number(interval->high) : TableCell{});
}

std::string side(const FoundRatio& ratio) {
  if (!ratio.claim->expected) return "–";
  const auto kept = ratio.side_as_expected();
  return kept ? *kept ? "yes" : "NO" : "open";
}

// Ratios that share a scene, a place and what they are over can be put in order.
using Group = std::vector<const FoundRatio*>;
std::vector<Group> expected_groups(const std::vector<FoundRatio>& ratios) {
  std::vector<Group> groups;
  for (const FoundRatio& ratio : ratios) {
    if (!ratio.claim->expected || !ratio.problem.empty()) continue;
    const auto found = std::find_if(groups.begin(), groups.end(), [&](const Group& group) {
      const FoundRatio& other = *group.front();
      return other.scene == ratio.scene && other.over == ratio.over && other.claim->region == ratio.claim->region;
    });
    if (found == groups.end())
      groups.push_back({&ratio});
    else
      found->push_back(&ratio);
  }
  return groups;
}

}  // namespace

std::optional<bool> FoundRatio::side_as_expected() const {
  if (!claim->expected || *claim->expected == 1 || !ratio_interval || ratio_interval->contains(1)) return std::nullopt;
  return (ratio > 1) == (*claim->expected > 1);
}

std::vector<FoundRatio> find_ratios(const ReportData& data) {
  std::vector<FoundRatio> ratios;
  for (const RatioClaim& claim : data.log->rates.ratios)
    for (const SceneData& scene : data.scenes) {
      if (!data.log->rates.concerns(claim.scene, claim.region, scene.name)) continue;
      const auto over = selected(scene, claim.over);
      if (over.empty()) continue;
      for (const Configuration* method : selected(scene, claim.method))
        if (method->integrator_index != over.front()->integrator_index)
          ratios.push_back(find_ratio(claim, scene, *method, *over.front()));
    }
  return ratios;
}

Table ratios_table(const std::vector<FoundRatio>& ratios) {
  Table table{"ratios", "RMSE of methods over others'", {}, {}, {}, {}};
  table.columns = {{"scene", "scene", false},
                   {"region", "region", false},
                   {"method", "method", false},
                   {"", "RMSE (95 %)", true, Audience::people}};
  for (const char* key : {"rmse", "rmse_low", "rmse_high"}) table.columns.push_back({key, "", true, Audience::machines});
  table.columns.push_back({"over", "over", false});
  table.columns.push_back({"", "ratio (95 %)", true, Audience::people});
  for (const char* key : {"ratio", "ratio_low", "ratio_high"}) table.columns.push_back({key, "", true, Audience::machines});
  table.columns.push_back({"expected", "expected"});
  table.columns.push_back({"side", "side of 1 as expected", false});
  table.columns.push_back({"seeds", "seeds"});
  table.columns.push_back({"source", "source", false});
  const ShortNames names(ratios);
  for (const FoundRatio& r : ratios) {
    const bool fine = r.problem.empty();
    std::vector<TableCell> row{
        TableCell::words(r.scene), TableCell::words(r.claim->region.empty() ? "whole image" : r.claim->region),
        TableCell::words(names.of(r.method)),
        fine ? TableCell::number(r.rmse, figure_with(r.rmse, r.rmse_interval)) : TableCell::words(r.problem)};
    add_interval(row, r.rmse, r.rmse_interval);
    row.push_back(TableCell::words(names.of(r.over)));
    row.push_back(fine ? TableCell::number(r.ratio, figure_with(r.ratio, r.ratio_interval)) : TableCell{});
    add_interval(row, r.ratio, r.ratio_interval);
    row.push_back(r.claim->expected ? TableCell::number(*r.claim->expected, format_short(*r.claim->expected)) : TableCell{});
    row.push_back(TableCell::words(side(r)));
    row.push_back(TableCell::count(r.seeds));
    row.push_back(r.claim->source.empty() ? TableCell{} : TableCell::words(r.claim->source));
    table.rows.push_back(std::move(row));
  }
  if (ratios.empty()) return table;
  table.notes.push_back(
      "RMSE at the end of each run, over the seeds that both methods have, the reference's own noise taken away; intervals are "
      "95 % bootstraps over seeds (none below three). The side is open where the interval holds 1.");
  if (const std::string finding = ratios_finding(ratios); !finding.empty()) table.notes.push_back(finding);
  return table;
}

std::string ratios_finding(const std::vector<FoundRatio>& ratios) {
  const ShortNames names(ratios);
  std::string text;
  for (Group& group : expected_groups(ratios)) {
    std::size_t kept = 0, turned = 0, pairs = 0, pairs_kept = 0;
    for (const FoundRatio* ratio : group) {
      const auto side = ratio->side_as_expected();
      kept += side == true;
      turned += side == false;
    }
    for (std::size_t i = 0; i < group.size(); ++i)
      for (std::size_t j = i + 1; j < group.size(); ++j) {
        const double expected = *group[i]->claim->expected - *group[j]->claim->expected;
        if (expected == 0) continue;
        ++pairs;
        pairs_kept += (expected > 0) == (group[i]->ratio > group[j]->ratio);
      }
    const FoundRatio& first = *group.front();
    const std::string place = first.claim->region.empty() ? "" : ", " + first.claim->region;
    text += fmt::format("{}{}{}, over {}: {} of {} ratios lie on the side of 1 that was expected, {} on the other",
                        text.empty() ? "" : ". ", first.scene, place, names.of(first.over), kept, group.size(), turned);
    if (pairs > 0) text += fmt::format("; of {} pairs of methods {} are in the order expected", pairs, pairs_kept);
    std::stable_sort(group.begin(), group.end(), [](const auto* a, const auto* b) { return a->ratio > b->ratio; });
    text += "; found, worst first:";
    for (const FoundRatio* ratio : group)
      text += fmt::format("{} {} {}", ratio == group.front() ? "" : ",", names.of(ratio->method), format_figure(ratio->ratio));
  }
  return text.empty() ? text : text + ".";
}

}  // namespace etendue
