// The terminal as people see it: a line that fits it, with what the render does meanwhile, and answers to what they mistype.
#include "experiments/report/report_text.h"
#include "tests/unit/harness_process.h"

#include <pty.h>

#include <cmath>
#include <sstream>

namespace etendue {
namespace {

TEST(StatusLine, ShortensNamesInTheirMiddleAndNoNumber) {
  EXPECT_EQ(shortened_in_middle("abcdefghij", 5), "ab…ij");
  EXPECT_EQ(shortened_in_middle("äöüßäöüß", 4), "äö…ß");
  EXPECT_EQ(shortened_in_middle("abc", 3), "abc");
  EXPECT_EQ(fitted("scenes/a-very-long-folder/of-scenes/room.pbrt: 12345 of 67890 rays", 50),
            "scenes/a-very-l…nes/room.pbrt: 12345 of 67890 rays");
  EXPECT_EQ(fitted("one two three 1234567 eight nine", 23), "one two three 1234567");
  EXPECT_LE(display_width(fitted(std::string(300, 'x'), 20)), 20u);
}

TEST(StatusLine, HasThePartsThatFitAndWhatIsLeftOfTheName) {
  const std::vector<std::string> parts{"37%", "", "3/12", "12 s left", "34 Mrays/s"};
  EXPECT_EQ(status_line(parts, "", 80), "37%  3/12  12 s left  34 Mrays/s");
  EXPECT_EQ(status_line(parts, "", 25), "37%  3/12  12 s left");
  EXPECT_EQ(status_line(parts, "builtin:cornell-box | path", 48), "37%  3/12  12 s left  34 Mrays/s  builtin…| path");
  EXPECT_EQ(status_line(parts, "builtin:cornell-box | path", 36), "37%  3/12  12 s left  34 Mrays/s");
}

class AtTerminal : public ProgramTest {
 protected:
  // Everything that the program writes to a terminal of so many columns.
  std::string shown(const std::vector<std::string>& arguments, unsigned short columns) {
    const winsize size{.ws_row = 24, .ws_col = columns, .ws_xpixel = 0, .ws_ypixel = 0};
    int master = -1;
    const pid_t pid = forkpty(&master, nullptr, nullptr, &size);
    if (pid == 0) {
      std::filesystem::current_path(directory_);
      setenv("XDG_CACHE_HOME", (directory_ / "cache").c_str(), 1);
      setenv("TERM", "xterm", 1);
      std::vector<char*> argv{const_cast<char*>("etendue")};
      for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
      argv.push_back(nullptr);
      execv(program_path, argv.data());
      _exit(127);
    }
    std::string text;
    char buffer[4096];
    for (ssize_t got; (got = read(master, buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(got));
    close(master);
    waitpid(pid, &status_, 0);
    return text;
  }
  // The lines that replace one another: between the carriage return and what clears the rest.
  static std::vector<std::string> status_lines(const std::string& text) {
    std::vector<std::string> lines;
    for (std::size_t end = text.find("\x1b[K"); end != std::string::npos; end = text.find("\x1b[K", end + 1)) {
      const std::size_t begin = text.rfind('\r', end);
      if (begin != std::string::npos && end > begin + 1) lines.push_back(text.substr(begin + 1, end - begin - 1));
    }
    return lines;
  }
  int status_ = -1;
};

TEST_F(AtTerminal, ARenderTellsItsWorkErrorAndTimeLeftIn80Columns) {
  const std::string text = shown({"render", "builtin:lambert-sphere", "--resolution", "24x24", "--error", "1e-9", "--time",
                                  "0.5", "--threads", "1", "-o", "a.png"},
                                 80);
  const std::vector<std::string> lines = status_lines(text);
  ASSERT_FALSE(lines.empty()) << text;
  for (const std::string& line : lines) EXPECT_LT(display_width(line), 80u) << line;
  for (const char* part : {"% ", " left", "relmse ", "Mrays/s", "tests/ray", "% saved"})
    EXPECT_NE(lines.back().find(part), std::string::npos) << part << " in " << lines.back();
}

// The image is that of a render that nobody watches.
TEST_F(AtTerminal, WatchingChangesNoBit) {
  const auto hash_in = [](const std::string& text) { return text.substr(text.find("hash        "), 28); };
  const std::vector<std::string> command{
      "render", "builtin:cornell-spheres", "--resolution", "32x32", "--spp", "40", "--threads", "1", "-i", "vcm", "-o",
      "a.png"};
  EXPECT_EQ(hash_in(shown(command, 80)), hash_in(run(command).out));
}

TEST_F(AtTerminal, ARunFitsNarrowAndWideOnes) {
  write_file("e.toml",
             "scenes = [\"builtin:lambert-sphere\"]\nbudget = { time = 0.25 }\nresolution = [16, 16]\n"
             "integrators = [{ name = \"path\", max_depth = 5 }]\n");
  for (const unsigned short columns : {40, 80, 160}) {
    const std::string text = shown({"run", "e.toml", "--fresh", "--threads", "1"}, columns);
    const std::vector<std::string> lines = status_lines(text);
    ASSERT_FALSE(lines.empty()) << text;
    bool rays = false, name = false;
    for (const std::string& line : lines) {
      EXPECT_LT(display_width(line), columns) << line;
      const bool here = line.find("Mrays/s") != std::string::npos && line.find("% saved") != std::string::npos;
      rays |= here;
      name |= here && line.find("| seed=1") != std::string::npos;
    }
    EXPECT_EQ(rays, columns >= 80) << text;
    EXPECT_EQ(name, columns >= 160) << text;
  }
}

TEST_F(AtTerminal, ListsHaveALineANameAndHelpFits) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"list", "integrators"}, {"help"}, {"render", "--help"}, {"help", "report"}}) {
    std::istringstream lines(shown(arguments, 80));
    EXPECT_EQ(status_, 0);
    int count = 0;
    for (std::string line; std::getline(lines, line); ++count) EXPECT_LE(display_width(line), 81u) << line;  // with its \r
    EXPECT_GT(count, 10);
  }
}

