#include "experiments/command/console.h"

#include "experiments/report/report_text.h"
#include "framework/core/parallel.h"
#include "framework/core/threads.h"
#include "framework/core/units.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace etendue {

namespace {

std::size_t terminal_width() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

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
  std::fprintf(stderr, "%s\n", text.c_str());
}

void Console::warning(const std::string& text) { line(coloured("warning: ", "33") + text); }

void Console::status(const std::string& text) {
  if (!interactive_ || (shown_ && now_s() - last_ < 0.1)) return;
  last_ = now_s();
  shown_ = true;
  // Cut to the terminal, lest it wrap and leave lines behind. All of it is ASCII but names, which may be cut early.
  std::fprintf(stderr, "\r%s\x1b[K", text.substr(0, terminal_width() - 1).c_str());
  std::fflush(stderr);
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

std::string progress_bar(double share, int width) {
  const int full = static_cast<int>(std::clamp(share, 0.0, 1.0) * width);
  return "[" + std::string(static_cast<std::size_t>(full), '#') + std::string(static_cast<std::size_t>(width - full), ' ') +
         "]";
}

void ConsoleRunObserver::narrate(const std::string& line) { console_.line(line); }
void ConsoleRunObserver::status(const std::string& line) { console_.status(line); }

void ConsoleRunObserver::cell_started(const CellName& cell, std::size_t position, std::size_t count) {
  if (position == 0) first_start_ = now_s();
  cell_ = cell;
  position_ = position;
  count_ = count;
  draw(0, "");
}

void ConsoleRunObserver::cell_progress(double share, std::uint64_t iterations, double time_s) {
  draw(share, time_s > 0 ? fmt::format("{:.3g} iterations/s, ", static_cast<double>(iterations) / time_s) : "");
}

void ConsoleRunObserver::draw(double share, const std::string& rate) {
  const double all = (static_cast<double>(position_) + share) / static_cast<double>(count_);
  const double elapsed = now_s() - first_start_;
  const std::string left = all > 0.002 ? format_seconds(elapsed * (1 - all) / all) + " left" : "";
  console_.status(fmt::format("{} {}/{} {}{}  {}", progress_bar(all, 24), position_ + 1, count_, rate, left, cell_.key()));
}

void ConsoleRunObserver::cell_finished(const CellRecord& cell, const CheckpointRecord* last) {
  const std::string head = fmt::format("[{}/{}] {}: ", position_ + 1, count_, cell.cell.key());
  if (!last) {
    console_.line(head + console_.red("failed: ") + cell.error);
    return;
  }
  const auto error = last->metrics.find("relmse");
  if (console_.interactive())
    draw(1, "");
  else
    console_.line(fmt::format("{}{}{}, {}", head,
                              error == last->metrics.end() ? "" : fmt::format("relmse {:.3g}, ", error->second),
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

}  // namespace etendue
