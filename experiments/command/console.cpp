#include "experiments/command/console.h"

#include "experiments/report/report_text.h"
#include "experiments/run/suspension.h"
#include "framework/core/counters.h"
#include "framework/core/error.h"
#include "framework/core/parallel.h"
#include "framework/core/threads.h"
#include "framework/core/units.h"
#include "framework/io/whole_file.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>

namespace etendue {
namespace {

// Any thread may be the one that is interrupted, by several interrupts at once.
std::atomic<const char*> interrupt_message = "", exit_message = "";  // of the first interrupt, and of later ones
std::atomic<int> interrupts = 0, harmless_interrupts = 0;            // that came; the first so many do not end the process
static_assert(decltype(exit_message)::is_always_lock_free && decltype(interrupts)::is_always_lock_free);

void handle_interrupt(int) {
  // A signal handler makes only calls that are safe there, and leaves no trace of them in the code that goes on.
  const int interrupted_errno = errno;
  const int earlier = interrupts.fetch_add(1);
  const char* const message = earlier == 0 ? interrupt_message : exit_message;
  [[maybe_unused]] const auto written = write(STDERR_FILENO, message, std::strlen(message));
  if (earlier >= harmless_interrupts) _exit(130);
  errno = interrupted_errno;
}

void handle_interrupts() {
  for (const int signal : {SIGINT, SIGTERM}) {  // the latter from batch systems whose time is over
    struct sigaction current {};
    sigaction(signal, nullptr, &current);
    if (current.sa_handler == SIG_IGN) continue;  // started with nohup, or in a script's background
    struct sigaction action {};
    action.sa_handler = handle_interrupt;
    action.sa_flags = SA_RESTART;
    sigaction(signal, &action, nullptr);
  }
}

}  // namespace

std::string printable(std::string text) {
  for (char& c : text)
    if ((static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') || c == 0x7f) c = '?';
  return text;
}

Console::Console() {
  const char* term = std::getenv("TERM");
  const char* no_color = std::getenv("NO_COLOR");
  interactive_ = isatty(STDERR_FILENO) && !(term && std::strcmp(term, "dumb") == 0);
  colour_ = interactive_ && !(no_color && *no_color);
}

std::string Console::coloured(const std::string& text, const char* code) const {
  return colour_ ? fmt::format("\x1b[{}m{}\x1b[0m", code, text) : text;
}

void Console::line(const std::string& text) {
  clear_status();
  std::fflush(stdout);  // both may go to one file
  std::fprintf(stderr, "%s\n", text.c_str());
}

void Console::warning(const std::string& text) { line(coloured("warning: ", "33") + printable(text)); }

std::size_t Console::width() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

bool Console::is_due() { return interactive_ && !(shown_ && now_s() - last_ < 0.1); }

void Console::draw(const std::string& text) {
  last_ = now_s();
  shown_ = true;
  std::fprintf(stderr, "\r%s\x1b[K", text.c_str());
  std::fflush(stderr);
}

// The last column stays free: a terminal would wrap there, and leave lines behind.
void Console::status(const std::string& text) {
  if (is_due()) draw(fitted(text, width() - 1));
}

void Console::status(const std::vector<std::string>& parts, const std::string& name) {
  if (is_due()) draw(status_line(parts, name, width() - 1));
}

void Console::clear_status() {
  if (shown_) std::fputs("\r\x1b[K", stderr);
  shown_ = false;
}

int available_threads(std::optional<int> asked, Console& console) {
  const int wanted = asked.value_or(hardware_threads());
  const int threads = start_threads(wanted);
  if (threads < wanted)
    console.warning(fmt::format("the system lets this program have {} of {} threads: it goes on with those", threads, wanted));
  return threads;
}

std::string time_left(double share, double elapsed_s) {
  if (share < 0.002) return "";
  const auto left = std::llround(elapsed_s * (1 - share) / share);
  if (left < 60) return fmt::format("{} s left", left);
  if (left < 3600) return fmt::format("{}:{:02} left", left / 60, left % 60);
  return fmt::format("{}:{:02}:{:02} left", left / 3600, left / 60 % 60, left % 60);
}

std::string progress_bar(double share) {
  constexpr std::size_t places = 10;
  const auto full = static_cast<std::size_t>(std::clamp(share, 0.0, 1.0) * places);
  return "[" + std::string(full, '#') + std::string(places - full, ' ') + "]";
}

std::vector<std::string> live_parts(const LiveFigures& figures) {
  std::vector<std::string> parts;
  if (figures.error && std::isfinite(*figures.error)) parts.push_back("relmse " + format_figure(*figures.error, 2));
  if (figures.rays_per_s > 0) parts.push_back(format_figure(figures.rays_per_s / 1e6) + " Mrays/s");
  if (figures.tests_per_ray) parts.push_back(format_figure(*figures.tests_per_ray) + " tests/ray");
  if (figures.tests_saved) parts.push_back(fmt::format("{:.1f}% saved", std::min(99.9, 100 * *figures.tests_saved)));
  return parts;
}

void ConsoleRunObserver::narrate(const std::string& line) { console_.line(line); }
void ConsoleRunObserver::status(const std::string& line) { console_.status(line); }

void ConsoleRunObserver::cell_started(const CellName& cell, std::size_t position, std::size_t count) {
  if (position == 0) first_start_ = now_s();
  cell_ = cell;
  position_ = position;
  count_ = count;
  figures_ = {};
  draw(0, "");
}

void ConsoleRunObserver::cell_progress(double share, std::uint64_t iterations, double time_s) {
  draw(share, time_s > 0 ? fmt::format("{:.3g} iterations/s", static_cast<double>(iterations) / time_s) : "");
}

void ConsoleRunObserver::draw(double share, const std::string& rate) {
  const double all = (static_cast<double>(position_) + share) / static_cast<double>(count_);
  const double elapsed = now_s() - first_start_;
  std::vector<std::string> parts;
  if (Console::width() >= 100) parts.push_back(progress_bar(all));
  parts.push_back(fmt::format("{}/{}", position_ + 1, count_));
  parts.push_back(time_left(all, elapsed));
  for (std::string& part : live_parts(figures_)) parts.push_back(std::move(part));
  parts.push_back(rate);
  console_.status(parts, cell_.key());
}

void ConsoleRunObserver::cell_finished(const CellRecord& cell, const CheckpointRecord* last) {
  const std::string head = fmt::format("[{}/{}] {}: ", position_ + 1, count_, cell.cell.key());
  if (!last) {
    console_.line(head + console_.red("failed: ") + cell.error);
    return;
  }
  const auto error = find_value(last->metrics, "relmse");
  if (console_.interactive())
    draw(1, "");
  else
    console_.line(fmt::format("{}{}{}, {}", head, error ? fmt::format("relmse {:.3g}, ", *error) : "",
                              counted(last->iterations, "iteration"), format_seconds(last->time_s)));
}

void exit_on_interrupt(const char* message) {
  harmless_interrupts = 0;
  interrupt_message = message;
  exit_message = message;
  handle_interrupts();
}

void note_interrupt(const char* message, const char* second_message) {
  harmless_interrupts = 1;
  interrupt_message = message;
  exit_message = second_message;
  handle_interrupts();
  std::signal(SIGPIPE, SIG_IGN);
}

bool interrupted() { return interrupts > 0; }

namespace {

// Serves where an exception cannot pass, as when memory or a thread is refused in the middle of a library.
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
  count_suspensions();
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
