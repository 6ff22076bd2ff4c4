// The commands and options of the program as data, from which completion and the manual page are generated.
#pragma once

#include <string>
#include <vector>

namespace etendue {

struct OptionRow {
  std::vector<std::string> names;  // "-o", "--out"; empty: positional
  std::string value;               // what follows it ("N"); empty: a flag, or positional
  std::string help;
  std::string positional = {};  // "SCENE"
  bool required = false, many = false;
};

struct CommandRow {
  std::string name, what;
  std::vector<OptionRow> options;
};

using CommandTable = std::vector<CommandRow>;

// Print on stdout the completion of "bash" or "zsh" (else throws Error), and the manual page (roff).
int completion_command(const std::string& shell, const CommandTable& table);
int man_command(const CommandTable& table);

}  // namespace etendue