class Mistakes : public ProgramTest {
 protected:
  std::string told(const std::vector<std::string>& arguments) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    return outcome.err;
  }
};

TEST_F(Mistakes, NamesAreSuggestedOnce) {
  EXPECT_EQ(told({"list", "iradiance-cache"}),
            "error: list: unknown list or name 'iradiance-cache'; did you mean 'irradiance-cache' or 'radiance-cache'?\n");
  EXPECT_NE(told({"render", "cornell-box"}).find("did you mean 'builtin:cornell-box'?"), std::string::npos);
  std::filesystem::create_directories(directory_ / "experiments");
  write_file("experiments/first.toml", "");
  EXPECT_NE(told({"run", "frist"}).find("unknown experiment 'frist'; did you mean 'first'?"), std::string::npos);
  EXPECT_NE(told({"run"}).find("EXPERIMENT is required"), std::string::npos);
  EXPECT_NE(told({"completion", "bsh"}).find("did you mean 'bash' or 'zsh'?"), std::string::npos);
  EXPECT_NE(told({"help", "rendr"}).find("unknown command 'rendr'; did you mean 'render'?"), std::string::npos);
  EXPECT_NE(told({"render", "builtin:furnace", "--camera", ""}).find("--camera: nothing stands there"), std::string::npos);
  EXPECT_NE(told({"report", ".", "--crop", "1,2,3"}).find("expected X,Y,WIDTH,HEIGHT"), std::string::npos);
  EXPECT_NE(told({"report", ".", "--scene", "a"}).find("expected --figure"), std::string::npos);
}

