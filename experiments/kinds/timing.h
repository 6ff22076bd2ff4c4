// Works timed in turns: repetition by repetition, so that changes of the machine's speed meet all of them alike and cancel in
// ratios.
#pragma once

#include "experiments/config/budget.h"
#include "experiments/log/values.h"
#include "framework/core/isa.h"

#include <functional>
#include <span>
#include <vector>

namespace etendue {

// What is built while it lives is built for this instruction set.
class WithIsa {
 public:
  explicit WithIsa(Isa isa) : before_(chosen_isa()) { choose_isa(isa); }
  ~WithIsa() { choose_isa(before_); }
  WithIsa(const WithIsa&) = delete;
  WithIsa& operator=(const WithIsa&) = delete;

 private:
  Isa before_;
};

// Keeps an answer where the compiler must suppose that it is read, so that no query can be left out.
template <class T>
void keep_answer(const T& value) {
  asm volatile("" : : "g"(&value) : "memory");
}

// Does some work and gives the seconds that count.
using TimedWork = std::function<double()>;

template <class Work>
TimedWork timed(Work work, Clock clock = Clock::wall) {
  return [work = std::move(work), clock] { return seconds_of(work, clock); };
}

// The seconds of each work in each repetition, after one warm-up. Works take turns, and each repetition starts with the next
// one. `progress` is told the share that is done.
using Times = std::vector<std::vector<double>>;
Times take_turns(const std::vector<TimedWork>& works, int repetitions, const std::function<void(double share)>& progress = {});

// The median of repetitions with their quartiles; of none, zeros.
Measured summarise(std::span<const double> values);

// a[i] / b[i] for each repetition that both have.
std::vector<double> ratios(std::span<const double> a, std::span<const double> b);

}  // namespace etendue
