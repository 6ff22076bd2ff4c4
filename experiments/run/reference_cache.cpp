#include "experiments/run/reference_cache.h"

#include "experiments/run/recipe.h"
#include "framework/core/error.h"
#include "framework/io/image/exr.h"

#include <etendue_build.h>
#include <fmt/format.h>
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace etendue {

namespace {

namespace fs = std::filesystem;

// It is to be raised when a reference of old must no longer be believed.
constexpr std::string_view format_version = "3";

std::string prefix(const Scene& scene) { return fmt::format("{:016x}-d{}-", scene.hash(), scene.max_depth.value_or(64)); }

// Reads the WxH of "<prefix>WxH.exr".
std::optional<ivec2> parse_size(std::string_view name, std::string_view start) {
  constexpr std::string_view extension = ".exr";
  if (!name.starts_with(start) || !name.ends_with(extension)) return std::nullopt;
  name.remove_prefix(start.size());
  name.remove_suffix(extension.size());
  return parse_resolution(name);
}

std::optional<int> multiple(ivec2 large, ivec2 small) {
  if (large.x % small.x != 0 || large.y % small.y != 0 || large.x / small.x != large.y / small.y) return std::nullopt;
  return large.x / small.x;
}

// Hashes the pixels, as a file holds them, and all that is said of them.
std::string content_hash(const Image& image, std::map<std::string, std::string> attributes) {
  std::string bytes;
  for (const char* key : {"etendue_reference", "mse_floor", "samples", "source", "checks"}) bytes += attributes[key] + '\n';
  bytes += attributes["relmse_floor"];  // which older ones have not
  const std::size_t start = bytes.size();
  bytes.resize(start + image.pixels.size() * sizeof(vec3));
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const vec3 pixel(image.pixels[i]);
    std::memcpy(bytes.data() + start + i * sizeof(vec3), &pixel, sizeof(vec3));
  }
  return hash_text(bytes);
}

}  // namespace

std::map<std::string, std::string> reference_attributes(const RenderedReference& reference) {
  std::map<std::string, std::string> attributes{{"etendue_reference", std::string(format_version)},
                                                {"mse_floor", fmt::format("{:.17g}", reference.mse_floor)},
                                                {"relmse_floor", fmt::format("{:.17g}", reference.relmse_floor)},
                                                {"samples", std::to_string(reference.samples)},
                                                {"source", reference.source},
                                                {"checks", reference.checks}};
  attributes["content_xxh3"] = content_hash(reference.image, attributes);
  return attributes;
}

RenderedReference read_reference(const std::string& path) {
  RenderedReference reference;
  std::map<std::string, std::string> attributes;
  reference.image = read_exr(path, &attributes);
  if (attributes["etendue_reference"] != format_version) return reference;
  if (attributes["content_xxh3"] != content_hash(reference.image, attributes))
    throw Error(Location{path}, "a damaged reference: its pixels or attributes are not those that were written");
  reference.mse_floor = std::strtod(attributes["mse_floor"].c_str(), nullptr);
  reference.relmse_floor = std::strtod(attributes["relmse_floor"].c_str(), nullptr);
  reference.samples = std::strtoull(attributes["samples"].c_str(), nullptr, 10);
  reference.source = attributes["source"];
  reference.checks = attributes["checks"];
  return reference;
}

std::optional<RenderedReference> reduce(const RenderedReference& reference, ivec2 resolution) {
  const auto k = multiple(reference.image.size, resolution);
  if (!k) return std::nullopt;
  RenderedReference reduced = reference;
  if (*k == 1) return reduced;
  const double parts = static_cast<double>(*k) * *k;
  reduced.image = Image(resolution);
  for (int y = 0; y < reference.image.size.y; ++y)
    for (int x = 0; x < reference.image.size.x; ++x) reduced.image.at(x / *k, y / *k) += reference.image.at(x, y) / parts;
  reduced.mse_floor /= parts;
  reduced.relmse_floor = 0;  // not known: it goes by the brightness of pixels that are no more
  reduced.samples *= static_cast<std::uint64_t>(parts);
  reduced.source += fmt::format(", each pixel the mean of {} x {}", *k, *k);
  return reduced;
}

ReferenceCache ReferenceCache::standard(const std::string& beside) {
  std::vector<std::string> directories;
  const auto add = [&](const fs::path& path) {
    std::error_code ignored;
    if (fs::is_directory(path, ignored) && !contains(directories, path.string())) directories.push_back(path.string());
  };
  if (!beside.empty()) {
    for (fs::path parent = fs::absolute(beside).lexically_normal().parent_path();; parent = parent.parent_path()) {
      add(parent / "experiments" / "references");
      if (parent == parent.parent_path()) break;
    }
  }
  add(fs::path(ETENDUE_SOURCE_DIR) / "experiments" / "references");
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  // The last one may be absent yet: it is where new references go.
  if (cache && *cache) {
    directories.push_back((fs::path(cache) / "etendue" / "references").string());
  } else if (home && *home) {
    directories.push_back((fs::path(home) / ".cache" / "etendue" / "references").string());
  } else {
    directories.push_back((fs::temp_directory_path() / "etendue-references").string());
  }
  return ReferenceCache(std::move(directories));
}

std::string ReferenceCache::key(const Scene& scene, ivec2 resolution) {
  return fmt::format("{}{}x{}", prefix(scene), resolution.x, resolution.y);
}

std::optional<RenderedReference> ReferenceCache::find(const Scene& scene, ivec2 resolution, std::uint64_t samples) const {
  const std::string start = prefix(scene);
  for (const std::string& directory : directories_) {
    std::vector<std::pair<int, std::string>> candidates;  // by multiple
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(directory, ignored)) {
      const auto size = parse_size(entry.path().filename().string(), start);
      if (!size) continue;
      // A filter's radius counts in pixels, so that the mean of smaller ones is the pixel of another filter.
      if (const auto k = multiple(*size, resolution); k && (*k == 1 || !scene.filter))
        candidates.emplace_back(*k, entry.path().string());
    }
    std::ranges::sort(candidates);
    for (const auto& [k, path] : candidates) {
      try {
        const RenderedReference reference = read_reference(path);
        if (reference.checks.empty()) continue;  // another format, or not ours
        auto reduced = reduce(reference, resolution);
        if (reduced && reduced->samples >= samples) return reduced;
      } catch (const Error&) {
        continue;  // a damaged file in a cache is as good as none
      }
    }
  }
  return std::nullopt;
}

std::optional<std::string> ReferenceCache::store(const Scene& scene, const RenderedReference& reference) const {
  std::error_code failed;
  fs::create_directories(directories_.back(), failed);
  const std::string path = (fs::path(directories_.back()) / (key(scene, reference.image.size) + ".exr")).string();
  try {
    write_exr(path, reference.image, reference_attributes(reference));
  } catch (const Error&) {
    return std::nullopt;
  }
  return path;
}

std::optional<std::string> ReferenceCache::lock_path(const Scene& scene, ivec2 resolution) const {
  std::error_code failed;
  fs::create_directories(directories_.back(), failed);
  if (failed) return std::nullopt;
  return (fs::path(directories_.back()) / (key(scene, resolution) + ".lock")).string();
}

}  // namespace etendue
