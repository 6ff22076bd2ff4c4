// Completion, the manual page, and what `cmake --install` puts where.
#include "tests/unit/harness_process.h"

#include <cstdlib>
#include <regex>
#include <set>
#include <sstream>

namespace etendue {
namespace {

class Installed : public ProgramTest {
 protected:
  // The output of a shell that runs the script in the test's directory.
  std::string printed(const std::string& shell, const std::string& script) {
    write_file("script", script);
    const std::string command = "cd '" + directory_.string() + "' && " + shell + " ./script >printed 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0) << read_text_file(directory_ / "printed");
    return read_text_file(directory_ / "printed");
  }
  // The candidates that bash has for a line, a line each.
  std::string completed(const std::string& line) {
    write_file("etendue.bash", run({"completion", "bash"}).out);
    return printed("bash", "source etendue.bash\nCOMP_WORDBREAKS=' :='\nCOMP_LINE='" + line +
                               "'\nCOMP_POINT=${#COMP_LINE}\n_etendue\n" + "printf '%s\\n' \"${COMPREPLY[@]}\"\n");
  }
};

TEST_F(Installed, BashCompletesCommandsOptionsAndNames) {
  EXPECT_EQ(completed("etendue re"), "render\nreport\nresults\n");
  EXPECT_EQ(completed("etendue render --integ"), "--integrator\n");
  EXPECT_EQ(completed("etendue render -i irr"), "irradiance-cache\n");
  EXPECT_EQ(completed("etendue render builtin:cornell-box --accel bin"), "binned-sah\n");
  EXPECT_EQ(completed("etendue render builtin:lambert"), "lambert-sphere\nlambert-sphere-off-centre\n")
      << "bash takes a colon for the end of a word";
  EXPECT_EQ(completed("etendue list spp"), "sppm\n");
  write_file("room.pbrt", "");
  write_file("notes.txt", "");
  std::filesystem::create_directories(directory_ / "experiments");
  write_file("experiments/first.toml", "");
  EXPECT_EQ(completed("etendue inspect ro"), "room.pbrt\n");
  EXPECT_EQ(completed("etendue inspect no"), "\n");
  EXPECT_EQ(completed("etendue run --out ex"), "experiments/\n");
  EXPECT_EQ(completed("etendue run fi"), "first\n");
  EXPECT_EQ(completed("etendue run experiments/"), "experiments/first.toml\n");
}

// Each option that the help of a command shows is in both scripts and in the manual page.
TEST_F(Installed, CompletionAndManualHaveEachOption) {
  const std::string bash = run({"completion", "bash"}).out, zsh = run({"completion", "zsh"}).out, man = run({"man"}).out;
  const std::regex command_line("^  ([a-z]+)  "), option(R"((^|[ ,])(--[a-z][a-z-]*))");
  std::istringstream help(run({"--help"}).out);
  int commands = 0;
  for (std::string line; std::getline(help, line);) {
    std::smatch name;
    if (!std::regex_search(line, name, command_line)) continue;
    ++commands;
    const std::string command = name[1];
    EXPECT_NE(bash.find("  " + command + ")\n"), std::string::npos) << command;
    EXPECT_NE(zsh.find("    '" + command + ":"), std::string::npos) << command;
    EXPECT_NE(man.find(".SS " + command + "\n"), std::string::npos) << command;
    std::istringstream options(run({command, "--help"}).out);
    for (std::string text; std::getline(options, text);)
      if (std::smatch found; text.starts_with("  -") && std::regex_search(text, found, option)) {
        const std::string flag = found[2];
        EXPECT_NE(bash.find(" " + flag), std::string::npos) << command << flag;
        EXPECT_NE(zsh.find("'*" + flag + "["), std::string::npos) << command << flag;
        const bool in_manual = man.find(std::regex_replace(flag, std::regex("-"), "\\-")) != std::string::npos;
        EXPECT_EQ(in_manual, flag != "--help") << command << flag;
      }
  }
  EXPECT_GE(commands, 12);
}

TEST_F(Installed, ZshTakesItsScript) {
  if (!is_installed("zsh")) GTEST_SKIP() << "zsh is not installed";
  write_file("_etendue", run({"completion", "zsh"}).out);
  EXPECT_EQ(printed("zsh -f", "autoload -U compinit; compinit -u -D; source ./_etendue; print $_comps[etendue]"), "_etendue\n");
}

TEST_F(Installed, ManualIsSoundRoff) {
  if (!is_installed("groff")) GTEST_SKIP() << "groff is not installed";
  write_file("etendue.1", run({"man"}).out);
  EXPECT_EQ(printed("bash", "groff -man -Tutf8 -ww -z etendue.1"), "");
}

TEST_F(Installed, ProgramRunsFromItsPrefix) {
  if (!is_installed("cmake")) GTEST_SKIP() << "cmake is not installed";
  const std::string build = std::filesystem::path(program_path).parent_path().string();
  printed("bash", "cmake --install '" + build + "' --prefix \"$PWD/prefix\" >log 2>&1 || { cat log; exit 1; }");
  for (const char* file : {"bin/etendue", "share/bash-completion/completions/etendue", "share/zsh/site-functions/_etendue",
                           "share/man/man1/etendue.1", "share/doc/etendue/README.md", "share/doc/etendue/docs/using.md",
                           "share/etendue/experiments/first-light.toml"})
    EXPECT_GT(std::filesystem::file_size(directory_ / "prefix" / file), 500u) << file;
  EXPECT_NE(printed("bash", "prefix/bin/etendue run first-light --dry-run").find("cells, "), std::string::npos);
  EXPECT_NE(printed("bash", "prefix/bin/etendue stress --dry-run").find("cells, "), std::string::npos);
  EXPECT_NE(printed("bash", "prefix/bin/etendue render builtin:furnace --spp 1 --resolution 8x8").find("image "),
            std::string::npos);
}

}  // namespace
}  // namespace etendue
