#include "experiments/config/budget.h"

#include "framework/core/check.h"
#include "framework/core/error.h"
#include "framework/core/lists.h"
#include "framework/core/units.h"
#include "framework/io/text.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <numbers>

namespace etendue {

namespace {

constexpr double never = std::numeric_limits<double>::infinity();

// The number after the prefix, from 1 to `most`.
std::optional<int> steps(std::string_view text, std::string_view prefix, int most) {
  if (!text.starts_with(prefix)) return std::nullopt;
  const auto count = parse_whole<int>(text.substr(prefix.size()));
  return count && *count >= 1 && *count <= most ? count : std::nullopt;
}

}  // namespace

CheckpointLadder CheckpointLadder::parse(const std::string& text) {
  if (text == "log") return {};
  if (text == "sqrt2") return {.factor = std::numbers::sqrt2};
  if (const auto count = steps(text, "linear:", 100000)) return {.linear = *count};
  if (const auto count = steps(text, "quarters:", 10)) return {.factor = 4, .lowest = std::pow(0.25, *count - 1)};
  throw Error(
      fmt::format("bad checkpoints '{}'; expected \"log\", \"sqrt2\", \"linear:N\" with N in 1 .. 100000, or "
                  "\"quarters:N\" with N in 1 .. 10",
                  text));
}

std::string Budget::text() const {
  std::vector<std::string> limits;
  if (error) limits.push_back(fmt::format("relmse {:g}", *error));
  if (samples) limits.push_back(fmt::format("{} iteration{}", *samples, *samples == 1 ? "" : "s"));
  if (time_s) limits.push_back(format_seconds(*time_s));
  return joined(limits, ", ");
}

double Budget::progress(std::uint64_t iterations, double seconds, std::optional<double> relmse) const {
  double share = 0;
  if (samples) share = std::max(share, static_cast<double>(iterations) / static_cast<double>(*samples));
  if (time_s) share = std::max(share, seconds / *time_s);
  if (error && relmse && *relmse > 0) share = std::max(share, *error / *relmse);
  return std::min(share, 1.0);
}

BudgetSchedule::BudgetSchedule(const Budget& budget) : budget_(budget) {
  CHECK(budget.time_s || budget.samples);
  // The first iteration is always a checkpoint: the error a method starts from.
  next_iterations_ = budget.samples ? 1 : never;
  next_time_ = budget.time_s ? 0 : never;
}

bool BudgetSchedule::finished(std::uint64_t iterations, double time_s, double last_iteration_s) {
  lengths_ = {lengths_[1], lengths_[2], last_iteration_s};
  if (iterations >= std::numeric_limits<std::uint32_t>::max()) return true;  // an iteration's index has 32 bits
  if (budget_.samples && iterations >= *budget_.samples) return true;
  if (!budget_.time_s) return false;
  const auto [a, b, c] = lengths_;
  const double predicted =
      iterations < lengths_.size() ? last_iteration_s : std::max(std::min(a, b), std::min(std::max(a, b), c));
  return time_s + predicted > *budget_.time_s;
}

double BudgetSchedule::next_rung(double total, double reached) const {
  if (budget_.checkpoints.linear > 0) {
    const double step = total / budget_.checkpoints.linear;
    return step * (std::floor(reached / step * (1 + 1e-12)) + 1);
  }
  // The lowest total / factor^k above what is reached.
  double rung = total;
  while (rung / budget_.checkpoints.factor > reached * (1 + 1e-12) && rung > budget_.checkpoints.lowest * total)
    rung /= budget_.checkpoints.factor;
  return rung;
}

bool BudgetSchedule::checkpoint_due(std::uint64_t iterations, double time_s) {
  bool due = false;
  if (const auto count = static_cast<double>(iterations); count >= next_iterations_) {
    due = true;
    next_iterations_ = std::ceil(next_rung(static_cast<double>(*budget_.samples), count) - 1e-9);
  }
  if (time_s >= next_time_) {
    due = true;
    next_time_ = next_rung(*budget_.time_s, time_s);
  }
  return due;
}

bool BudgetSchedule::error_due(std::uint64_t iterations) {
  if (!budget_.error || iterations < next_error_) return false;
  next_error_ = iterations + std::max<std::uint64_t>(1, iterations / 10);
  return true;
}

double now_s(Clock clock) {
  constexpr clockid_t ids[] = {CLOCK_MONOTONIC, CLOCK_PROCESS_CPUTIME_ID, CLOCK_THREAD_CPUTIME_ID};
  timespec now{};
  clock_gettime(ids[static_cast<int>(clock)], &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void RunClock::start() {
  CHECK(!running_);
  running_ = true;
  wall_start_ = now_s();
  cpu_start_ = now_s(Clock::process);
}

void RunClock::stop() {
  CHECK(running_);
  wall_ += now_s() - wall_start_;
  cpu_ += now_s(Clock::process) - cpu_start_;
  running_ = false;
}

double RunClock::wall_s() const { return running_ ? wall_ + now_s() - wall_start_ : wall_; }
double RunClock::cpu_s() const { return running_ ? cpu_ + now_s(Clock::process) - cpu_start_ : cpu_; }

}  // namespace etendue
