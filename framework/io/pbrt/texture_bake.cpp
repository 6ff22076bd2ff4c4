#include "framework/io/pbrt/texture_bake.h"

#include "framework/core/fuzzing.h"
#include "framework/core/memory.h"
#include "framework/core/parallel.h"
#include "framework/core/rng.h"

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

constexpr double lost_share = 0.5;    // of a field's variance within texels, beyond which detail counts as lost,
constexpr double rough_share = 0.25;  // and from which a point does not stand for its texel

// A triangle's place in the atlas: the corner of its square of texels, and whether it is the upper of the two there. In texels
// from that corner, its right angle lies at 0 and its legs are `leg` long.
struct Cell {
  int side, leg, per_row;

  ivec2 corner(std::uint32_t triangle) const {
    const int square = static_cast<int>(triangle / 2);
    return side * ivec2(square % per_row, square / per_row);
  }
  ivec2 size(std::size_t triangles) const {
    const int squares = static_cast<int>((triangles + 1) / 2);
    return side * ivec2(per_row, (squares + per_row - 1) / per_row);
  }
  // Texel (i, j) of a square, in texels of the triangle that it belongs to.
  bool is_upper(int i, int j) const { return i + j >= side - 1; }
  // `offset`: from the texel's centre, but not across the legs.
  vec2 legs_at(int i, int j, const vec2& offset) const {
    const ivec2 own = is_upper(i, j) ? ivec2(side - 1 - i, side - 1 - j) : ivec2(i, j);
    return (vec2(own) + offset * vec2(glm::greaterThan(own, ivec2(0)))) / static_cast<float>(leg);
  }
};

Cell cell_for(std::size_t triangles, int side) {
  constexpr int least = 5;  // of which a leg is one texel: the values at the corners, interpolated
  const auto squares = static_cast<double>((triangles + 1) / 2);
  const int per_row = static_cast<int>(std::ceil(std::sqrt(squares)));
  const int cell = std::max(side / per_row, least);
  return {cell, cell - 4, per_row};
}

Rgb baked(const TextureField& field, Baked values, const TexturePlace& place) {
  const Rgb value = field.at(place);
  return values == Baked::reflectance ? within_unit(value) : is_finite(value) ? value : Rgb(0);
}

// Calls `visit(offset)` for `across` x `across` points of a texel, whose offsets from its centre are in texels.
template <class Visit>
void for_points_of_texel(int across, const Visit& visit) {
  for (int j = 0; j < across; ++j)
    for (int i = 0; i < across; ++i) visit((vec2(i, j) + 0.5f) / static_cast<float>(across) - 0.5f);
}

template <class At>
Rgb mean_over_texel(int across, const At& at) {
  Rgb mean(0);
  const float weight = 1 / square(static_cast<float>(across));
  for_points_of_texel(across, [&](const vec2& offset) { mean += weight * at(offset); });
  return mean;
}

// The share of a field's variance that lies within texels, by some of them, chosen at random. `texel(rng)` chooses one: a
// function of the offset from its centre.
template <class Texel>
double share_within_texels(std::size_t texels, const Texel& texel) {
  constexpr std::size_t most_probes = 1024, points = 16;
  const std::size_t probes = unless_fuzzed(std::clamp<std::size_t>(texels / 64, 16, most_probes), std::size_t{1});
  Pcg32 rng(probes, 0);
  dvec3 sum(0), squares(0), within(0);
  for (std::size_t probe = 0; probe < probes; ++probe) {
    const auto at = texel(rng);
    dvec3 mean(0), mean_square(0);
    for_points_of_texel(4, [&](const vec2& offset) {
      const dvec3 value(at(offset));
      mean += value / static_cast<double>(points);
      mean_square += value * value / static_cast<double>(points);
    });
    within += mean_square - mean * mean;
    sum += mean;
    squares += mean_square;
  }
  const auto total = [](const dvec3& v) { return v.x + v.y + v.z; };
  const double n = static_cast<double>(probes), variance = total(squares / n - (sum / n) * (sum / n));
  // Rounding makes the variance of what is even.
  return variance > 1e-9 * total(squares / n) ? total(within / n) / variance : 0;
}

