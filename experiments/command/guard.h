// Where errors of the program become messages and exit statuses.
#pragma once

#include <functional>

namespace etendue {

// Runs the program and gives its exit status, or after a message on stderr 2 for bad input (Error) and 1 for what the machine
// refuses: memory, threads, a file, the standard output.
int guarded(const std::function<int()>& program);

}  // namespace etendue
