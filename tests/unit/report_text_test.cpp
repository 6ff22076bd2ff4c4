#include "experiments/report/report_text.h"
#include "framework/core/units.h"

#include <gtest/gtest.h>

#include <vector>

namespace etendue {
namespace {

TEST(ReportText, FiguresHaveThreeDigitsInOneNotation) {
  EXPECT_EQ(format_figure(0), "0");
  EXPECT_EQ(format_figure(1.0 / 3), "0.333");
  EXPECT_EQ(format_figure(1), "1.00");
  EXPECT_EQ(format_figure(99.94), "99.9");
  EXPECT_EQ(format_figure(99.96), "100");
  EXPECT_EQ(format_figure(12345), "12345");
  EXPECT_EQ(format_figure(0.0123456), "0.0123");
  EXPECT_EQ(format_figure(0.00123456), "1.23e-3");
  EXPECT_EQ(format_figure(-1.5e-12), "-1.50e-12");
  EXPECT_EQ(format_figure(2.5e7), "2.50e7");
  EXPECT_EQ(format_short(0.005), "5e-3");
  EXPECT_EQ(format_short(-1), "-1");
  EXPECT_EQ(format_short(100), "100");
  EXPECT_EQ(format_figure(0.57, 2), "0.57");
  EXPECT_EQ(format_figure(12.3, 2), "12");
  EXPECT_EQ(format_figure(0.0123, 2), "1.2e-2");
  EXPECT_EQ(format_interval(0.1, 0.2), "0.100–0.200");
  EXPECT_EQ(format_interval(-0.1, 0.2), "-0.100 to 0.200");
}

TEST(ReportText, WidthCountsCharactersNotBytes) {
  EXPECT_EQ(display_width("1–2 µs"), 6u);
  EXPECT_EQ(padded("–", 3, true), "  –");
  EXPECT_EQ(padded("–", 3, false), "–  ");
  EXPECT_EQ(shortened("abcdef", 4), "abc…");
  EXPECT_EQ(shortened("äöü", 3), "äöü");
  EXPECT_EQ(shortened("äöüß", 3), "äö…");
}

TEST(ReportText, HostileTextIsEscapedInEveryFormat) {
  EXPECT_EQ(escape_html("<a b=\"c\">'&\x01"), "&lt;a b=&quot;c&quot;&gt;&#39;&amp;");
  EXPECT_EQ(escape_tex("50%_#&${}~^\\"), "50\\%\\_\\#\\&\\$\\{\\}\\textasciitilde{}\\textasciicircum{}\\textbackslash{}");
  EXPECT_EQ(escape_markdown("a|b\n<c"), "a\\|b &lt;c");
  EXPECT_EQ(shell_word("a/b-1.toml"), "a/b-1.toml");
  EXPECT_EQ(shell_word("it's; rm"), "'it'\\''s; rm'");
  EXPECT_EQ(shell_word(""), "''");
  const std::vector<std::string> words{"-o", "scenes=[\"it's a.pbrt\", \"b.obj\"]", "", "-o", "seeds=3", "\\"};
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + shell_word(word);
  EXPECT_EQ(shell_words(line), words);
  EXPECT_TRUE(shell_words("").empty());
  EXPECT_EQ(escape_csv("plain"), "plain");
  EXPECT_EQ(escape_csv("a,\"b\"\n"), "\"a,\"\"b\"\"\n\"");
}

TEST(ReportText, TexSetsFiguresAsPowersOfTen) {
  EXPECT_EQ(escape_tex("1.23e-5"), "$1.23\\times10^{-5}$");
  EXPECT_EQ(escape_tex("(2e-3–4e+5)"), "($2\\times10^{-3}$--$4\\times10^{5}$)");
  EXPECT_EQ(escape_tex("-0.98"), "$-$0.98");
  EXPECT_EQ(escape_tex("binned-sah"), "binned-sah");
  EXPECT_EQ(escape_tex("room1e5x"), "room1e5x");  // a name, not a figure
  EXPECT_EQ(escape_tex("1e99999999999999999999"), "$1\\times10^{99999999999999999999}$");
}

TEST(ReportText, SlugsAreSafeNames) {
  EXPECT_EQ(slug("builtin:cornell-box"), "cornell-box");
  EXPECT_EQ(slug("../scenes/My Room.pbrt"), "scenes-my-room-pbrt");
  EXPECT_EQ(slug("///"), "scene");
}

TEST(ReportText, Base64MatchesTheVectorsOfRfc4648) {
  const auto encode = [](std::string_view text) {
    return base64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  };
  EXPECT_EQ(encode(""), "");
  EXPECT_EQ(encode("f"), "Zg==");
  EXPECT_EQ(encode("fo"), "Zm8=");
  EXPECT_EQ(encode("foo"), "Zm9v");
  EXPECT_EQ(encode("foobar"), "Zm9vYmFy");
}

TEST(ReportText, NoBytesAreZeroBytes) { EXPECT_EQ(format_bytes(0), "0 B"); }

TEST(ReportText, SharesHaveADigitBehindThePointBelowTenPercent) {
  EXPECT_EQ(format_percent(0.0123), "1.2 %");
  EXPECT_EQ(format_percent(0.3449), "34 %");
}
TEST(ReportText, TimesAreToldInTheUnitThatTheyRoundTo) {
  EXPECT_EQ(format_seconds(0.9996), "1 s");
  EXPECT_EQ(format_seconds(0.9994), "999 ms");
  EXPECT_EQ(format_seconds(0.00099961), "1 ms");
}

TEST(ReportText, LongLinesAreWrappedAtSpaces) {
  EXPECT_EQ(wrapped("  a bb ccc dddd\n\nx", 9), "  a bb\n    ccc\n    dddd\n\nx\n");
  EXPECT_EQ(wrapped("", 9), "");
  EXPECT_EQ(wrapped(" aaaaaaaaaaaa b", 5), " aaaaaaaaaaaa\n   b\n");
}

}  // namespace
}  // namespace etendue
