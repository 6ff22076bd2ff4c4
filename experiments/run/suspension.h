// How often the process was stopped and went on: by Ctrl-Z, SIGSTOP, or a batch system that lends its processor to another job.
// Clocks run on meanwhile, so that what was timed then is not to be believed.
#pragma once

namespace etendue {

// Counts from now on. SIGCONT is what tells; a stop itself cannot be seen.
void count_suspensions();
int suspensions();

}  // namespace etendue
