// The manual page etendue(1) in roff, from the table of commands.
#include "experiments/command/commands.h"
#include "experiments/log/log.h"

#include <fmt/format.h>

namespace etendue {

namespace {

// Text in which nothing means anything to roff.
std::string roff(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if (c == '\'')
      out += "\\(aq";
    else if (c == '`')
      out += "\\(ga";
    else if (text.substr(i).starts_with("…")) {
      out += "...";
      i += std::string_view("…").size() - 1;
    } else
      out += c;
  }
  if (out.starts_with('.')) out.insert(0, "\\&");
  return out;
}

std::string option_entry(const OptionRow& option) {
  std::string head = joined(option.names, ", ", [](const std::string& name) { return "\\fB" + roff(name) + "\\fR"; });
  if (!option.positional.empty()) head = "\\fI" + roff(option.positional) + "\\fR" + (option.many ? " ..." : "");
  if (!option.value.empty()) head += " \\fI" + roff(option.value) + "\\fR";
  return fmt::format(".TP\n{}\n{}\n", head, roff(option.help));
}

std::string synopsis(const CommandRow& command) {
  std::string line = "\\fBetendue " + roff(command.name) + "\\fR";
  for (const OptionRow& option : command.options)
    if (!option.positional.empty()) {
      const std::string name = "\\fI" + roff(option.positional) + "\\fR" + (option.many ? " ..." : "");
      line += option.required ? " " + name : " [" + name + "]";
    }
  return line + " [\\fIoptions\\fR]";
}

}  // namespace

int man_command(const CommandTable& table) {
  std::string text = fmt::format(".TH ETENDUE 1 \"\" \"{}\" \"User Commands\"\n", roff(version_text()));
  text += ".SH NAME\netendue \\- a laboratory for photon mapping and radiance caching\n.SH SYNOPSIS\n.nf\n";
  for (const CommandRow& command : table) text += synopsis(command) + "\n";
  text +=
      ".fi\n.SH DESCRIPTION\nRuns experiments over scenes, acceleration structures, integrators and seeds, logs error and time "
      "as each converges, and makes tables, charts and a page of the log. Data goes to the standard output, narration to the "
      "standard error.\n.SH COMMANDS\n";
  for (const CommandRow& command : table) {
    text += fmt::format(".SS {}\n{}.\n.PP\n{}\n", roff(command.name), roff(command.what), synopsis(command));
    for (const OptionRow& option : command.options)
      if (option.names.empty() || option.names.back() != "--help") text += option_entry(option);
  }
  text += R"(.SH EXIT STATUS
.TP
0
Done.
.TP
1
A cell failed, a gate tripped, or the machine refused memory or a file.
.TP
2
The usage, the experiment or the scene is wrong; the message says where and what was expected.
.TP
130
Interrupted; the same command of \fBrun\fR goes on from there.
.SH ENVIRONMENT
.TP
NO_COLOR
Where it is set, nothing is coloured.
.TP
XDG_CACHE_HOME
References are kept in etendue below it, else below ~/.cache.
.TP
SLURM_ARRAY_TASK_ID
The part that \fB\-\-shard\fR takes where none is named.
.SH EXAMPLES
.nf
etendue run experiments/first\-light.toml
etendue render builtin:cornell\-box \-i sppm \-\-time 30s \-o box.exr
etendue list sppm
.fi
)";
  fmt::print("{}", text);
  return 0;
}

}  // namespace etendue
