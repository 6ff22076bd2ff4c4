// Textures as functions of a place on a surface: pbrt's procedural ones, and whatever is composed of textures that vary. No
// material looks them up; they are baked into images, shape by shape (texture_bake.h).
#pragma once

#include "framework/io/pbrt/params.h"
#include "framework/materials/texture.h"
#include "framework/scene/transform.h"

#include <functional>
#include <memory>

namespace etendue {

struct TexturePlace {
  vec2 uv;
  vec3 position;         // in the world, or in the space of the object that is being defined
  vec3 normal{0, 0, 1};  // of the surface there, unit
};

struct TextureField {
  std::function<Rgb(const TexturePlace&)> at;
  bool uses_position = false;
  int resolution = 0;  // texels over a unit of u or v that images in it have
  int cost = 1;        // textures that are evaluated: those composed of themselves would grow without end
};
using Field = std::shared_ptr<const TextureField>;

Field constant_field(const Rgb& value);
Field texture_field(const Texture& texture);
// A function of a field's value.
Field mapped_field(const Field& field, const std::function<Rgb(const Rgb&)>& map);
// Throws Error at `params` where the fields together cost too much.
Field combined_field(const PbrtParams& params, std::vector<Field> fields,
                     const std::function<Rgb(const TexturePlace&, std::span<const Field>)>& combine);

// Says where a two-dimensional texture is looked up: "uv", "planar", "spherical" or "cylindrical".
struct TextureMapping {
  enum class Kind : std::uint8_t { uv, planar, spherical, cylindrical } kind = Kind::uv;
  vec2 scale{1}, offset{0};
  vec3 v1{1, 0, 0}, v2{0, 1, 0};
  Transform to_texture;  // from the world
  bool version3;

  TextureMapping(const PbrtParams& params, const Transform& to_world, bool version3);
  bool is_uv() const { return kind == Kind::uv; }
  vec2 at(const TexturePlace& place) const;
};

// The textures that are functions of their place alone: dots, uv, bilerp, fbm, wrinkled, windy, marble. Another type
// gives null. `colour(name, otherwise)` reads an operand.
using ReadOperand = std::function<Field(std::string_view name, const Rgb& otherwise)>;
Field procedural_field(const std::string& type, const PbrtParams& params, const Transform& to_world, bool version3,
                       const ReadOperand& operand);
Field checkerboard_field(const PbrtParams& params, const Transform& to_world, bool version3, const ReadOperand& operand);
// Mixes by the angle between the surface and a direction ("directionmix").
Field direction_mix_field(const PbrtParams& params, const Transform& to_world, const ReadOperand& operand);
// An image under any mapping.
Field image_field(ImageTexture image, const TextureMapping& mapping);

// The mean over the unit square of (u, v), and over a block of space where the field depends on it.
Rgb mean_of(const Field& field);

}  // namespace etendue
