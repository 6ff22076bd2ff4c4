#include "framework/io/mesh/left_out.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {

namespace {

std::string of_all(std::uint64_t left_out, std::uint64_t triangles) {
  constexpr const char* why = "of no area or not finite";
  if (left_out < triangles) return fmt::format("{} of {} triangles left out, {}", left_out, triangles, why);
  if (triangles == 1) return fmt::format("its only triangle left out, {}: nothing of it can be seen", why);
  return fmt::format("all {} triangles left out, {}: nothing of it can be seen", triangles, why);
}

}  // namespace

void LeftOutTriangles::add(std::string name, std::uint64_t triangles, std::uint64_t left_out) {
  if (left_out > 0) meshes_.push_back({std::move(name), triangles, left_out});
}

std::vector<std::string> LeftOutTriangles::warnings() const {
  std::vector<Mesh> sorted = meshes_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Mesh& a, const Mesh& b) { return a.share() > b.share(); });
  const std::size_t named = sorted.size() <= most_named + 1 ? sorted.size() : most_named;  // not "1 more mesh"
  std::vector<std::string> warnings;
  for (std::size_t i = 0; i < named; ++i)
    warnings.push_back(fmt::format("{}: {}", sorted[i].name, of_all(sorted[i].left_out, sorted[i].triangles)));
  std::uint64_t left_out = 0, triangles = 0;
  for (std::size_t i = named; i < sorted.size(); ++i) left_out += sorted[i].left_out, triangles += sorted[i].triangles;
  if (triangles > 0)
    warnings.push_back(fmt::format("{} more meshes: {}", sorted.size() - named,
                                   left_out < triangles ? of_all(left_out, triangles) : "all of their triangles left out"));
  return warnings;
}

}  // namespace etendue