// A triangle whose texels are baked.
class Facet {
 public:
  Facet(const TriangleMesh& mesh, std::size_t k) : mesh_(&mesh), corners_(mesh.triangles[k]) {
    const auto& p = mesh.positions;
    const vec3 across = glm::cross(p[corners_[1]] - p[corners_[0]], p[corners_[2]] - p[corners_[0]]);
    const float length = glm::length(across);
    area_ = std::isfinite(length) ? 0.5f * length : 0;
    if (area_ > 0) normal_ = across / length;
  }
  float area() const { return area_; }
  float longest_leg() const {
    const auto& p = mesh_->positions;
    return std::max(glm::length(p[corners_[1]] - p[corners_[0]]), glm::length(p[corners_[2]] - p[corners_[0]]));
  }
  // `b`: along the legs.
  TexturePlace at(const vec2& b) const {
    const float w[3] = {1 - b.x - b.y, b.x, b.y};
    TexturePlace place{vec2(0), vec3(0), normal_};
    for (int c = 0; c < 3; ++c) {
      place.uv += w[c] * mesh_->uv(corners_, c);
      place.position += w[c] * mesh_->positions[corners_[c]];
    }
    return place;
  }

 private:
  const TriangleMesh* mesh_;
  uvec3 corners_;
  vec3 normal_{0, 0, 1};
  float area_ = 0;
};

// The texels of the triangle `k`.
void bake_triangle(const FieldToBake& what, const TriangleMesh& mesh, const Cell& cell, int across, std::size_t k,
                   ImageTexture& image) {
  const ivec2 corner = cell.corner(static_cast<std::uint32_t>(k));
  const Facet facet(mesh, k);
  for (int j = 0; j < cell.side; ++j)
    for (int i = 0; i < cell.side; ++i)
      if (cell.is_upper(i, j) == (k % 2 == 1))
        image.texels[static_cast<std::size_t>(corner.y + j) * image.size.x + corner.x + i] = mean_over_texel(
            across, [&](const vec2& offset) { return baked(*what.field, what.values, facet.at(cell.legs_at(i, j, offset))); });
}

// Chooses texels of an atlas by the area that they are seen on.
class AtlasProbe {
 public:
  AtlasProbe(const TriangleMesh& mesh, const Cell& cell) : mesh_(&mesh), texels_of_leg_(static_cast<float>(cell.leg)) {
    areas_.reserve(mesh.triangles.size());
    double sum = 0;
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
      const Facet facet(mesh, k);
      areas_.push_back(sum += facet.area());
      spacing_ = std::max(spacing_, facet.longest_leg() / texels_of_leg_);
    }
  }
  float spacing() const { return spacing_; }  // of the coarsest triangle's texels
  double share_within(const FieldToBake& what, std::size_t texels) const {
    return share_within_texels(texels, [&](Pcg32& rng) {
      const auto found = std::upper_bound(areas_.begin(), areas_.end() - 1, rng.next_float() * areas_.back());
      vec2 b(rng.next_float(), 0);
      b.y = rng.next_float();
      if (b.x + b.y > 1) b = 1.0f - b;
      return [this, &what, b, facet = Facet(*mesh_, static_cast<std::size_t>(found - areas_.begin()))](const vec2& offset) {
        return baked(*what.field, what.values, facet.at(b + offset / texels_of_leg_));
      };
    });
  }

 private:
  const TriangleMesh* mesh_;
  float texels_of_leg_, spacing_ = 0;
  std::vector<double> areas_;  // of the triangles up to each, summed up
};

// Apart from each other, each triangle at its place in the atlas.
TriangleMesh in_atlas(TriangleMesh&& mesh, const Cell& cell, const ivec2& size) {
  TriangleMesh apart{.positions = {}, .normals = {}, .uvs = {}, .triangles = {}, .warnings = std::move(mesh.warnings)};
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
    const uvec3 t = mesh.triangles[k];
    const bool upper = k % 2 == 1;
    for (int c = 0; c < 3; ++c) {
      const ivec2 along = cell.leg * ivec2(c == 1, c == 2);
      const ivec2 texel = cell.corner(static_cast<std::uint32_t>(k)) + (upper ? ivec2(cell.side - 1) - along : along);
      const vec2 share = (vec2(texel) + 0.5f) / vec2(size);
      apart.positions.push_back(mesh.positions[t[c]]);
      if (!mesh.normals.empty()) apart.normals.push_back(mesh.normals[t[c]]);
      apart.uvs.emplace_back(share.x, 1 - share.y);
    }
    apart.triangles.push_back(static_cast<std::uint32_t>(3 * k) + uvec3(0, 1, 2));
  }
  apart.quads = std::move(mesh.quads);
  return apart;
}

}  // namespace

