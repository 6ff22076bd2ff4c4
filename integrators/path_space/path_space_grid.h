// Means over hash cells of path space ([Binder2018], [Binder2019]): values at surface points, gathered per cell of position,
// normal and depth.
//
// Cells are cubes of a nested grid, size 2^-level of the scene. The finest level at a point is the one whose cells are not
// smaller than `finest` pixels at the point's distance from the eye; a value added there is also added to all coarser cells
// around it. The finest cell around a point that has enough values answers. Enough grows with the samples per pixel as n^(2/3),
// and the finest cells' edges shrink as n^(-1/6), so that cells shrink and their means settle: consistent, with squared bias
// and variance both falling as n^(-2/3) on smooth surfaces.
//
// The first values ended in the large cells of the first samples, which may bring light through walls into the cells that keep
// them. So at the samples 2, 4, 8, ... all values so far lose half of their weight: what the first n / 2^k of n samples brought
// weighs about 4^-k of the whole (the very first up to three times that), for 30 to 45 % more variance. Numbers of values are
// sums of weights.
//
// Points seen in the image are looked up with jitter: the point is moved at random in its tangent plane by up to half a cell,
// which turns steps between cells into noise that averages out. Where that leads off the surface, or to a cell with too few
// values, the point's own cell answers; where no cell has enough values yet, the coarsest one, since a few values are better
// than one.
//
// A cell answers with the plane that fits its values best (least squares, as local linear regression does [Fan1993]; a ridge
// keeps it level where few values tell its slope). Where light falls off towards a corner, and all values lie on one side of
// the point, their mean would be wrong in the first order of the cell's size; the plane is in the second.
//
// Cells estimate the error of their answers: the noise of a plane fitted to n values of the observed scatter, and how far light
// that is not linear is blurred. Over the jitter that is of second order in the cell's size, and so a third of the difference
// to the same lookup in cells of twice the size, with twice the jitter. That difference has noise of its own, which averages
// out over lookups if its sign is kept. Of n values of weights w count (sum of w)^2 / (sum of w^2) here.
//
// Deviations: keys are compared in full, where [Binder2018] trusts a fingerprint; values are added in their given order within
// shards of the table, one task each, where it adds atomically; so means do not depend on threads. [Binder2018] takes means.
#pragma once

#include "framework/integrator.h"
#include "integrators/caches/records/cache_file.h"
#include "integrators/caches/records/cache_progress.h"
#include "integrators/path_space/plane_moments.h"

#include <array>
#include <optional>
#include <span>
#include <vector>

namespace etendue {

struct CachedValue {
  vec3 position;
  vec3 normal;  // on the side that is seen
  int depth;    // key as it stands
  Rgb value;
};

struct PathSpaceGridOptions {
  vec3 eye{0};
  float pixel_angle = 0.001f;  // of a pixel: its width at distance 1, or at all distances where rays are parallel
  float finest = 4;            // pixels
  float enough = 5;            // values, at one sample per pixel
  bool parallel = false;       // are the camera's rays
};

class PathSpaceGrid {
 public:
  // Two answers of a cell, after m and after n > m samples, have noise of correlation (m / n)^1.5: what the later one has of
  // the first m samples weighs (m / n)^2 of the whole, and has sqrt(n / m) times the noise. It is less where finer cells took
  // over.
  static constexpr double forgetting = 1.5;

  PathSpaceGrid(const Bounds& bounds, const PathSpaceGridOptions& options);

  // To be called before the values of the sample `index` (from 0) of all pixels.
  void begin(std::uint32_t index);
  void add(std::span<const std::vector<CachedValue>> values);
  // Relative scatter of values within their coarsest cell: standard deviation over mean, averaged over all values so far.
  float scatter() const;
  // The mean about a point; empty where no cell has seen enough.
  std::optional<Rgb> mean(const vec3& position, const vec3& normal, int depth) const;
  // The same without steps; empty where nothing was seen. `u`: uniform.
  std::optional<Rgb> smooth_mean(const vec3& position, const vec3& normal, int depth, const vec2& u) const;
  // The error of what smooth_mean answers, weighted by channel; 0 where nothing answers. The noise is that of its mean over u.
  CachedError error(const vec3& position, const vec3& normal, int depth, const vec2& u, const Rgb& weight) const;

  // The cells that answer now somewhere, as cubes.
  std::vector<RecordShape> cells() const;

  // All cells, by level from the coarsest: u64 number of them; of each: i32 cell[3]; u32 normal and depth; f32 number of
  // values, squared weights, place[2], its squares[3], value[3], value times place[2][3], squared luminance. `read` throws
  // Error where the bytes hold what no cell can; the grid is as it was when they were written.
  void write(ByteWriter& out) const;
  void read(ByteReader& in, int depths);

 private:
  static constexpr int coarsest = 3, deepest = 24;  // levels

  struct Key {
    glm::ivec3 cell;
    std::uint32_t tag;  // normal and depth
    bool operator==(const Key&) const = default;
  };
  // Open addressing with linear probing; what a search passes by lies in the slots.
  struct Table {
    struct Slot {
      Key key{};
      std::uint32_t cell = 0;  // its index plus one; 0: no cell
    };
    std::vector<Slot> slots;
    std::vector<Key> keys;
    std::vector<PlaneMoments> cells;

    const PlaneMoments* find(const Key& key) const;  // null: there is none
    void add(const Key& key, const PlaneMoments& moments);
    void clear();

   private:
    std::size_t slot_of(const Key& key) const;
    void grow();
  };
  using Levels = std::array<Table, deepest + 1>;
  struct Shard {
    Levels levels;
    Levels fresh;  // of the values that are being added; empty else
  };

  // A point that the grid is asked about.
  struct Place {
    vec3 position;  // from the grid's origin, in units of its size
    std::uint32_t tag;
    const Shard* shard;

    Key key(int level) const { return {cell_of(position, level), tag}; }
  };

  // Tells smooth_mean which cells answer where (level -1: none), the point's own place, and how far it was moved, in edges.
  struct Lookup {
    Place place;
    int level;
    Place own;
    vec3 offset;
  };

  static glm::ivec3 cell_of(const vec3& position, int level) {
    return glm::ivec3(glm::floor(position * static_cast<float>(1 << level)));
  }
  static vec2 place_in(const Key& key, const Frame& plane, const vec3& position, int level);
  vec3 in_grid(const vec3& position) const { return (position - origin_) * (1 / size_); }
  float edge(int level) const { return std::ldexp(size_, -level); }
  Place place(const vec3& position, std::uint32_t tag) const;
  int finest_level(const vec3& position) const;
  std::optional<Place> jittered(const Place& at, const vec3& position, const vec3& offset, int level, float enough) const;
  Lookup look_up(const vec3& position, const vec3& normal, int depth, const vec2& u) const;
  static const PlaneMoments* find(const Place& at, int level, float enough);
  static std::optional<Rgb> answer(const Place& at, int level, float enough);
  static bool answered_within(const Shard& shard, const Key& at, int level, float enough);
  void add_to(Shard& shard, std::span<const CachedValue* const> values) const;

  PathSpaceGridOptions options_;
  vec3 origin_{0};
  float size_ = 1, finest_, enough_;
  std::vector<Shard> shards_;
};

}  // namespace etendue
