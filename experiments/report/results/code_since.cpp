#include "experiments/report/results/code_since.h"

#include "experiments/report/report_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

namespace etendue {

std::optional<std::string> output_of(const std::vector<std::string>& command) {
  std::string line;
  for (const std::string& word : command) line += shell_word(word) + " ";
  FILE* const pipe = popen((line + "2>/dev/null").c_str(), "re");
  if (pipe == nullptr) return std::nullopt;
  std::string text;
  for (int c; (c = std::fgetc(pipe)) != EOF;) text += static_cast<char>(c);
  return pclose(pipe) == 0 ? std::optional(text) : std::nullopt;
}

std::string code_since(const std::string& root, const std::string& commit, const std::vector<std::string>& paths) {
  const std::string unknown = "not known";
  if (commit.empty() || commit.find_first_not_of("0123456789abcdef") != std::string::npos) return unknown;
  std::vector<std::string> command{"git", "-C", root, "log", "--format=%cs", commit + "..HEAD", "--"};
  command.insert(command.end(), paths.begin(), paths.end());
  const std::optional<std::string> dates = output_of(command);
  if (!dates) return unknown;
  const auto commits = static_cast<std::size_t>(std::ranges::count(*dates, '\n'));
  return commits == 0 ? "unchanged"
                      : fmt::format("{}, the last of {}", counted(commits, "commit"), dates->substr(0, dates->find('\n')));
}

}  // namespace etendue
