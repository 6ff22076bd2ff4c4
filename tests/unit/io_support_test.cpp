// docs/scene-files.md has a row for each type that the readers take, and for no other.
#include "framework/io/mitsuba/mitsuba.h"
#include "framework/io/pbrt/support.h"
#include "tests/places.h"
#include "tests/unit/io_pbrt_helpers.h"

#include <set>
#include <sstream>

namespace etendue {
namespace {

// The rows of three columns whose first names one of `first`.
std::set<std::string> documented_rows(const std::set<std::string>& first) {
  std::set<std::string> rows;
  std::istringstream lines(slurp(std::string(project_folder) + "docs/scene-files.md"));
  for (std::string line; std::getline(lines, line);) {
    const auto end = line.find(" | `");
    if (line.starts_with("| ") && end != std::string::npos && first.contains(line.substr(2, end - 2))) rows.insert(line);
  }
  return rows;
}

std::string row_of(std::string_view first, std::string_view type, std::string_view how) {
  return "| " + std::string(first) + " | `" + std::string(type) + "` | " + std::string(how) + " |";
}

TEST(SceneFileDocs, HaveTheRowsOfThePbrtReader) {
  std::set<std::string> directives, rows;
  for (const PbrtSupport& s : pbrt_support()) {
    directives.emplace(s.directive);
    rows.insert(row_of(s.directive, s.type, s.how));
  }
  EXPECT_EQ(documented_rows(directives), rows);
}

TEST(SceneFileDocs, HaveTheRowsOfTheMitsubaReader) {
  std::set<std::string> elements, rows;
  for (const MitsubaSupport& s : mitsuba_support()) {
    elements.emplace(s.element);
    rows.insert(row_of(s.element, s.type, s.how));
  }
  EXPECT_EQ(documented_rows(elements), rows);
}

// Some need parameters, and say so; of none it is said that it is unknown.
TEST(SceneFileDocs, NameTypesThatThePbrtReaderTakes) {
  for (const PbrtSupport& s : pbrt_support()) {
    const std::string type = " \"" + std::string(s.type) + "\" ";
    const std::string text = s.directive == "Camera"    ? "Camera" + type + "WorldBegin "
                             : s.directive == "Texture" ? "WorldBegin Texture \"t\" \"spectrum\"" + type
                                                        : "WorldBegin " + std::string(s.directive) + type;
    const std::string error =
        error_of([&] { (void)parse_pbrt(text + triangle, "s.pbrt", {.confined = false, .approximate = true}); });
    EXPECT_EQ(error.find(" '" + std::string(s.type) + "'"), std::string::npos) << s.directive << ' ' << s.type << ": " << error;
    const bool incomplete = s.type == "mix" || s.type == "imagemap" || s.directive == "Shape" || s.type == "projection";
    EXPECT_TRUE(error.empty() || incomplete) << s.directive << ' ' << s.type << ": " << error;
  }
}

}  // namespace
}  // namespace etendue
