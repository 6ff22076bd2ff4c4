#include "experiments/report/results/quotes.h"
#include "framework/core/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace etendue {
namespace {

Table sample_table() {
  Table table{"final", "Errors", {}, {}, {}, {}};
  table.columns = {
      {"scene", "scene", false}, {"method", "method", false}, {"", "shown", true, Audience::people}, {"relmse", "relMSE"}};
  const auto add = [&](const char* scene, const char* method, double value) {
    table.rows.push_back({scene, method, "shown", value});
  };
  add("builtin:box", "path", 4.87e-4);
  add("builtin:box", "sppm", 2.435e-4);
  add("builtin:room", "path", 0.12345);
  return table;
}

// Its readers see the measured figure with its interval, programs the figure alone.
Table sample_verdicts() {
  Table table{"verdicts", "Verdicts", {}, {}, {}, {}};
  table.columns = {{"id", "#"},
                   {"method", "method", false},
                   {"remedy", "remedy", false},
                   {"", "measured", true, Audience::people},
                   {"measured", "", true, Audience::machines},
                   {"verdict", "verdict", false}};
  const auto add = [&](int id, const char* method, const char* remedy, double value, const char* shown, const char* verdict) {
    table.rows.push_back({id, method, remedy, shown, value, verdict});
  };
  add(1, "cache metric=a records=10", "", 12.0, "12.0 (11|13)", "confirmed");
  add(1, "cache metric=b records=10", "other, better", 1.25, "1.25 (1–2)", "confirmed");
  add(2, "cache metric=a records=20", "", 3.0, "3.00 (2–4)", "refuted");
  return table;
}

// A method without an image has no number, and is worse than one that has an image.
Table sample_losses() {
  Table table{"losses", "Losses", {}, {}, {}, {}};
  table.columns = {{"method", "method", false}, {"worst", "at worst"}};
  table.rows = {{"path", times_cell(1.5)}, {"sppm", times_cell(INFINITY)}, {"bdpt", TableCell()}};
  return table;
}

std::string filled(const std::string& text) {
  static const Table all[] = {sample_table(), sample_verdicts(), sample_losses()};
  return fill_quotes("doc.md", text, [](const std::string& folder, const std::string& name) -> const Table& {
    const auto found = std::ranges::find(all, name, &Table::name);
    if (folder != "first" || found == std::end(all)) throw Error("no table " + folder + "/" + name);
    return *found;
  });
}

std::string problem(const std::string& text) {
  try {
    filled(text);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Quotes, FiguresAreThoseOfTheTables) {
  EXPECT_EQ(filled("a <!--= first/final relmse [box, path] -->?<!--/--> b"),
            "a <!--= first/final relmse [box, path] -->4.9e-4<!--/--> b");
  EXPECT_EQ(filled("<!--=first/final relmse [builtin:room, path]-->old<!--/-->"),
            "<!--=first/final relmse [builtin:room, path]-->0.12<!--/-->");
}

TEST(Quotes, FilledTextStaysAsItIs) {
  const std::string text = filled("x\n<!--= first/final relmse [box, path] --><!--/-->\n<!-- a comment -->\n");
  EXPECT_EQ(filled(text), text);
}

TEST(Quotes, RatiosAndNotationsAreTaken) {
  EXPECT_EQ(filled("<!--= first/final relmse [box, path] / first/final relmse [box, sppm] as .1f --><!--/-->"),
            "<!--= first/final relmse [box, path] / first/final relmse [box, sppm] as .1f -->2.0<!--/-->");
  EXPECT_EQ(filled("<!--= first/final relmse [room, path] as 100 * .2f --><!--/--> %"),
            "<!--= first/final relmse [room, path] as 100 * .2f -->12.35<!--/--> %");
}

// The figure that a marker of this text shows.
std::string figure(const std::string& marker) {
  const std::string open = "<!--= " + marker + " -->", text = filled(open + "<!--/-->");
  return text.substr(open.size(), text.size() - open.size() - 8);
}

TEST(Quotes, WordsAreCellsColumnsOrParameters) {
  EXPECT_EQ(figure("first/verdicts measured [metric=a, records=20]"), "3");
  EXPECT_EQ(figure("first/verdicts measured [id=1, remedy=]"), "12");
  EXPECT_NE(problem("<!--= first/verdicts measured [metric=a] --><!--/-->").find("2 rows"), std::string::npos);
}

TEST(Quotes, RowsAreCountedAndTheirExtremesTaken) {
  EXPECT_EQ(figure("count first/verdicts []"), "3");
  EXPECT_EQ(figure("count first/verdicts [confirmed, metric=a]"), "1");
  EXPECT_EQ(figure("count first/verdicts [not remedy=]"), "1");
  EXPECT_EQ(figure("count first/verdicts [no such]"), "0");
  EXPECT_NE(problem("<!--= count first/verdicts [not remdey=] --><!--/-->").find("'remdey=' in verdicts"), std::string::npos);
  EXPECT_EQ(figure("least first/final relmse [box] as .1e"), "2.4e-04");
  EXPECT_EQ(figure("most first/final relmse [path]"), "0.12");
  EXPECT_EQ(figure("most first/losses worst [not no image]"), "1.5");
  EXPECT_EQ(figure("count first/losses [no image]"), "1");
  EXPECT_NE(problem("<!--= most first/losses worst [] --><!--/-->").find("a row of losses has 'no image' in worst"),
            std::string::npos);
}

TEST(Quotes, TextIsWhatTheLogsTableShows) {
  EXPECT_EQ(figure("first/verdicts measured [id=2] as text"), "3.00 (2–4)");
  EXPECT_EQ(figure("first/verdicts verdict [id=2] as text"), "refuted");
}

TEST(Quotes, TablesHaveTheRowsAndColumnsTheyAskFor) {
  const std::string pivot =
      "a\n<!--table first/final : method\ncolumn relmse [box] : a box\ncolumn relmse [room] as .2f : a room\n"
      "row [path] : path tracing\nrow [sppm]\n-->";
  const std::string filled_pivot =
      "\n| method | a box | a room |\n|---|---:|---:|\n| path tracing | 4.9e-4 | 0.12 |\n| sppm | 2.4e-4 | – |\n";
  EXPECT_EQ(filled(pivot + "old\n<!--/table-->\nb"), pivot + filled_pivot + "<!--/table-->\nb");
  const std::string list =
      "<!--table first/verdicts : #\ncolumn measured [remedy=] as text : as it is; column verdict [remedy=];\n"
      "column least measured : at best\nrows id [confirmed]\n-->";
  EXPECT_EQ(filled(list + "<!--/table-->"), list +
                                                "\n| # | as it is | verdict | at best |\n|---|---:|---|---:|\n"
                                                "| 1 | 12.0 (11\\|13) | confirmed | 1.2 |\n<!--/table-->");
  EXPECT_EQ(filled(filled(pivot + "<!--/table-->")), filled(pivot + "<!--/table-->"));
}

TEST(Quotes, TablesHaveAColumnForEachText) {
  const std::string table = "<!--table first/final : method; columns scene relmse as .2f : MSE; rows method [box] -->";
  EXPECT_EQ(filled(table + "<!--/table-->"),
            table +
                "\n| method | box, MSE | room, MSE |\n|---|---:|---:|\n| path | 0.00 | 0.12 |\n"
                "| sppm | 0.00 | – |\n<!--/table-->");
}

TEST(Quotes, FilesAreNamedWithoutFolderAndEnding) {
  Table table{"final", "Errors", {}, {}, {}, {}};
  table.columns = {{"scene", "scene", false}, {"method", "method", false}, {"mse", "MSE"}};
  table.rows.push_back({"scenes/hall/hall.pbrt", "a / b", 3.0});
  const std::string text =
      "<!--= x/final mse [hall, a / b] -->3<!--/-->\n<!--table x/final; columns scene mse; rows method -->";
  EXPECT_EQ(fill_quotes("doc.md", text + "<!--/table-->",
                        [&](const std::string&, const std::string&) -> const Table& { return table; }),
            text + "\n|  | hall |\n|---|---:|\n| a / b | 3 |\n<!--/table-->");
}

TEST(Quotes, TablesDivideFiguresOfOneRow) {
  const std::string table = "<!--table first/final\ncolumn relmse [room] / relmse [box] as .0f : times\nrow [path]\n-->";
  EXPECT_EQ(filled(table + "<!--/table-->"), table + "\n|  | times |\n|---|---:|\n| path | 253 |\n<!--/table-->");
}

TEST(Quotes, MistakesInTablesAreNamedWithTheirPlace) {
  const auto wrong = [](const std::string& lines) { return problem("a\n<!--table " + lines + "\n-->\n<!--/table-->"); };
  EXPECT_NE(wrong("first/final\ncolumn relmse [box]\nrow [bdpt]").find("doc.md:2:1: no figure"), std::string::npos);
  EXPECT_NE(wrong("first/final\ncolumn relmse\nrow [path]").find("2 rows of final"), std::string::npos);
  EXPECT_NE(wrong("first/final\ncolumn relmze [box]\nrow [path]").find("did you mean 'relmse'"), std::string::npos);
  EXPECT_NE(wrong("first/final\ncolumn relmse [box]\nlines [path]").find("expected column, columns, row or rows"),
            std::string::npos);
  EXPECT_NE(wrong("first/final\ncolumn relmse [box]").find("without columns or rows"), std::string::npos);
  EXPECT_NE(problem("<!--table first/final\n-->\n<!--= first/final seeds [path] --><!--/-->").find("a table without its end"),
            std::string::npos);
}

TEST(Quotes, MistakesAreNamedWithTheirPlace) {
  EXPECT_NE(problem("a\n <!--= first/final relmse [path] --><!--/-->").find("doc.md:2:2: 2 rows"), std::string::npos);
  EXPECT_NE(problem("<!--= first/final relmze [box, path] --><!--/-->").find("'relmze'; did you mean 'relmse'"),
            std::string::npos);
  EXPECT_NE(problem("<!--= first/last relmse [path] --><!--/-->").find("no table first/last"), std::string::npos);
  EXPECT_NE(problem("<!--= first/final relmse [box, path] -->").find("without its end"), std::string::npos);
  EXPECT_NE(problem("<!--= relmse --><!--/-->").find("expected FOLDER/TABLE"), std::string::npos);
  EXPECT_NE(problem("<!--= first/final method [box, path] --><!--/-->").find("expected a number"), std::string::npos);
  EXPECT_NE(problem("<!--= first/final relmse [box, path] as zz --><!--/-->").find("expected a format"), std::string::npos);
}

}  // namespace
}  // namespace etendue
