#include "experiments/report/verdicts.h"

#include "experiments/report/report_text.h"
#include "experiments/report/structures/structure_figures.h"
#include "experiments/statistics/rank_test.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

namespace etendue {
namespace {

constexpr std::size_t fewest_for_interval = 3;  // seeds of each, as geometric_ratio asks

struct Contender {
  const Configuration* configuration;
  Estimate error;
};

// Each integrator's best configuration at the common time, least error first. Structures change only the time, so one
// integrator's variants do not compete with each other here.
std::vector<Contender> contenders(const ReportData& data, const SceneData& scene, std::vector<std::string>& late) {
  std::map<std::size_t, Contender> best;
  std::map<std::size_t, std::string> absent;
  for (const Configuration& configuration : scene.configurations) {
    if (configuration.replicates.empty()) continue;
    const auto estimate = estimate_at(configuration, data.main_metric(), scene.common_time_s);
    if (!estimate) {
      absent.emplace(configuration.integrator_index, configuration.short_integrator);
      continue;
    }
    const auto [entry, fresh] = best.try_emplace(configuration.integrator_index, Contender{&configuration, *estimate});
    if (!fresh && estimate->centre < entry->second.error.centre) entry->second = {&configuration, *estimate};
  }
  for (const auto& [index, name] : absent)
    if (!best.contains(index)) late.push_back(name);
  std::vector<Contender> sorted = values_of(best);
  std::ranges::stable_sort(sorted, {}, [](const Contender& c) { return c.error.centre; });
  return sorted;
}

// A/B, with a warning where ranks of so few seeds say little.
std::string rank_text(std::span<const double> a, std::span<const double> b) {
  std::string text = fmt::format("by ranks p = {:.2g}", rank_test(a, b).p);
  const std::size_t least = std::min(a.size(), b.size());
  if (least < enough_replicates) text += fmt::format(", of {} seeds where {} are due", least, enough_replicates);
  return text;
}

Finding accuracy(const ReportData& data, const SceneData& scene) {
  Finding finding{"Accuracy", {}, {}};
  std::vector<std::string> late;
  const auto ranked = contenders(data, scene, late);
  const std::string when = format_seconds(scene.common_time_s);
  if (ranked.empty()) return finding;
  const Contender& first = ranked.front();
  finding.lead = fmt::format("{} has {}{}", short_label(data, *first.configuration), ranked.size() > 1 ? "the least " : "",
                             data.main_metric());
  std::string& text = finding.text;
  text = fmt::format(" at {}: {}, {}.", when, describe(first.error), counted(first.error.count, "seed"));
  if (ranked.size() > 1) {
    const Contender& next = ranked[1];
    const std::string name = short_label(data, *next.configuration);
    const auto a = values_at(*next.configuration, data.main_metric(), scene.common_time_s);
    const auto b = values_at(*first.configuration, data.main_metric(), scene.common_time_s);
    if (const auto ratio = geometric_ratio(a, b)) {
      const std::string times = fmt::format("{} times the error (95 % interval {}–{})", format_figure(ratio->value),
                                            format_figure(ratio->interval.low), format_figure(ratio->interval.high));
      const std::string ranks = rank_text(b, a);
      text += ratio->interval.low > 1 ? fmt::format(" Next comes {}, {}; {}.", name, times, ranks)
                                      : fmt::format(" These seeds do not tell it from {}: {}; {}.", name, times, ranks);
    } else {
      const std::string error = first.error.centre > 0
                                    ? format_figure(next.error.centre / first.error.centre) + " times the error"
                                    : "with " + format_figure(next.error.centre);
      const bool few = std::min(a.size(), b.size()) < fewest_for_interval;
      text += fmt::format(
          " Next comes {}, {}; {}.", name, error,
          few ? "with so few seeds the order may be chance" : "errors of zero leave no interval; " + rank_text(b, a));
    }
  }
  if (!late.empty()) text += fmt::format(" No result by then: {}.", enumerate(late, ", ", 8));
  return finding;
}

std::string lead_text(const ReportData& data, const SceneData& scene) {
  constexpr double shortest = 1.5;  // end over begin: shorter leads are of no use, and may be the noise of a few seeds
  std::vector<std::pair<const Configuration*, double>> leads;
  const auto append = [&](const Configuration* leader, double begin_s) {
    if (leads.empty() || leads.back().first->integrator_index != leader->integrator_index) leads.emplace_back(leader, begin_s);
  };
  for (const LeadInterval& lead : lead_intervals(scene, data.main_metric()))
    append(&scene.configurations[lead.configuration], lead.begin_s);
  const auto all = std::exchange(leads, {});
  for (std::size_t i = 0; i < all.size(); ++i)
    if (i + 1 == all.size() || all[i + 1].second >= shortest * all[i].second) append(all[i].first, all[i].second);
  const auto text = [](const auto& lead) {
    return fmt::format("{} from {}", lead.first->short_integrator, format_seconds(lead.second));
  };
  return leads.size() < 2 ? std::string() : "Least error: " + enumerate(mapped(leads, text), ", then ", 6) + ".";
}

// Each integrator stands on its best structure.
std::string target_text(const ReportData& data, const SceneData& scene) {
  std::map<std::size_t, std::pair<ArrivalMedian, const Configuration*>> best;
  for (const Configuration& configuration : scene.configurations) {
    const auto arrival = arrival_of(configuration, data.main_metric(), scene.target_error);
    if (!arrival) continue;
    const auto [entry, fresh] = best.try_emplace(configuration.integrator_index, *arrival, &configuration);
    if (!fresh && is_earlier(arrival->median, entry->second.first.median)) entry->second = {*arrival, &configuration};
  }
  if (best.size() < 2) return {};
  auto sorted = values_of(best);
  std::ranges::stable_sort(sorted, is_earlier, [](const auto& entry) { return entry.first.median; });
  std::vector<std::string> parts;
  for (const auto& [arrival, configuration] : sorted)
    parts.push_back(fmt::format("{} {}", short_label(data, *configuration), describe(arrival)));
  return fmt::format("To {} {}: {}.", data.main_metric(), format_short(scene.target_error), enumerate(parts, "; ", 6));
}

// Iterations per second of each structure against the fastest, averaged geometrically over the integrators that ran on all.
std::string throughput_text(const ReportData& data, const SceneData& scene) {
  std::map<std::size_t, std::map<std::size_t, double>> rates;  // integrator, accel
  std::set<std::size_t> accels;
  for (const Configuration& configuration : scene.configurations) {
    std::vector<double> values;
    for (const Replicate& replicate : configuration.replicates)
      if (replicate.last()->time_s > 0)
        values.push_back(static_cast<double>(replicate.last()->iterations) / replicate.last()->time_s);
    if (values.empty() || median(values) <= 0) continue;
    rates[configuration.integrator_index][configuration.accel_index] = median(values);
    accels.insert(configuration.accel_index);
  }
  std::erase_if(rates, [&](const auto& entry) { return entry.second.size() != accels.size(); });
  if (accels.size() < 2 || rates.empty()) return {};
  std::vector<std::pair<double, std::size_t>> ranked;
  for (const std::size_t accel : accels) {
    const auto values = mapped(rates, [&](const auto& by_integrator) { return by_integrator.second.at(accel); });
    ranked.emplace_back(geometric_mean(values), accel);
  }
  std::ranges::sort(ranked, [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::string> parts;
  for (const auto& [rate, accel] : ranked)
    parts.push_back(fmt::format("{} {}", data.shown_accels[accel], format_figure(rate / ranked.front().first)));
  return fmt::format(
      "Iterations per second of whole runs, building included, {} = 1, over {}: {}.", data.shown_accels[ranked.front().second],
      rates.size() == 1 ? "one integrator" : fmt::format("{} integrators", rates.size()), enumerate(parts, ", ", 12));
}

struct LeadingStructures {
  const StructureRecord *fastest = nullptr, *quickest = nullptr, *smallest = nullptr;
  std::size_t count = 0;
  bool clear = true;  // the fastest's quartiles lie above those of all others
};

LeadingStructures leading_structures(const RunLog& log, const std::string& scene) {
  LeadingStructures leading;
  auto& [fastest, quickest, smallest, count, clear] = leading;
  for (const StructureRecord& record : log.structures) {
    if (record.scene != scene) continue;
    ++count;
    if (fastest == nullptr || record.speed(RayKind::diffuse).median > fastest->speed(RayKind::diffuse).median)
      fastest = &record;
    if (record.nodes > 0 && (quickest == nullptr || record.build_s.median < quickest->build_s.median)) quickest = &record;
    if (record.bytes > 0 && (smallest == nullptr || record.bytes < smallest->bytes)) smallest = &record;
  }
  for (const StructureRecord& record : log.structures)
    if (record.scene == scene && &record != fastest)
      clear = clear && record.speed(RayKind::diffuse).high < fastest->speed(RayKind::diffuse).low;
  return leading;
}

std::string structures_text(const RunLog& log, const std::string& scene) {
  const auto [fastest, quickest, smallest, count, clear] = leading_structures(log, scene);
  if (count < 2) return {};
  std::string text = fmt::format("Of {} structures, {} traces diffuse rays fastest ({} Mrays/s{}, built in {})", count,
                                 structure_name(*fastest), format_figure(fastest->speed(RayKind::diffuse).median),
                                 clear ? "" : ", not beyond the spread of others", format_seconds(fastest->build_s.median));
  if (quickest != nullptr)
    text += fmt::format("; {} is built first ({})", structure_name(*quickest), format_seconds(quickest->build_s.median));
  if (smallest != nullptr)
    text += fmt::format("; {} is smallest ({})", structure_name(*smallest), format_bytes(static_cast<double>(smallest->bytes)));
  return text + ".";
}

// Its name without parameters, where no other of the scene's has it.
std::string short_name(const SceneData& scene, const Configuration& configuration) {
  const auto first_word = [](const std::string& name) { return name.substr(0, name.find(' ')); };
  const std::string word = first_word(configuration.integrator);
  const bool shared = std::ranges::any_of(scene.configurations, [&](const Configuration& other) {
    return other.integrator_index != configuration.integrator_index && first_word(other.integrator) == word;
  });
  return shared || configuration.shown_integrator != configuration.integrator ? configuration.shown_integrator : word;
}

// Whether the seeds tell the first from the next; nothing where there are too few of them. An error of zero has no logarithm:
// ranks then tell.
std::optional<bool> is_clear(const ReportData& data, const SceneData& scene, const std::vector<Contender>& ranked) {
  const auto errors = [&](std::size_t i) {
    return values_at(*ranked[i].configuration, data.main_metric(), scene.common_time_s);
  };
  const std::vector<double> first = errors(0), next = errors(1);
  if (std::min(first.size(), next.size()) < fewest_for_interval) return std::nullopt;
  if (const auto ratio = geometric_ratio(next, first)) return ratio->interval.low > 1;
  const RankTest ranks = rank_test(first, next);
  return ranks.share > 0.5 && ranks.p < 0.05;
}

std::string at_times(double earliest_s, double latest_s) {
  const std::string earliest = format_seconds(earliest_s), latest = format_seconds(latest_s);
  return earliest == latest ? "at " + latest : fmt::format("at {} to {}", earliest, latest);
}

std::string shown_scene(const std::string& name) {
  constexpr std::string_view builtin = "builtin:";
  return name.starts_with(builtin) ? name.substr(builtin.size()) : name;
}

}  // namespace

std::string who_leads(const std::vector<Lead>& leads, std::string_view does, std::string_view places) {
  std::vector<std::pair<std::string, std::vector<std::string>>> leaders;
  for (const Lead& lead : leads) {
    const auto same = [&](const auto& leader) { return leader.first == lead.who; };
    find_or_add(leaders, same, {lead.who, {}}).second.push_back(lead.where);
  }
  std::ranges::stable_sort(leaders, [](const auto& a, const auto& b) { return a.second.size() > b.second.size(); });
  if (leads.size() == 1) return fmt::format("{} {} on {}", leads[0].who, does, leads[0].where);
  if (leaders.size() == 1) return fmt::format("{} {} on all {} {}", leaders[0].first, does, leads.size(), places);
  const auto sentence = [&](bool named) {
    std::vector<std::string> parts;
    for (const auto& [who, where] : leaders) {
      parts.push_back(parts.empty() ? fmt::format("{} {} on {} of {} {}", who, does, where.size(), leads.size(), places)
                                    : fmt::format("{} on {}", who, where.size()));
      if (named) parts.back() += fmt::format(" ({})", fmt::join(where, ", "));
    }
    return enumerate(parts, ", ", 5);
  };
  return leads.empty() ? "" : display_width(sentence(true)) <= answer_width ? sentence(true) : sentence(false);
}

std::string images_answer(const ReportData& data) {
  if (data.empty() || data.is_signed(data.main_metric())) return {};
  std::vector<Lead> leads;
  std::size_t clear = 0, told = 0;
  double earliest = 0, latest = 0;
  std::string alone;
  for (const SceneData& scene : data.scenes) {
    std::vector<std::string> late;
    const auto ranked = scene.common_time_s > 0 ? contenders(data, scene, late) : std::vector<Contender>();
    if (ranked.empty()) continue;
    if (ranked.size() == 1) {
      alone = fmt::format("{} has {} {} at {} on {}", short_name(scene, *ranked[0].configuration), data.main_metric(),
                          format_figure(ranked[0].error.centre), format_seconds(scene.common_time_s), shown_scene(scene.name));
      continue;
    }
    earliest = leads.empty() ? scene.common_time_s : std::min(earliest, scene.common_time_s);
    latest = std::max(latest, scene.common_time_s);
    leads.push_back({short_name(scene, *ranked[0].configuration), shown_scene(scene.name)});
    const auto is = is_clear(data, scene, ranked);
    told += is.has_value();
    clear += is.value_or(false);
  }
  if (leads.empty()) return alone;
  const std::string does = fmt::format("has the least {} {}", data.main_metric(), at_times(earliest, latest));
  return who_leads(leads, does, "scenes") + (told == 0 ? "; too few seeds to tell that from noise"
                                                       : fmt::format("; beyond noise on {} of {}", clear, leads.size()));
}

std::string structures_answer(const RunLog& log) {
  std::vector<std::string> scenes;
  for (const StructureRecord& record : log.structures) index_in(scenes, record.scene);
  std::vector<Lead> fastest, quickest, smallest;
  std::size_t clear = 0;
  for (const std::string& scene : scenes) {
    const LeadingStructures leading = leading_structures(log, scene);
    if (leading.count < 2) continue;
    clear += leading.clear;
    const auto add = [&](std::vector<Lead>& leads, const StructureRecord* record) {
      if (record != nullptr) leads.push_back({structure_name(*record), shown_scene(scene)});
    };
    add(fastest, leading.fastest);
    add(quickest, leading.quickest);
    add(smallest, leading.smallest);
  }
  if (fastest.empty()) return {};
  std::string text = fmt::format("{}; beyond the spread on {} of {}",
                                 who_leads(fastest, "traces diffuse rays fastest", "scenes"), clear, fastest.size());
  for (const std::string& more :
       {who_leads(quickest, "is built first", "scenes"), who_leads(smallest, "is smallest", "scenes")})
    if (!more.empty() && display_width(text + "; " + more) <= answer_width) text += "; " + more;
  return text;
}

std::string enumerate(const std::vector<std::string>& names, std::string_view separator, std::size_t most) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i == most) return text + fmt::format(" and {} more", names.size() - most);
    if (i > 0) text += separator;
    text += names[i];
  }
  return text;
}

