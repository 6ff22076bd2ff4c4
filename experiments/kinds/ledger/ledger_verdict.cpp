#include "experiments/kinds/ledger/ledger_verdict.h"

#include "framework/core/check.h"

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

constexpr double worth = 1.05;      // the least ratio that counts
constexpr double rounding = 1e-10;  // relMSE
constexpr double family_level = 0.05;

// The geometric mean of ratios whose logarithms are given.
Estimate ratio_estimate(const std::vector<double>& logs, double confidence) {
  Estimate estimate = signed_estimate(logs, confidence);
  estimate.centre = std::exp(estimate.centre);
  estimate.interval = {std::exp(estimate.interval.low), std::exp(estimate.interval.high)};
  return estimate;
}

bool above(const Estimate& e) { return e.spread == Spread::t95 && e.interval.low > 1 && e.centre >= worth; }
bool below(const Estimate& e) { return e.spread == Spread::t95 && e.interval.high < 1 && e.centre <= 1 / worth; }
bool little(const Estimate& e) { return e.spread == Spread::t95 && e.interval.low >= 1 / worth && e.interval.high <= worth; }

}  // namespace

std::string_view verdict_name(LedgerVerdict verdict) {
  constexpr std::string_view names[ledger_verdict_count] = {"earns its time", "costs nothing", "no difference beyond noise",
                                                            "a trade", "contradicted"};
  return names[static_cast<std::size_t>(verdict)];
}

LedgerFigures ledger_figures(const LedgerRecord& record, double confidence) {
  CHECK(!record.trials.empty());
  // A method whose error does not fall by itself is taken as one whose noise does.
  const double power = record.mse_exponent < 0 ? -1 / record.mse_exponent : 1;
  std::vector<double> errors, times, both;
  bool same = true;
  for (const LedgerTrial& trial : record.trials) {
    const auto log_ratio = [](double a, double b, double least) { return std::log(std::max(a, least) / std::max(b, least)); };
    errors.push_back(log_ratio(trial.switched_error, trial.error, rounding));
    times.push_back(log_ratio(trial.switched_cpu_s, trial.cpu_s, 1e-9));
    both.push_back(power * errors.back() + times.back());
    same = same && trial.same_image;
  }
  return {ratio_estimate(errors, confidence), ratio_estimate(times, confidence), ratio_estimate(both, confidence), same};
}

LedgerVerdict judge_decision(const LedgerRecord& record, std::size_t decisions) {
  const LedgerFigures strict = ledger_figures(record, 1 - sidak_level(family_level, std::max<std::size_t>(1, decisions)));
  const bool trade = (above(strict.error) && below(strict.time)) || (below(strict.error) && above(strict.time));
  if (record.bias == "biased" && trade) return LedgerVerdict::trade;
  if (above(strict.time_to_error)) return LedgerVerdict::earns_its_time;
  if (below(strict.time_to_error)) return LedgerVerdict::contradicted;
  const LedgerFigures usual = ledger_figures(record);
  return little(usual.error) && little(usual.time) ? LedgerVerdict::costs_nothing : LedgerVerdict::no_difference;
}

}  // namespace etendue
