// Output for people at a terminal: narration and a progress bar on stderr, and what errors and interrupts say and exit with;
// stdout is left to data.
#pragma once

#include "experiments/run/run.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace etendue {

// Makes a text fit for a terminal, which obeys control characters: each but the ends of lines and tabs becomes '?'.
std::string printable(std::string text);

// Colours and a bar that redraws itself, only on a terminal; no colours where NO_COLOR is set.
class Console {
 public:
  Console();

  void line(const std::string& text);     // above the bar
  void warning(const std::string& text);  // the same, in yellow
  // One line that replaces itself, at most ten times a second; nothing where stderr is no terminal. What is too wide for the
  // terminal is shortened within its words.
  void status(const std::string& text);
  // Shows as many parts as fit, with what is left of the name behind them (report_text.h).
  void status(const std::vector<std::string>& parts, const std::string& name = "");
  void clear_status();

  bool interactive() const { return interactive_; }
  static std::size_t width();  // of the terminal, columns; 80 where it is unknown
  std::string red(const std::string& text) const { return coloured(text, "31"); }

 private:
  bool is_due();
  void draw(const std::string& text);
  std::string coloured(const std::string& text, const char* code) const;

  bool interactive_ = false, colour_ = false;
  bool shown_ = false;
  double last_ = 0;  // when it was
};

// Starts as many of these threads (default: the machine's) as the system lets this process have; says so where they are fewer.
int available_threads(std::optional<int> asked, Console& console);

std::string progress_bar(double share);                 // "[####      ]"
std::string time_left(double share, double elapsed_s);  // "12 s left", "2:05 left"; "" where too little is done to tell
// "relmse 1.2e-3", "3.4 Mrays/s", "12 tests/ray", "98.7% saved", those that are known.
std::vector<std::string> live_parts(const LiveFigures& figures);

// A bar over all cells with rate and time left, and a line per cell where stderr is no terminal.
class ConsoleRunObserver final : public RunObserver {
 public:
  explicit ConsoleRunObserver(Console& console) : console_(console) {}

  void narrate(const std::string& line) override;
  void status(const std::string& line) override;
  void cell_started(const CellName& cell, std::size_t position, std::size_t count) override;
  void cell_progress(double share, std::uint64_t iterations, double time_s) override;
  void cell_finished(const CellRecord& cell, const CheckpointRecord* last) override;
  bool watches() const override { return console_.interactive(); }
  void cell_live(const LiveFigures& figures) override { figures_ = figures; }

 private:
  void draw(double share, const std::string& rate);

  Console& console_;
  CellName cell_;
  std::size_t position_ = 0, count_ = 0;
  double first_start_ = 0;
  LiveFigures figures_;  // of this cell
};

// Ctrl-C (as SIGTERM) ends the process at once with status 130, after saying `message`. Nothing needs tidying up: only complete
// files carry their final name, and logs are appended in whole blocks.
void exit_on_interrupt(const char* message);

// The first Ctrl-C (as SIGTERM) only says `message`, and interrupted() is true from then on; a second one ends the process as
// above, as does any once exit_on_interrupt is called again. A closed pipe does not end the process either: Ctrl-C in `... 2>&1
// | tee` ends the reader of the messages too.
void note_interrupt(const char* message, const char* second_message);
bool interrupted();

// Runs the program and gives its exit status, or after a message on stderr 2 for bad input (Error) and 1 for what the machine
// refuses: memory, threads, a file, the standard output.
int guarded(const std::function<int()>& program);

}  // namespace etendue
