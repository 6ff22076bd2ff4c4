// Completion for bash and zsh: the commands and options of the table, and the names that this program knows. Files of
// experiments and scenes are looked for when a key is pressed.
#include "experiments/command/commands.h"
#include "experiments/report/aov.h"
#include "experiments/report/report_text.h"

#include <fmt/format.h>
#include <algorithm>

namespace etendue {

namespace {

constexpr const char* scene_files = "pbrt xml obj ply smf";

// Lists what may stand in one place of the command line.
struct Candidates {
  std::vector<std::string> names = {};
  std::string endings = {};       // of files, "pbrt xml"; "*": any file, "/": directories
  bool experiment_names = false;  // of experiments/*.toml in the working directory
};

Candidates scenes() { return {.names = listed_names("scenes"), .endings = scene_files}; }

// Finds them by the names that the table gives to options, to values and to what stands without an option.
Candidates candidates_for(const OptionRow& option) {
  const auto is = [&](std::string_view name) { return option.positional == name || contains(option.names, name); };
  if (is("SCENE")) return scenes();
  if (is("EXPERIMENT")) return {.endings = "toml", .experiment_names = true};
  if (is("NAMES")) return {.experiment_names = true};
  if (is("WHAT")) return {.names = listed_names("")};
  if (is("SHELL")) return {.names = {"bash", "zsh"}};
  if (is("--integrator")) return {.names = listed_names("integrators")};
  if (is("--accel") || is("--structures")) return {.names = listed_names("accels")};
  if (is("--isa")) return {.names = {"sse", "avx2", "avx512"}};
  if (is("--aov")) return {.names = aov_names()};
  if (is("DIR") || option.value == "DIR") return {.endings = "/"};
  if (!option.positional.empty() || option.value.starts_with("FILE") || option.value.starts_with("IMAGE"))
    return {.endings = "*"};
  return {};
}

// --- bash ---

std::string bash_reply(const Candidates& of) {
  std::string reply;
  if (!of.names.empty()) reply += fmt::format(" _etendue_words \"{}\";", joined(of.names, " "));
  if (of.experiment_names) reply += " _etendue_words \"$(_etendue_experiments)\";";
  if (of.endings == "/")
    reply += " _etendue_files -d;";
  else if (of.endings == "*")
    reply += " _etendue_files -f;";
  else if (!of.endings.empty())
    reply += fmt::format(" _etendue_files -f \"{}\";", of.endings);
  return reply;
}

std::string bash_command(const CommandRow& command) {
  std::string options, values, positional;
  for (const OptionRow& option : command.options) {
    for (const std::string& name : option.names) options += " " + name;
    const std::string reply = bash_reply(candidates_for(option));
    if (option.names.empty())
      positional += reply;
    else if (!option.value.empty())  // one without candidates completes nothing
      values += fmt::format("      {}) {} return ;;\n", fmt::join(option.names, "|"), reply);
  }
  return fmt::format(
      "  {})\n    case \"$previous\" in\n{}    esac\n    if [[ $current == -* ]]; then _etendue_words \"{}\"; else{} :; fi "
      ";;\n",
      command.name, values, options.substr(1), positional);
}

// Words that bash splits at colons are put together again: names of scenes have one.
constexpr const char* bash_head = R"(# bash completion for etendue, written by `etendue completion bash`
_etendue_words() { COMPREPLY+=($(compgen -W "$1" -- "$current")); }
_etendue_experiments() { local file; for file in experiments/*.toml; do [[ -e $file ]] && file=${file##*/} && echo "${file%.toml}"; done; }
_etendue_files() {
  local file ending
  while IFS= read -r file; do
    if [[ -d $file ]]; then COMPREPLY+=("$file/"); continue; fi
    if [[ -z ${2-} ]]; then COMPREPLY+=("$file"); continue; fi
    for ending in $2; do [[ $file == *."$ending" ]] && COMPREPLY+=("$file"); done
  done < <(compgen "$1" -- "$current")
  [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == */ ]] && compopt -o nospace 2>/dev/null
}
_etendue() {
  local line=${COMP_LINE:0:COMP_POINT} current previous command word words
  read -ra words <<< "$line"
  current=${line##*[[:space:]]}
  [[ -n $current ]] && unset 'words[${#words[@]}-1]'
  previous=${words[${#words[@]}-1]}
  for word in "${words[@]:1}"; do [[ $word != -* ]] && command=$word && break; done
  COMPREPLY=()
  case "$command" in
)";
constexpr const char* bash_tail = R"(  esac
  if [[ $current == *:* && $COMP_WORDBREAKS == *:* ]]; then
    local prefix=${current%"${current##*:}"}
    COMPREPLY=("${COMPREPLY[@]#"$prefix"}")
  fi
}
complete -F _etendue etendue
)";

std::string bash_script(const CommandTable& table) {
  std::string names, text = bash_head;
  for (const CommandRow& command : table) names += command.name + " ";
  text += fmt::format("  \"\") _etendue_words \"{}--help --version\" ;;\n", names);
  for (const CommandRow& command : table) text += bash_command(command);
  return text + bash_tail;
}

// --- zsh ---

// A word or a text within single quotes, in which brackets and colons mean nothing to _arguments.
std::string zsh_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
    out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  }
  return out;
}