std::string describe(const Estimate& estimate) {
  const std::string centre = format_figure(estimate.centre);
  if (estimate.spread == Spread::none) return centre;
  return fmt::format("{} ({} {})", centre, estimate.spread == Spread::t95 ? "95 % interval" : "extremes",
                     format_interval(estimate.interval.low, estimate.interval.high));
}

std::string describe(const ArrivalMedian& arrival) {
  constexpr const char* marks[] = {"", "≤ ", "> "};
  const auto kind = arrival.median.kind;
  const std::string time = marks[static_cast<std::size_t>(kind)] + format_seconds(arrival.median.time);
  return kind != Arrival::Kind::never || arrival.count == 1
             ? time
             : fmt::format("{} ({} of {} arrived)", time, arrival.arrived, arrival.count);
}

Conclusions conclude(const ReportData& data) {
  Conclusions conclusions;
  for (const SceneData& scene : data.scenes) {
    SceneFindings found{scene.name, {}};
    const auto add = [&](const char* topic, const std::string& text) {
      if (!text.empty()) found.findings.push_back({topic, "", text});
    };
    // A signed figure has no order of good and bad: where nothing else was logged, nobody leads.
    if (!data.empty() && scene.common_time_s > 0 && !data.is_signed(data.main_metric())) {
      if (Finding first = accuracy(data, scene); !first.text.empty()) found.findings.push_back(std::move(first));
      add("Over time", lead_text(data, scene));
      add("Time to error", target_text(data, scene));
    }
    const auto failed = std::ranges::find_if(scene.configurations, [](const Configuration& c) { return !c.failures.empty(); });
    if (scene.finished().empty() && failed != scene.configurations.end())
      add("No cell finished", failed->failures.front()->error);
    add("Throughput", throughput_text(data, scene));
    add("Structures", structures_text(*data.log, scene.name));
    if (!found.findings.empty()) conclusions.scenes.push_back(std::move(found));
  }
  conclusions.warnings = warnings_of(data);
  return conclusions;
}

}  // namespace etendue
