#include "experiments/command/guard.h"

#include "experiments/command/console.h"
#include "framework/core/counters.h"
#include "framework/core/error.h"
#include "framework/core/memory.h"
#include "framework/core/parallel.h"
#include "framework/core/threads.h"
#include "framework/core/units.h"
#include "framework/io/whole_file.h"

#include <unistd.h>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>

namespace etendue {

namespace {

// Where an exception cannot pass: memory or a thread that is refused in the middle of a library.
[[noreturn]] void end_cleanly() {
  const auto end = [](const char* what) {
    for (const char* part : {"error: ", what, "; expected a smaller scene, image or number of photons, or more memory\n"})
      if (write(STDERR_FILENO, part, std::strlen(part)) < 0) break;
    _exit(1);
  };
  try {
    if (const auto current = std::current_exception()) std::rethrow_exception(current);
  } catch (const std::bad_alloc&) {
    end("out of memory");
  } catch (const std::exception& e) {
    end(e.what());
  } catch (...) {
  }
  std::abort();  // a mistake of the program
}

}  // namespace

int guarded(const std::function<int()>& program) {
  std::set_terminate(end_cleanly);
  std::signal(SIGXFSZ, SIG_IGN);  // too large a file is an error of the write then
  try {
    start_threads(hardware_threads());  // before memory is taken
    const int status = program();
    if (std::fflush(stdout) != 0 || std::ferror(stdout)) throw std::runtime_error("cannot write to the standard output");
    return status;
  } catch (const WriteError& e) {
    std::fprintf(stderr, "error: %s\n", printable(e.what()).c_str());
  } catch (const Error& e) {
    std::fprintf(stderr, "error: %s\n", printable(e.what()).c_str());
    return 2;
  } catch (const std::bad_alloc&) {
    const std::string taken = format_bytes(static_cast<double>(peak_memory_bytes()));
    std::fprintf(stderr, "error: out of memory, with %s taken; expected a smaller scene, image or number of photons\n",
                 taken.c_str());
  } catch (const std::exception& e) {
    std::fprintf(stderr, "error: %s\n", printable(e.what()).c_str());
  }
  return 1;
}

}  // namespace etendue
