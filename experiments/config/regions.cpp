#include "experiments/config/regions.h"

#include "framework/core/error.h"

#include <fmt/format.h>
#include <algorithm>

namespace etendue {

namespace {

dvec2 read_corner(const ConfigNode& node, const std::string& key) {
  const auto* array = node.array();
  if (!array || array->size() != 2) wrong_type(node, key, "[x, y] in fractions of the image");
  return {read_number((*array)[0], key, 0, 1), read_number((*array)[1], key, 0, 1)};
}

std::vector<dvec2> read_outline(const ConfigNode& node, const ConfigNode* from, const ConfigNode* to,
                                const ConfigNode* polygon) {
  if ((polygon != nullptr) == (from != nullptr) || (from != nullptr) != (to != nullptr))
    throw Error(node.where, "regions: expected either from and to, or polygon");
  if (from) {
    const dvec2 a = read_corner(*from, "regions.from"), b = read_corner(*to, "regions.to");
    if (a.x >= b.x || a.y >= b.y)
      throw Error(to->where, fmt::format("regions.to: [{}, {}] is not right of and below from = [{}, {}]; expected the lower "
                                         "right corner",
                                         b.x, b.y, a.x, a.y));
    return {a, {b.x, a.y}, b, {a.x, b.y}};
  }
  const auto* corners = polygon->array();
  if (!corners || corners->size() < 3) wrong_type(*polygon, "regions.polygon", "three or more corners [x, y]");
  return mapped(*corners, [](const ConfigNode& corner) { return read_corner(corner, "regions.polygon"); });
}

RegionChoice read_region(const ConfigNode& node, const std::vector<std::string>& scenes) {
  TableReader reader(node, "regions", "tables { name, from, to }");
  RegionChoice region;
  region.where = node.where;
  const auto *name = reader.find("name"), *scene = reader.find("scene");
  const auto *from = reader.find("from"), *to = reader.find("to"), *polygon = reader.find("polygon");
  reader.finish();
  if (!name) throw Error(node.where, "regions: a region without a name; expected { name = \"…\", from, to }");
  region.name = read_text(*name, "regions.name");
  if (region.name.empty()) throw Error(name->where, "regions.name: empty; expected a name");
  if (scene) {
    region.scene = read_text(*scene, "regions.scene");
    require_name(scene->where, "scene", region.scene, scenes, "regions.scene: ");
  }
  region.polygon = read_outline(node, from, to, polygon);
  return region;
}

bool inside(const std::vector<dvec2>& polygon, const dvec2& p) {
  bool result = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const dvec2 &a = polygon[i], &b = polygon[j];
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) result = !result;
  }
  return result;
}

}  // namespace

std::vector<RegionChoice> read_regions(const ConfigNode& node, const std::vector<std::string>& scenes) {
  std::vector<RegionChoice> regions;
  for (const ConfigNode* element : list_elements(node, "regions", "[[regions]] tables { name, from, to }")) {
    RegionChoice region = read_region(*element, scenes);
    for (const RegionChoice& other : regions)
      if (other.name == region.name && (other.scene.empty() || region.of_scene(other.scene)))
        throw Error(region.where, fmt::format("region '{}' of {} stands there twice", region.name,
                                              region.scene.empty() ? "every scene" : region.scene));
    regions.push_back(std::move(region));
  }
  return regions;
}

std::vector<Region> make_regions(const std::vector<RegionChoice>& choices, const std::string& scene, ivec2 resolution) {
  std::vector<Region> regions;
  for (const RegionChoice& choice : choices) {
    if (!choice.of_scene(scene)) continue;
    Region region{choice.name, {}};
    for (int y = 0; y < resolution.y; ++y)
      for (int x = 0; x < resolution.x; ++x)
        if (inside(choice.polygon, (dvec2(x, y) + 0.5) / dvec2(resolution)))
          region.pixels.push_back(pixel_index({x, y}, resolution));
    if (region.pixels.empty())
      throw Error(choice.where, fmt::format("region '{}' holds no pixel of {} at {} x {}; expected a larger one", choice.name,
                                            scene, resolution.x, resolution.y));
    regions.push_back(std::move(region));
  }
  return regions;
}

bool Region::holds(ivec2 pixel, ivec2 resolution) const {
  return pixel.x >= 0 && pixel.x < resolution.x && pixel.y >= 0 && pixel.y < resolution.y &&
         std::ranges::binary_search(pixels, pixel_index(pixel, resolution));
}

Image crop(const Image& image, const Region& region) {
  Image part({static_cast<int>(region.pixels.size()), 1});
  for (std::size_t i = 0; i < region.pixels.size(); ++i) part.pixels[i] = image.pixels[region.pixels[i]];
  return part;
}

}  // namespace etendue
