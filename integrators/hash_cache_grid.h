// Means over hash cells of path space ([Binder2018], [Binder2019]): values at surface points, averaged per cell of position,
// normal and depth.
//
// Cells are cubes of a nested grid, size 2^-level of the scene. The finest level at a point is the one whose cells are not
// smaller than `finest` pixels at the point's distance from the eye; what is added there is added to all coarser cells about
// it. A lookup moves the point at random in its tangent plane by up to half a cell, which turns steps between cells into noise
// that averages out, and answers with the finest cell that has seen enough. Enough grows with the samples per pixel as n^(2/3),
// and the finest cells' edges shrink as n^(-1/6), so that cells shrink and their means settle: consistent, with squared bias
// and variance both falling as n^(-2/3) on smooth surfaces.
//
// Deviations: keys are compared in full, where [Binder2018] trusts a fingerprint; values are added in their given order within
// shards of the table, one task each, where it adds atomically; so means do not depend on threads.
#pragma once

#include "framework/core/vec.h"

#include <optional>
#include <span>
#include <vector>

namespace etendue {

struct CachedValue {
  vec3 position;
  vec3 normal;  // on the side that is looked at
  int depth;    // key as it stands
  Rgb value;
};

struct HashGridOptions {
  vec3 eye{0};
  float pixel_angle = 0.001f;  // of a pixel: its width at distance 1
  float finest = 2;            // pixels
  float enough = 32;           // values, at one sample per pixel
};

class HashGrid {
 public:
  HashGrid(const Bounds& bounds, const HashGridOptions& options);

  // To be called before the values of the sample `index` (from 0) of all pixels.
  void begin(std::uint32_t index);
  void add(std::span<const std::vector<CachedValue>> values);
  // The mean about a point; empty where no cell has seen enough. `u`: uniform.
  std::optional<Rgb> mean(const vec3& position, const vec3& normal, int depth, const vec2& u) const;

 private:
  static constexpr int coarsest = 3, deepest = 24;  // levels

  struct Key {
    glm::ivec3 cell;
    std::uint32_t tag;  // normal and depth
    bool operator==(const Key&) const = default;
  };
  struct Cell {
    Key key;
    Rgb sum{0};
    float count = 0;
    Rgb new_sum{0};  // not yet in the coarser cells
    float new_count = 0;
  };
  // Open addressing with linear probing over indices of cells.
  struct Table {
    std::vector<Cell> cells;
    std::vector<std::uint32_t> slots;
    const Cell* find(const Key& key) const;
    Cell& at(const Key& key);
  };
  struct Shard {
    std::vector<Table> levels = std::vector<Table>(deepest + 1);
  };

  float edge(int level) const { return std::ldexp(size_, -level); }
  Key key(const vec3& position, std::uint32_t tag, int level) const;
  int finest_level(const vec3& position) const;
  std::size_t shard_of(const vec3& position, std::uint32_t tag) const;

  HashGridOptions options_;
  vec3 origin_{0};
  float size_ = 1, finest_ = 2, enough_ = 16;
  std::vector<Shard> shards_;
};

}  // namespace etendue