Rgb within_unit(Rgb value) {
  for (int c = 0; c < 3; ++c) value[c] = value[c] > 0 ? std::min(value[c], 1.0f) : 0;
  return value;
}

int BakeBudget::side(int wanted) {
  constexpr std::uint64_t fine = std::uint64_t{1} << 25, coarse = std::uint64_t{1} << 26;
  wanted = std::min(wanted, unless_fuzzed(4096, 8));
  const int side = texels_ < fine ? wanted : texels_ < coarse ? std::min(wanted, 256) : std::min(wanted, 32);
  texels_ += static_cast<std::uint64_t>(side) * side;
  return side;
}

int BakeBudget::points_across(double share_within) const {
  constexpr std::uint64_t fine = unless_fuzzed(std::uint64_t{1} << 23, std::uint64_t{0});  // texels: some seconds at 4 x 4
  return share_within < rough_share ? 1 : share_within > lost_share && texels_ <= fine ? 4 : 2;
}

BakedImage bake_over_uv(const TextureField& field, Baked values, const Bounds& uv_range, BakeBudget& budget) {
  const vec2 lower(uv_range.lower);
  vec2 extent = vec2(uv_range.upper) - lower;
  for (int i = 0; i < 2; ++i)
    if (!(extent[i] > 0 && std::isfinite(extent[i]))) extent[i] = 1;
  const float wanted = static_cast<float>(field.resolution) * std::max(extent.x, extent.y);
  int side = budget.side(static_cast<int>(std::clamp(wanted, 1024.0f, 4096.0f)));
  // The range's ends lie at the centres of the outermost texels, and offsets do not lead beyond them.
  const auto at = [&](const ivec2& texel, const vec2& offset) {
    const vec2 inside(glm::lessThan(glm::abs(2 * texel - (side - 1)), ivec2(side - 1)));
    const vec2 share = (vec2(texel) + offset * inside) / static_cast<float>(side - 1);
    return baked(field, values, {lower + vec2(share.x, 1 - share.y) * extent, vec3(0)});
  };
  const double within = share_within_texels(static_cast<std::size_t>(side) * side, [&](Pcg32& rng) {
    const float column = rng.next_float(), row = rng.next_float();
    return [&at, texel = 1 + ivec2(vec2(column, row) * static_cast<float>(side - 2))](const vec2& offset) {
      return at(texel, offset);
    };
  });
  if (within > lost_share) side = std::min(side, 1024);  // means in fewer texels are nearer than points in many
  const std::size_t texels = static_cast<std::size_t>(side) * side;
  const int across = budget.points_across(within);
  ImageTexture image{.size = ivec2(side), .texels = std::vector<Rgb>(texels)};
  const float shrunk = 1 - 1 / static_cast<float>(side);
  image.uv_scale = shrunk / extent;
  image.uv_offset = 0.5f / static_cast<float>(side) - lower * image.uv_scale;
  parallel_for(static_cast<std::size_t>(side), 8, [&](std::size_t row) {
    for (int i = 0; i < side; ++i)
      image.texels[row * static_cast<std::size_t>(side) + static_cast<std::size_t>(i)] =
          mean_over_texel(across, [&](const vec2& offset) { return at(ivec2(i, static_cast<int>(row)), offset); });
  });
  return {std::move(image), std::max(extent.x, extent.y) / static_cast<float>(side - 1), within > lost_share};
}

std::vector<BakedImage> bake_atlas(std::span<const FieldToBake> fields, TriangleMesh& mesh, BakeBudget& budget) {
  const std::size_t triangles = mesh.triangles.size();
  const Cell cell = cell_for(triangles, budget.side(1024));
  const ivec2 size = cell.size(triangles);
  const std::size_t texels = static_cast<std::size_t>(size.x) * size.y;
  require_memory(static_cast<double>(texels * fields.size()) * sizeof(Rgb), {}, "the baked texture", "fewer triangles");
  const AtlasProbe probe(mesh, cell);
  std::vector<BakedImage> images;
  for (const FieldToBake& what : fields) {
    const double within = probe.share_within(what, texels);
    const int across = budget.points_across(within);
    ImageTexture image{.size = size, .texels = std::vector<Rgb>(texels)};
    parallel_for(triangles, 64, [&](std::size_t k) { bake_triangle(what, mesh, cell, across, k, image); });
    images.push_back({std::move(image), probe.spacing(), within > lost_share});
  }
  mesh = in_atlas(std::move(mesh), cell, size);
  return images;
}

}  // namespace etendue
