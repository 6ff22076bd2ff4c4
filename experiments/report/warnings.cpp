// Warnings of what should keep a reader from believing a report: failures, a noisy reference, biases and rates that are not as
// declared.
#include "experiments/report/declared.h"
#include "experiments/report/rates.h"
#include "experiments/report/report_text.h"
#include "experiments/report/verdicts.h"
#include "experiments/statistics/agreement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <tuple>

namespace etendue {
namespace {

using Warnings = std::vector<std::string>;

template <class... Args>
void warn(Warnings& warnings, fmt::format_string<Args...> text, Args&&... args) {
  warnings.push_back(fmt::format(text, std::forward<Args>(args)...));
}

// A method's errors do not depend on the structure: the first one stands for all.
std::vector<const Configuration*> one_per_integrator(const SceneData& scene) {
  std::map<std::size_t, const Configuration*> first;
  for (const Configuration* configuration : scene.finished()) first.try_emplace(configuration->integrator_index, configuration);
  return values_of(first);
}

void warn_of_references(const ReportData& data, Warnings& warnings) {
  for (const ReferenceRecord& reference : data.log->references) {
    if (!knows_variance(reference))
      warn(warnings, "{}: nobody knows the variance of the reference, {}: none is subtracted, and no bias is judged by it.",
           reference.scene, reference.source);
    if (reference.checks.find(undecided) != std::string::npos)
      warn(warnings, "{}: the reference is unproven; {}.", reference.scene, reference.checks);
  }
  for (const SceneData& scene : data.scenes) {
    if (scene.reference == nullptr) {
      if (!scene.finished().empty()) warn(warnings, "{}: the log holds no reference record.", scene.name);
      continue;
    }
    if (const double share = floor_share(scene); share > floor_share_limit)
      warn(warnings,
           "{}: the reference's own variance ({}) is {} % of the smallest mean squared error drawn; it should stay below {} %. "
           "The lowest curves flatten on the reference's noise.",
           scene.name, format_figure(scene.reference->mse_floor), format_figure(100 * share),
           format_short(100 * floor_share_limit));
  }
  if (const auto noisy = data.noisy_references(); !noisy.empty() && !contains(data.metrics, "mse"))
    warn(warnings,
         "{}: {} noise of its own, and no mse was logged to hold it against: how much of each error that is, nobody knows.",
         enumerate(noisy, ", ", 4), noisy.size() == 1 ? "the reference has" : "each reference has");
  for (const std::string& scene : data.conflicts)
    warn(warnings,
         "{}: the merged logs measured different versions or sizes of this scene, or against different references; their "
         "figures are not comparable.",
         scene);
}

// The width that the noise of the reference's mean, which all seeds share, adds to the interval of their mean bias: it is to
// that of the seeds' mean as the variances of their pixels are.
double widened_by(const Configuration& configuration, double floor) {
  const std::vector<double> errors = final_values(configuration, "mse");
  if (floor == 0 || errors.empty()) return 1;
  const double own = std::max(0.0, mean(errors) - floor) / static_cast<double>(errors.size());
  return std::sqrt(1 + floor / own);  // infinite where seeds do not rise above it
}

void warn_of_bias(const ReportData& data, Warnings& warnings) {
  std::vector<std::pair<const Configuration*, double>> tested;  // and the variance of what it is held against
  for (const SceneData& scene : data.scenes)
    for (const Configuration* configuration : one_per_integrator(scene))
      if (configuration->any_cell()->bias == "unbiased" && final_values(*configuration, "bias").size() >= 3 &&
          (scene.reference == nullptr || knows_variance(*scene.reference)))
        tested.emplace_back(configuration, subtracted_variance(scene, ""));
  const double confidence = 1 - sidak_level(0.05, tested.size());
  for (const auto& [configuration, floor] : tested) {
    const auto [centre, interval, spread, count] = signed_estimate(final_values(*configuration, "bias"), confidence);
    const double half = widened_by(*configuration, floor) * (interval.high - centre);
    if (std::abs(centre) > half + rounded_by)
      warn(warnings,
           "{}: {} is declared unbiased, but its mean differs from the reference's by {} % ({} to {} %, at 95 % over all {} "
           "such tests together).",
           configuration->scene, configuration->shown_integrator, format_figure(100 * centre),
           format_figure(100 * (centre - half)), format_figure(100 * (centre + half)), tested.size());
  }
}

void warn_of_rates(const ReportData& data, Warnings& warnings) {
  for (const SceneData& scene : data.scenes)
    for (const Configuration* configuration : one_per_integrator(scene)) {
      const auto rate = measured_rate(*configuration, scene.reference);
      const CellRecord* cell = configuration->any_cell();
      // A biased method keeps its rate only until its plateau, and where that lies is not declared.
      if (!rate || !rate->fit.exponent_interval || rate->replicates < 10 || cell->bias == "biased") continue;
      if (cell->mse_exponent < rate->fit.exponent_interval->low)
        warn(warnings, "{}: {} converges more slowly than declared: exponent {:.2f} ({:.2f} to {:.2f}) against {}.", scene.name,
             configuration->shown_integrator, rate->fit.exponent, rate->fit.exponent_interval->low,
             rate->fit.exponent_interval->high, format_short(cell->mse_exponent));
    }
}

// The same integrator and seed after as many iterations must give the same bits on every structure.
void warn_of_images(const ReportData& data, Warnings& warnings) {
  for (const SceneData& scene : data.scenes) {
    // The structures by the hash of their image, which is the same for all of them.
    std::map<std::tuple<std::string, std::uint64_t, std::uint64_t>, std::map<std::string, std::string>> images;
    for (const Configuration& configuration : scene.configurations)
      for (const Replicate& replicate : configuration.replicates)
        if (!replicate.cell->image_hash.empty())
          images[{configuration.integrator, replicate.seed, replicate.last()->iterations}].emplace(replicate.cell->image_hash,
                                                                                                   configuration.accel);
    std::map<std::string, std::set<std::string>> differing;
    for (const auto& [key, by_hash] : images)
      if (by_hash.size() > 1)
        for (const auto& [hash, accel] : by_hash) differing[std::get<0>(key)].insert(accel);
    for (const auto& [integrator, accels] : differing)
      warn(warnings, "{}: images of {} differ between structures ({}) after equal iterations of equal seeds.", scene.name,
           integrator, enumerate({accels.begin(), accels.end()}, ", ", 8));
  }
}

// A figure under a structure's name that is another's; an error that is of light which the method does not find.
void warn_of_fallbacks(const ReportData& data, Warnings& warnings) {
  Warnings told;
  const auto tell = [&](const std::string& scene, const std::string& structure, const std::string& fallback) {
    if (!fallback.empty()) index_in(told, fmt::format("{}: {}: {}.", scene, structure, fallback));
  };
  for (const StructureRecord& record : data.log->structures) tell(record.scene, record.structure, record.fallback);
  for (const CellRecord& cell : data.log->cells) tell(cell.cell.scene, cell.cell.accel, cell.fallback);
  std::set<std::pair<std::string, std::string>> missing;  // by scene and method: each seed has another estimate
  for (const CellRecord& cell : data.log->cells)
    if (!cell.out_of_reach.empty() && missing.emplace(cell.cell.scene, cell.cell.integrator).second) {
      std::istringstream lines(cell.out_of_reach);
      for (std::string line; std::getline(lines, line);) told.push_back(fmt::format("{}: {}.", cell.cell.scene, line));
    }
  warnings.insert(warnings.end(), told.begin(), told.end());
}

// Warns of what the readers left out, replaced or found not finite: the image is of another scene than its files say.
void warn_of_scenes(const ReportData& data, Warnings& warnings) {
  constexpr std::size_t most_told = 10;
  for (const SceneData& scene : data.scenes) {
    if (scene.reference == nullptr) continue;
    std::vector<std::string> told = scene.reference->warnings;
    std::ranges::stable_partition(told, [](const std::string& w) { return w.find("NaN or infinity") != std::string::npos; });
    for (std::size_t i = 0; i < std::min(told.size(), most_told); ++i)
      warnings.push_back(told[i].starts_with(scene.name + ":") ? told[i] : scene.name + ": " + told[i]);
    if (told.size() > most_told)
      warn(warnings, "{}: {} more warnings of its reader stand in the log.", scene.name, told.size() - most_told);
  }
}

void warn_of_samples(const ReportData& data, Warnings& warnings) {
  constexpr std::size_t most_told = 10;
  std::uint64_t dropped = 0;
  std::set<std::string> sources;
  std::vector<std::string> places;
  for (const Configuration* configuration : data.finished())
    for (const Replicate& replicate : configuration->replicates) {
      if (replicate.last()->non_finite == 0) continue;
      dropped += replicate.last()->non_finite;
      sources.insert(fmt::format("{} on {}", label(data, *configuration), configuration->scene));
      for (const auto& [x, y, iteration] : replicate.cell->non_finite_at)
        if (places.size() < most_told)
          places.push_back(fmt::format("{} seed {} pixel ({}, {}) iteration {}", configuration->shown_integrator,
                                       replicate.seed, x, y, iteration));
    }
  if (dropped > 0)
    warn(warnings, "{} non-finite samples were dropped: {}.{}", dropped, enumerate({sources.begin(), sources.end()}, ", ", 6),
         places.empty() ? "" : " First: " + enumerate(places, "; ", most_told) + ".");
}

// Seeds that directories add to each other under one method's name.
void warn_of_budgets(const ReportData& data, Warnings& warnings) {
  std::map<std::string, const ManifestRecord*> manifests;
  for (const ManifestRecord& manifest : data.log->manifests) manifests[manifest.id] = &manifest;
  for (const Configuration* configuration : data.finished()) {
    std::set<std::string> experiments;
    std::set<std::pair<double, std::uint64_t>> budgets;         // seconds, or iterations
    std::map<std::string, std::set<std::uint64_t>> iterations;  // of runs that no time ends
    for (const Replicate& replicate : configuration->replicates)
      if (const auto found = manifests.find(replicate.last()->manifest); found != manifests.end()) {
        const double seconds = found->second->budget_s;
        experiments.insert(found->second->experiment_hash);
        if (seconds > 0)
          budgets.emplace(seconds, 0);
        else
          iterations[found->first].insert(replicate.last()->iterations);
      }
    // Where an error ends them, each seed has its own.
    for (const auto& [manifest, counts] : iterations)
      if (counts.size() == 1) budgets.emplace(0, *counts.begin());
    if (experiments.size() > 1 && budgets.size() > 1)
      warn(warnings, "{}: seeds of {} are merged that had different budgets; averages over them are of none of these.",
           configuration->scene, label(data, *configuration));
  }
}

void warn_of_runs(const ReportData& data, Warnings& warnings) {
  if (data.failed > 0) warn(warnings, "{} of {} cells failed; they are listed below.", data.failed, data.failed + data.done);
  warn_of_samples(data, warnings);
  warn_of_budgets(data, warnings);
  for (const StructureRecord& record : data.log->structures)
    if (record.disagreements > 0)
      warn(warnings, "{}: {} gave {} wrong answers to {} rays.", record.scene, record.structure, record.disagreements,
           record.checked);
  // The name alone does not tell a processor: virtual machines hide it.
  std::set<std::tuple<std::string, int, int, std::string, int, std::string, std::string>> machines;
  for (const ManifestRecord& m : data.log->manifests)
    machines.emplace(m.cpu, m.cpu_family, m.cpu_model, m.isa, m.threads, m.commit, m.flags);
  if (machines.size() > 1)
    warn(warnings, "{} different machines, instruction sets, thread counts or builds are merged here: compare times with care.",
         machines.size());
  if (data.done > 0 && data.most_seeds == 1)
    warn(warnings, "One seed for each configuration: there are no intervals, and an order between methods may be chance.");
  else if (data.most_seeds == 2)
    warn(warnings, "Two seeds for each configuration: bands show both extremes, which is no confidence interval.");
}

}  // namespace

double floor_share(const SceneData& scene) {
  if (scene.reference == nullptr || scene.reference->mse_floor <= 0) return 0;
  double smallest = std::numeric_limits<double>::infinity();
  for (const Configuration& configuration : scene.configurations)
    for (const SeriesPoint& point : aggregate(configuration, "mse", Abscissa::iterations, false))
      smallest = std::min(smallest, point.y.centre);
  return std::isfinite(smallest) ? (smallest > 0 ? scene.reference->mse_floor / smallest : 1.0) : 0;
}

std::vector<std::string> warnings_of(const ReportData& data) {
  std::vector<std::string> warnings;
  for (const std::string& finding : data.findings) warn(warnings, "{}.", finding);
  warn_of_runs(data, warnings);
  warn_of_scenes(data, warnings);
  warn_of_fallbacks(data, warnings);
  warn_of_references(data, warnings);
  warn_of_bias(data, warnings);
  warn_of_rates(data, warnings);
  warn_of_images(data, warnings);
  return warnings;
}

}  // namespace etendue
