// Rendered references are expensive, so they are kept: in the repository's experiments/references/ (committed) and in the
// user's cache.
//
// A file is named for what it depends on, <scene hash>-d<depth>-<width>x<height>.exr, and carries how it was made. An image
// whose sides are a whole multiple of those wanted serves as well where the scene has no filter but the box: a pixel's mean is
// the mean of its parts' means then.
#pragma once

#include "framework/image/film.h"
#include "framework/scene/scene.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace etendue {

struct RenderedReference {
  Image image;
  double mse_floor = 0;       // variance of the image's pixels
  std::uint64_t samples = 0;  // per pixel, of the estimator that has more
  std::string source, checks;
  double relmse_floor = 0;  // what the image's variance adds to a relMSE; 0: none, or not known
};

std::map<std::string, std::string> reference_attributes(const RenderedReference& reference);
// Reads any EXR; what the attributes do not say keeps its default. Throws Error where it cannot be read.
RenderedReference read_reference(const std::string& path);

// Averages k x k pixels; nullopt unless both sides are the same whole multiple k >= 1.
std::optional<RenderedReference> reduce(const RenderedReference& reference, ivec2 resolution);

class ReferenceCache {
 public:
  // Searched in order; files are stored in the last directory.
  explicit ReferenceCache(std::vector<std::string> directories) : directories_(std::move(directories)) {}
  // Searches experiments/references above `beside` (an experiment's path, or "") or in the source tree, then the user's cache.
  static ReferenceCache standard(const std::string& beside);

  static std::string key(const Scene& scene, ivec2 resolution);
  // Finds one of at least so many samples per pixel, by the smallest image that serves.
  std::optional<RenderedReference> find(const Scene& scene, ivec2 resolution, std::uint64_t samples) const;
  // Returns the path written, or nullopt where the user's cache cannot be written to.
  std::optional<std::string> store(const Scene& scene, const RenderedReference& reference) const;
  // A file to lock while rendering that reference, so that shards on one machine render it once; nullopt as for `store`.
  std::optional<std::string> lock_path(const Scene& scene, ivec2 resolution) const;

 private:
  std::vector<std::string> directories_;
};

}  // namespace etendue
