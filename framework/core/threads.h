// How many threads the system lets this process have.
#pragma once

namespace etendue {

// Starts the threads that parallel loops on `wanted` threads will need, at least one of which is the caller's own, while there
// is room for them: a thread that cannot be started later, in the middle of a loop, would end the process. Returns how many
// there are, fewer than wanted where the system (address space, number of processes) refuses more, and from then on no loop
// uses more.
int start_threads(int wanted);

}  // namespace etendue
