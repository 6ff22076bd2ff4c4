#include "experiments/report/results/quotes.h"
#include "framework/core/error.h"

#include <gtest/gtest.h>

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

std::string filled(const std::string& text) {
  static const Table table = sample_table();
  return fill_quotes("doc.md", text, [](const std::string& folder, const std::string& name) -> const Table& {
    if (folder != "first" || name != "final") throw Error("no table " + folder + "/" + name);
    return table;
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
