#include "experiments/run/suspension.h"

#include <atomic>
#include <csignal>

namespace etendue {

namespace {

std::atomic<int> continued{0};
static_assert(std::atomic<int>::is_always_lock_free);  // a signal's handler may wait for nobody

}  // namespace

void count_suspensions() {
  struct sigaction action {};
  action.sa_handler = [](int) { ++continued; };
  action.sa_flags = SA_RESTART;
  sigaction(SIGCONT, &action, nullptr);
}

int suspensions() { return continued; }

}  // namespace etendue
