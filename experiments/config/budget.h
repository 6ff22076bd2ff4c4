// When a cell stops and where its error is measured: the one budget of every method.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace etendue {

// Checkpoints run backwards from the end: T, T/f, T/f^2, ... (`log`: f = 2, `sqrt2`: f = sqrt 2, `quarters:n`: n of them,
// f = 4), or T/n, 2T/n, ..., T (`linear:n`). T is the time or the count of iterations the budget allows.
struct CheckpointLadder {
  double factor = 2;
  int linear = 0;           // > 0: so many equal steps instead
  double lowest = 0x1p-20;  // no rung is below this share of T but the first iteration, which is always one

  // "log", "sqrt2", "linear:N" or "quarters:N"; throws Error.
  static CheckpointLadder parse(const std::string& text);
};

// Limits of a cell: the first one reached ends it.
struct Budget {
  std::optional<double> time_s = {};          // structure, preparation and iterations
  std::optional<std::uint64_t> samples = {};  // iterations
  std::optional<double> error = {};           // relmse to reach
  CheckpointLadder checkpoints = {};

  // So many iterations, measured once, at their end.
  static Budget of_iterations(std::uint64_t count) { return {.samples = count, .checkpoints = {.linear = 1}}; }

  std::string text() const;
  // Share of the budget used up, in [0, 1]; of an error target, where the error is known, as if it fell in proportion to the
  // iterations, as that of unbiased methods does.
  double progress(std::uint64_t iterations, double time_s, std::optional<double> relmse = {}) const;
};

// Decides when a cell ends and when it is measured. Times are those of the cell's own clock, which runs only while the method
// does.
class BudgetSchedule {
 public:
  explicit BudgetSchedule(const Budget& budget);

  // Whether the cell ends here, given how long the last iteration took. A time budget ends before an iteration that would
  // overrun it, predicted by the median of the last three, so that one slow iteration does not end the cell early. The first
  // iteration always runs.
  bool finished(std::uint64_t iterations, double time_s, double last_iteration_s);

  // Whether a rung of the ladder has been reached since the last one; several rungs in one iteration are one checkpoint.
  bool checkpoint_due(std::uint64_t iterations, double time_s);

  // Whether to compare the error with its target: each time the iterations have grown by a tenth. Measuring is off the clock,
  // but not free.
  bool error_due(std::uint64_t iterations);

 private:
  double next_rung(double total, double reached) const;

  Budget budget_;
  double next_iterations_, next_time_;  // infinity where that limit is absent
  std::uint64_t next_error_ = 1;
  std::array<double, 3> lengths_{};  // of the last iterations
};

// The wall's clock; the CPU time of the process, on all of its threads; and that of the calling thread alone, of which what
// else runs on the machine takes no share.
enum class Clock : std::uint8_t { wall, process, thread };
double now_s(Clock clock = Clock::wall);

template <class Work>
double seconds_of(const Work& work, Clock clock = Clock::wall) {
  const double start = now_s(clock);
  work();
  return now_s(clock) - start;
}

// Wall and CPU time of the process, counted only while running.
class RunClock {
 public:
  void start();
  void stop();
  double wall_s() const;  // while running too
  double cpu_s() const;   // user + system, all threads

 private:
  bool running_ = false;
  double wall_ = 0, cpu_ = 0;
  double wall_start_ = 0, cpu_start_ = 0;
};

}  // namespace etendue
