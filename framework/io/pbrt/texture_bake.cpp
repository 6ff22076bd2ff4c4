#include "framework/io/pbrt/texture_bake.h"

#include "framework/core/fuzzing.h"
#include "framework/core/memory.h"
#include "framework/core/parallel.h"

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

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
  vec2 legs_at(int i, int j) const {
    return vec2(is_upper(i, j) ? ivec2(side - 1 - i, side - 1 - j) : ivec2(i, j)) / static_cast<float>(leg);
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

// The texels of the triangle `k`.
void bake_triangle(const FieldToBake& what, const TriangleMesh& mesh, const Cell& cell, std::size_t k, ImageTexture& image) {
  const uvec3 t = mesh.triangles[k];
  const ivec2 corner = cell.corner(static_cast<std::uint32_t>(k));
  const auto& p = mesh.positions;
  const vec3 across = glm::cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
  const float area = glm::length(across);
  const vec3 normal = area > 0 && std::isfinite(area) ? across / area : vec3(0, 0, 1);
  for (int j = 0; j < cell.side; ++j)
    for (int i = 0; i < cell.side; ++i) {
      if (cell.is_upper(i, j) != (k % 2 == 1)) continue;
      const vec2 b = cell.legs_at(i, j);
      const float w[3] = {1 - b.x - b.y, b.x, b.y};
      TexturePlace place{vec2(0), vec3(0), normal};
      for (int c = 0; c < 3; ++c) {
        place.uv += w[c] * mesh.uv(t, c);
        place.position += w[c] * mesh.positions[t[c]];
      }
      image.texels[static_cast<std::size_t>(corner.y + j) * image.size.x + corner.x + i] =
          baked(*what.field, what.values, place);
    }
}

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

ImageTexture bake_over_uv(const TextureField& field, Baked values, const Bounds& uv_range, BakeBudget& budget) {
  const vec2 lower(uv_range.lower);
  vec2 extent = vec2(uv_range.upper) - lower;
  for (int i = 0; i < 2; ++i)
    if (!(extent[i] > 0 && std::isfinite(extent[i]))) extent[i] = 1;
  const float wanted = static_cast<float>(field.resolution) * std::max(extent.x, extent.y);
  const int side = budget.side(static_cast<int>(std::clamp(wanted, 1024.0f, 4096.0f)));
  ImageTexture image{.size = ivec2(side), .texels = {}};
  // The range's ends lie at the centres of the outermost texels.
  const float shrunk = 1 - 1 / static_cast<float>(side);
  image.uv_scale = shrunk / extent;
  image.uv_offset = 0.5f / static_cast<float>(side) - lower * image.uv_scale;
  image.texels.resize(static_cast<std::size_t>(side) * side);
  parallel_for(static_cast<std::size_t>(side), 8, [&](std::size_t row) {
    for (int i = 0; i < side; ++i) {
      const vec2 share(static_cast<float>(i) / static_cast<float>(side - 1),
                       1 - static_cast<float>(row) / static_cast<float>(side - 1));
      const vec2 uv = lower + share * extent;
      image.texels[row * static_cast<std::size_t>(side) + static_cast<std::size_t>(i)] = baked(field, values, {uv, vec3(0)});
    }
  });
  return image;
}

std::vector<ImageTexture> bake_atlas(std::span<const FieldToBake> fields, TriangleMesh& mesh, BakeBudget& budget) {
  const std::size_t triangles = mesh.triangles.size();
  const Cell cell = cell_for(triangles, budget.side(1024));
  const ivec2 size = cell.size(triangles);
  const std::size_t texels = static_cast<std::size_t>(size.x) * size.y;
  require_memory(static_cast<double>(texels * fields.size()) * sizeof(Rgb), {}, "the baked texture", "fewer triangles");
  std::vector<ImageTexture> images;
  for (const FieldToBake& what : fields) {
    ImageTexture& image = images.emplace_back(ImageTexture{.size = size, .texels = std::vector<Rgb>(texels)});
    parallel_for(triangles, 64, [&](std::size_t k) { bake_triangle(what, mesh, cell, k, image); });
  }
  mesh = in_atlas(std::move(mesh), cell, size);
  return images;
}

}  // namespace etendue
