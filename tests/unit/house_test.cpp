// Rules of the source tree: includes run downward, rooms stay small, citations resolve, and docs/where-things-are.md names what
// is there.
#include "tests/places.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>

namespace {

namespace fs = std::filesystem;

const fs::path root = etendue::project_folder;

std::string slurp(const fs::path& path) {
  std::ifstream in(path);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

template <class Visit>
void each_source(const std::string& room, const Visit& visit) {
  for (const auto& entry : fs::recursive_directory_iterator(root / room)) {
    const std::string extension = entry.path().extension();
    if (extension == ".h" || extension == ".cpp" || extension == ".inl") visit(entry.path(), slurp(entry.path()));
  }
}

// Each room must not include these. Rooms stand from the general to the particular.
TEST(House, IncludesRunDownward) {
  const std::pair<std::string, std::string> rules[] = {
      {"framework", "(accel|integrators|experiments)/"},
      {"framework/core", "framework/(?!core/)"},
      {"framework/image", "framework/(?!core/|image/)"},
      {"framework/materials", "framework/(?!core/|materials/)"},
      {"framework/scene", "framework/(transport|image|io|scenes)/"},
      {"framework/transport", "framework/(image|io|scenes)/"},
      {"framework/io/image", "framework/(io/mesh|io/pbrt|scenes|transport)/"},
      {"framework/io/mesh", "framework/(io/image|io/pbrt|scenes|transport)/"},
      {"accel", "(integrators|experiments)/"},
      {"accel/kernels", "accel/(?!kernels/)"},
      {"accel/bvh/build", "accel/(bvh/wide|bvh/dynamic|spatial|thirdparty|exact|points|records)/"},
      {"accel/bvh/wide", "accel/(bvh/dynamic|spatial|thirdparty|exact|points|records)/"},
      {"accel/spatial", "accel/(bvh|thirdparty|exact|points|records)/"},
      {"accel/points", "accel/(spatial|thirdparty|exact|records|bvh/wide|bvh/dynamic)/"},
      {"accel/records", "accel/(bvh|spatial|thirdparty|exact)/"},
      {"integrators", "(accel|experiments)/"},
      {"integrators/paths", "integrators/(?!paths/)"},
      {"integrators/lanes", "integrators/(?!lanes/|paths/|photons/)"},
      {"integrators/guiding", "integrators/(?!paths/|guiding/)"},
      {"integrators/photons", "integrators/(?!paths/|photons/)"},
      {"integrators/pilot", "integrators/(?!paths/|photons/|pilot/)"},
      {"integrators/choice", "integrators/warnings/"},
      {"integrators/progressive", "integrators/(?!paths/|photons/|progressive/)"},
      {"integrators/bidirectional", "integrators/(guiding|caches|path_space)/"},
      {"integrators/caches/records", "integrators/(?!paths/|photons/|caches/records/)"},
      {"integrators/caches", "integrators/(?!paths/|photons/|pilot/|caches/)"},
      {"integrators/path_space", "integrators/(guiding|progressive|bidirectional)/"},
      {"experiments/config", "experiments/(?!config/|kind\\.h)"},
      {"experiments/log", "experiments/(?!config/|log/)"},
      {"experiments/statistics", "experiments/(?!config/|statistics/)"},
      {"experiments/report", "experiments/(run|kinds|command)/"},
      {"experiments/run", "experiments/(kinds|command)/"},
      {"experiments/kinds", "experiments/command/"}};
  for (const auto& [room, above] : rules) {
    const std::regex upward("#include \"" + above);
    each_source(room,
                [&](const fs::path& path, const std::string& text) { EXPECT_FALSE(std::regex_search(text, upward)) << path; });
  }
}

// A room that has grown too large to be seen at a glance.
TEST(House, RoomsAreSmall) {
  constexpr int most = 40;
  for (const char* floor : {"framework", "accel", "integrators", "experiments"}) {
    std::map<fs::path, int> sources;
    each_source(floor, [&](const fs::path& path, const std::string&) { ++sources[path.parent_path()]; });
    for (const auto& [room, count] : sources) EXPECT_LE(count, most) << room;
  }
}

// A comment says what something is or does. One that begins with "Of" leaves that to the name below it.
TEST(House, CommentsDoNotBeginWithOf) {
  for (const char* floor : {"framework", "accel", "integrators", "experiments", "tests"})
    each_source(floor, [&](const fs::path& path, const std::string& text) {
      std::istringstream lines(text);
      for (std::string line; std::getline(lines, line);)
        if (const auto start = line.find_first_not_of(' '); start != line.npos && line.compare(start, 6, "// Of ") == 0)
          ADD_FAILURE() << path << ": " << line;
    });
}

// Those of the C library differ between libraries and processors. Metrics and files for the eye may: no image depends on them.
TEST(House, ElementaryFunctionsAreOurs) {
  const std::regex call(
      R"((?:std|glm)::(sin|cos|tan|asin|acos|atan2?|exp2?|expm1|log2?|log1p|log10|pow|cbrt|hypot|sinh|cosh|tanh|asinh|lgamma|tgamma|erfc?|cyl_\w+)\()");
  for (const char* room : {"framework", "accel", "integrators"}) {
    each_source(room, [&](const fs::path& path, const std::string& text) {
      const std::string place = path.lexically_relative(root).generic_string();
      if (place.starts_with("framework/image/") || place == "framework/io/image/png.cpp") return;
      for (std::sregex_iterator i(text.begin(), text.end(), call), end; i != end; ++i)
        ADD_FAILURE() << i->str() << " in " << place << "; expected that of framework/core/elementary.h";
    });
  }
}

TEST(House, WhereThingsAreNamesWhatIsThere) {
  const std::string page = slurp(root / "docs/where-things-are.md");
  const std::regex path("`([a-z_]+/[a-z_/.]+)`");
  int named = 0;
  for (std::sregex_iterator i(page.begin(), page.end(), path), end; i != end; ++i, ++named)
    EXPECT_TRUE(fs::exists(root / (*i)[1].str())) << (*i)[1];
  EXPECT_GT(named, 20);
}

TEST(House, CitationsResolve) {
  const std::string bibliography = slurp(root / "references.bib");
  std::set<std::string> keys;
  const std::regex entry(R"(@\w+\{(\w+),)"), citation(R"(\[([A-Z]\w+[12]\d{3}[a-z]?)\])");
  for (std::sregex_iterator i(bibliography.begin(), bibliography.end(), entry), end; i != end; ++i)
    EXPECT_TRUE(keys.insert((*i)[1]).second) << (*i)[1] << " stands twice";
  for (const char* room : {"framework", "accel", "integrators", "experiments"}) {
    each_source(room, [&](const fs::path& path, const std::string& text) {
      for (std::sregex_iterator i(text.begin(), text.end(), citation), end; i != end; ++i)
        EXPECT_TRUE(keys.count((*i)[1])) << "[" << (*i)[1] << "] in " << path << " is not in references.bib";
    });
  }
}

}  // namespace
