// Parts of a scene's image that are judged by themselves, [[regions]] (docs/experiment-file.md has the keys): theory gives a
// smooth wall, an edge and a caustic's fold different rates. A pixel belongs to a region if its centre does, by the even-odd
// rule.
#pragma once

#include "experiments/config/config_tree.h"
#include "framework/core/vec.h"
#include "framework/image/film.h"

#include <string>
#include <vector>

namespace etendue {

struct RegionChoice {
  std::string name;
  std::string scene;  // empty: every scene
  std::vector<dvec2> polygon;
  Location where;

  bool of_scene(const std::string& other) const { return scene.empty() || scene == other; }
};

// Throw Error. `scenes` are the experiment's, by name.
std::vector<RegionChoice> read_regions(const ConfigNode& node, const std::vector<std::string>& scenes);

// Those of a film's pixels that lie in a region, counted row by row from the top.
struct Region {
  std::string name;
  std::vector<std::size_t> pixels;  // ascending

  bool holds(ivec2 pixel, ivec2 resolution) const;
};
// Those of a scene; throws Error at a region that holds no pixel.
std::vector<Region> make_regions(const std::vector<RegionChoice>& choices, const std::string& scene, ivec2 resolution);

// Its pixels in one row: any metric of an image is one of a region.
Image crop(const Image& image, const Region& region);

}  // namespace etendue
