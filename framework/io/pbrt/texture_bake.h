// Texture fields as images over one shape's surface.
//
// What depends on (u, v) alone becomes an image over the shape's range of them, 1024 texels wide or as fine as the images in
// it. What depends on the place becomes, on a surface over the unit square, an image over that; on a mesh, an atlas in which
// two triangles share a square of texels. Interpolation blurs edges by a texel.
//
// Where a field is rough at the scale of texels, each is the mean of 2 x 2 points across it, and of 4 x 4 where most of the
// field's variance lies within texels: what is finer becomes its mean.
#pragma once

#include "framework/io/mesh/mesh.h"
#include "framework/io/mesh/tessellate.h"
#include "framework/io/pbrt/texture_field.h"

namespace etendue {

// Values outside 0 .. 1, which no surface reflects, are clamped; NaN is 0.
Rgb within_unit(Rgb value);

// How many texels a scene's baked textures may take together before they become coarser, and their means are taken over fewer
// points.
class BakeBudget {
 public:
  int side(int wanted);                          // of a square image, which it counts
  int points_across(double share_within) const;  // each texel, by the share of the field's variance that lies within texels

 private:
  std::uint64_t texels_ = 0;
};

// Reflectances are within_unit; heights are what they are, and 0 where they are not finite.
enum class Baked : std::uint8_t { reflectance, heights };

struct BakedImage {
  ImageTexture image;
  float spacing = 0;          // of texels, in (u, v) or in metres; the widest, where that differs
  bool loses_detail = false;  // more than half of the field's variance lies within texels
};
BakedImage bake_over_uv(const TextureField& field, Baked values, const Bounds& uv_range, BakeBudget& budget);
// Gives the mesh, whose vertices are where the fields are to be evaluated, the atlas's texture coordinates; vertices are no
// longer shared. There is an image for each field.
struct FieldToBake {
  Field field;
  Baked values;
};
std::vector<BakedImage> bake_atlas(std::span<const FieldToBake> fields, TriangleMesh& mesh, BakeBudget& budget);

}  // namespace etendue
