#include "experiments/report/results/code_since.h"

#include "experiments/report/report_text.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>

namespace etendue {

namespace {

std::string read_to_end(int descriptor) {
  std::string text;
  std::array<char, 4096> buffer;
  for (ssize_t count; (count = read(descriptor, buffer.data(), buffer.size())) > 0;)
    text.append(buffer.data(), static_cast<std::size_t>(count));
  return text;
}

}  // namespace

std::optional<std::string> output_of(const std::vector<std::string>& command) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return std::nullopt;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  std::vector<char*> arguments;
  for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  pid_t child = 0;
  const bool started = posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ) == 0;
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  std::string text = started ? read_to_end(ends[0]) : "";
  close(ends[0]);
  int status = 0;
  if (!started || waitpid(child, &status, 0) != child || !WIFEXITED(status) || WEXITSTATUS(status) != 0) return std::nullopt;
  return text;
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