TEST_F(Mistakes, WordsOfAFileAreNoOrdersToTheTerminal) {
  write_file("s.pbrt", "WorldBegin Material \"dif\x1b[31mfuse\"\n");
  EXPECT_NE(told({"inspect", "s.pbrt"}).find("unknown material 'dif?[31mfuse'"), std::string::npos);
}

TEST_F(Mistakes, TimesOfOptionsAreThoseOfFiles) {
  EXPECT_EQ(run({"render", "builtin:furnace", "--time", "0.1", "--resolution", "8x8", "-o", "a.png"}).status, 0);
  EXPECT_NE(told({"render", "builtin:furnace", "--time", "1sec"}).find("units: s, ms, min, h"), std::string::npos);
  EXPECT_NE(told({"render", "builtin:furnace", "--time", "0"}).find("above zero"), std::string::npos);
}

// They would make an error small that is not.
TEST_F(Mistakes, PixelsThatAreNotFiniteAreToldByCompare) {
  const float pixels[6] = {1, 2, 3, NAN, 0, 0};
  write_file("a.pfm", "PF\n2 1\n-1.0\n" + std::string(reinterpret_cast<const char*>(pixels), sizeof pixels));
  const Outcome told = run({"compare", "a.pfm", "a.pfm"});
  EXPECT_EQ(told.status, 0);
  EXPECT_NE(told.err.find("warning: a.pfm: 1 of 2 pixels are not finite and count as 0, the first at (1, 0)"),
            std::string::npos)
      << told.err;
}

// Another renderer's image is often larger than what is rendered to look at it.
TEST_F(Mistakes, LargerReferencesAreAveragedAndTurnedOnesAreTold) {
  const auto image = [&](const std::string& name, int width, int height, const auto& value) {
    std::string text = fmt::format("PF\n{} {}\n-1.0\n", width, height);  // rows from the bottom
    for (int i = 0; i < width * height; ++i) {
      const float pixel[3] = {value(i % width), 1, 1};
      text.append(reinterpret_cast<const char*>(pixel), sizeof pixel);
    }
    write_file(name, text);
  };
  image("a.pfm", 8, 8, [](int x) { return static_cast<float>(x); });
  image("b.pfm", 16, 16, [](int x) { return static_cast<float>(7 - x / 2); });
  image("c.pfm", 16, 8, [](int x) { return static_cast<float>(x); });
  const Outcome told = run({"compare", "a.pfm", "b.pfm", "--seeds", "a.pfm"});
  EXPECT_NE(told.err.find("b.pfm is averaged over 2 x 2 pixels"), std::string::npos) << told.err;
  EXPECT_NE(told.err.find("a.pfm resembles b.pfm mirrored left to right"), std::string::npos) << told.err;
  EXPECT_NE(told.out.find("red_ratio          1\n"), std::string::npos) << told.out;
  EXPECT_NE(told.err.find("a.pfm has the pixels of a.pfm"), std::string::npos) << told.err;
  EXPECT_EQ(run({"compare", "a.pfm", "c.pfm"}).status, 2);
}

TEST_F(Mistakes, NothingIsComparedWhereOneSeedCannotBeRead) {
  const float pixels[3] = {1, 2, 3};
  write_file("a.pfm", "PF\n1 1\n-1.0\n" + std::string(reinterpret_cast<const char*>(pixels), sizeof pixels));
  const Outcome told = run({"compare", "a.pfm", "a.pfm", "--seeds", "b.pfm"});
  EXPECT_EQ(told.status, 2);
  EXPECT_EQ(told.out, "");
}

TEST_F(Mistakes, ListsAreShortUnlessAllIsAskedFor) {
  const std::string brief = run({"list", "integrators"}).out, all = run({"list", "integrators", "--all"}).out;
  EXPECT_EQ(brief.find("photons  "), std::string::npos);
  EXPECT_NE(all.find("photons  "), std::string::npos);
  EXPECT_EQ(all, run({"list", "integrators", "--params"}).out);
}

}  // namespace
}  // namespace etendue