// The function that completes a place, and its definition.
std::string zsh_action(const Candidates& of, const std::string& function, std::string& definitions) {
  std::string body;
  if (!of.names.empty()) body += "  compadd -- '" + joined(of.names, "' '") + "'\n";
  if (of.experiment_names) body += "  local -a files=(experiments/*.toml(N:t:r)); compadd -a files\n";
  if (of.endings == "/")
    body += "  _files -/\n";
  else if (of.endings == "*")
    body += "  _files\n";
  else if (!of.endings.empty()) {
    std::string endings = of.endings;
    std::ranges::replace(endings, ' ', '|');
    body += fmt::format("  _files -g '*.({})'\n", endings);
  }
  if (body.empty()) return " ";
  definitions += fmt::format("{}() {{\n{}}}\n", function, body);
  return function;
}

std::string zsh_command(const CommandRow& command, std::string& definitions) {
  std::string specs;
  for (const OptionRow& option : command.options) {
    std::string function = "_etendue_" + command.name + "_";
    for (const char c : option.names.empty() ? option.positional : option.names.back()) function += c == '-' ? '_' : c;
    const std::string action = zsh_action(candidates_for(option), function, definitions);
    if (option.names.empty()) {
      specs += fmt::format(" \\\n        '{}:{}:{}'", option.many ? "*" : "", zsh_text(option.positional), action);
      continue;
    }
    for (const std::string& name : option.names)
      specs += fmt::format(" \\\n        '*{}[{}]{}'", name, zsh_text(shortened(option.help, 60)),
                           option.value.empty() ? "" : fmt::format(":{}:{}", zsh_text(option.value), action));
  }
  return fmt::format("      {})\n        _arguments -s{} ;;\n", command.name, specs);
}

std::string zsh_script(const CommandTable& table) {
  std::string definitions, names, cases;
  for (const CommandRow& command : table) {
    names += fmt::format("    '{}:{}'\n", command.name, zsh_text(command.what));
    cases += zsh_command(command, definitions);
  }
  return fmt::format(R"(#compdef etendue
# zsh completion for etendue, written by `etendue completion zsh`
{}_etendue() {{
  local curcontext="$curcontext" state line
  local -a commands=(
{}  )
  _arguments -C '1: :->command' '*:: :->rest'
  case $state in
    command) _describe command commands ;;
    rest) case $line[1] in
{}    esac ;;
  esac
}}
if [ "$funcstack[1]" = _etendue ]; then _etendue "$@"; else compdef _etendue etendue; fi
)",
                     definitions, names, cases);
}

}  // namespace

int completion_command(const std::string& shell, const CommandTable& table) {
  require_name({"completion"}, "shell", shell, std::vector<std::string>{"bash", "zsh"});
  fmt::print("{}", shell == "bash" ? bash_script(table) : zsh_script(table));
  return 0;
}

}  // namespace etendue
