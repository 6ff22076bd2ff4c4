#include "experiments/log/products.h"

#include "framework/core/error.h"
#include "framework/io/image/exr.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <optional>

namespace etendue {

namespace {

struct CellGroup {
  std::string scene, accel, integrator;
  std::vector<const CellRecord*> cells;  // that are done, by seed
};

std::vector<CellGroup> configurations_of(const RunLog& log) {
  std::vector<CellGroup> all;
  for (const CellRecord& cell : log.cells) {
    if (cell.status != "done") continue;
    const auto& [scene, accel, integrator, seed] = cell.cell;
    const auto same = [&](const CellGroup& c) { return c.scene == scene && c.accel == accel && c.integrator == integrator; };
    find_or_add(all, same, {scene, accel, integrator, {}}).cells.push_back(&cell);
  }
  for (CellGroup& configuration : all)
    std::ranges::sort(configuration.cells, {}, [](const CellRecord* cell) { return cell->cell.seed; });
  return all;
}

// Names the images and the reference by their bits.
std::string images_hash(const CellGroup& configuration, const ReferenceRecord& reference) {
  std::string text = reference.scene_hash + ' ' + reference.stamp.hash;
  for (const CellRecord* cell : configuration.cells) text += fmt::format(" {} {}", cell->cell.seed, cell->image_hash);
  return hash_text(text);
}

const ProductsRecord* find_products(const RunLog& log, const CellGroup& configuration, const ReferenceRecord& reference,
                                    const std::string& region, bool at_checkpoints) {
  for (const ProductsRecord& record : log.products)
    if (record.scene == configuration.scene && record.accel == configuration.accel &&
        record.integrator == configuration.integrator && record.region == region && record.at_checkpoints == at_checkpoints)
      return record.images == images_hash(configuration, reference) ? &record : nullptr;
  return nullptr;
}

// A configuration's seeds have an image each, the last, or those of all checkpoints one below the other.
struct SeedImages {
  Image reference;
  std::vector<Image> files;
  std::size_t points = 0;
};

std::optional<SeedImages> read_images(const CellGroup& configuration, const ReferenceRecord& reference, bool at_checkpoints) {
  SeedImages images;
  try {
    images.reference = read_exr(reference.file);
    for (const CellRecord* cell : configuration.cells) {
      images.files.push_back(read_exr(at_checkpoints ? cell->strip : cell->image));
      const ivec2 size = images.files.back().size;
      if (size.x != images.reference.size.x || size.y % images.reference.size.y != 0 || size != images.files.front().size)
        return std::nullopt;
    }
  } catch (const Error&) {
    return std::nullopt;  // an image that is gone takes a figure away, not the run
  }
  images.points = images.files.front().pixels.size() / images.reference.pixels.size();
  return at_checkpoints || images.points == 1 ? std::optional(std::move(images)) : std::nullopt;
}

// The whole image comes first.
std::vector<Region> regions_of(const RunLog& log, const std::string& scene, ivec2 size, bool at_checkpoints) {
  std::vector<Region> regions(1);
  regions.front().pixels.resize(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y));
  std::iota(regions.front().pixels.begin(), regions.front().pixels.end(), std::size_t{0});
  if (at_checkpoints)
    for (Region& region : make_regions(log.stated.regions, scene, size)) regions.push_back(std::move(region));
  return regions;
}

}  // namespace

std::vector<double> error_products(std::span<const Image> images, const Image& reference, std::span<const std::size_t> pixels,
                                   std::size_t first) {
  std::vector<double> products(images.size() * (images.size() + 1) / 2, 0);
  std::vector<dvec3> errors(images.size());
  for (const std::size_t pixel : pixels) {
    for (std::size_t i = 0; i < images.size(); ++i) errors[i] = images[i].pixels[first + pixel] - reference.pixels[pixel];
    std::size_t pair = 0;
    for (std::size_t i = 0; i < images.size(); ++i)
      for (std::size_t j = i; j < images.size(); ++j) products[pair++] += glm::dot(errors[i], errors[j]) / 3;
  }
  for (double& product : products) product /= static_cast<double>(pixels.size());
  return products;
}

const ProductsRecord* current_products(const RunLog& log, const CellName& name, const std::string& region,
                                       bool at_checkpoints) {
  const ReferenceRecord* const reference = log.reference(name.scene);
  if (reference == nullptr) return nullptr;
  for (const CellGroup& configuration : configurations_of(log))
    if (configuration.scene == name.scene && configuration.accel == name.accel && configuration.integrator == name.integrator)
      return find_products(log, configuration, *reference, region, at_checkpoints);
  return nullptr;
}

std::vector<ProductsRecord> missing_products(const RunLog& log) {
  std::vector<ProductsRecord> found;
  for (const CellGroup& configuration : configurations_of(log)) {
    const ReferenceRecord* const logged = log.reference(configuration.scene);
    if (configuration.cells.size() < 2 || logged == nullptr || logged->file.empty()) continue;
    for (const bool at_checkpoints : {false, true}) {
      if (at_checkpoints && configuration.cells.front()->strip.empty()) continue;
      std::vector<Region> regions = regions_of(log, configuration.scene, {logged->width, logged->height}, at_checkpoints);
      std::erase_if(regions, [&](const Region& region) {
        return find_products(log, configuration, *logged, region.name, at_checkpoints) != nullptr;
      });
      if (regions.empty()) continue;
      const auto images = read_images(configuration, *logged, at_checkpoints);
      if (!images) continue;
      for (const Region& region : regions) {
        ProductsRecord record{configuration.scene, configuration.accel, configuration.integrator,
                              region.name,         at_checkpoints,      images_hash(configuration, *logged)};
        for (const CellRecord* cell : configuration.cells) record.seeds.push_back(cell->cell.seed);
        for (std::size_t point = 0; point < images->points; ++point)
          record.products.push_back(
              error_products(images->files, images->reference, region.pixels, point * images->reference.pixels.size()));
        found.push_back(std::move(record));
      }
    }
  }
  return found;
}

}  // namespace etendue
