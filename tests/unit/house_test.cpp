// The house's own rules: includes run downward, citations resolve.
#include "tests/places.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
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
    if (extension == ".h" || extension == ".cpp") visit(entry.path(), slurp(entry.path()));
  }
}

TEST(House, IncludesRunDownward) {
  const std::pair<std::string, std::string> rules[] = {{"framework", "(accel|integrators|experiments)/"},
                                                       {"accel", "(integrators|experiments)/"},
                                                       {"integrators", "(accel|experiments)/"}};
  for (const auto& [room, above] : rules) {
    const std::regex upward("#include \"" + above);
    each_source(room,
                [&](const fs::path& path, const std::string& text) { EXPECT_FALSE(std::regex_search(text, upward)) << path; });
  }
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
