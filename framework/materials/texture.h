// Textures over a surface's (u, v): constant, image (bilinear) and checkerboard.
#pragma once

#include "framework/core/vec.h"

#include <cstdint>
#include <span>
#include <variant>
#include <vector>

namespace etendue {

// Says what lies beyond the edges of an image. Each texel that interpolation asks for is wrapped on its own.
enum class Wrap : std::uint8_t { repeat, mirror, clamp, black };

struct ImageTexture {
  ivec2 size{0};
  std::vector<Rgb> texels;  // linear, row 0 at v = 1 as image files have it
  vec2 uv_scale{1}, uv_offset{0};
  float gain = 1;
  Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
};

struct CheckerTexture {
  Rgb even{1}, odd{0};
  vec2 uv_scale{1}, uv_offset{0};
};

using Texture = std::variant<ImageTexture, CheckerTexture>;

Rgb evaluate(const Texture& texture, const vec2& uv);
// At many places, whose texels are loaded together: large images lie far from the processor.
void evaluate(const Texture& texture, std::span<const vec2> uvs, Rgb* colours);
// The derivatives by u and v of the mean of the channels; a checkerboard is flat.
vec2 slope(const Texture& texture, const vec2& uv);

// A colour that is constant or, where `texture` is an index into Scene::textures, looked up.
struct TexturedRgb {
  Rgb constant{0};
  std::uint32_t texture = 0xffffffffu;

  TexturedRgb() = default;
  TexturedRgb(const Rgb& c) : constant(c) {}  // NOLINT(google-explicit-constructor): a colour is a texture
  bool is_constant() const { return texture == 0xffffffffu; }
};

inline Rgb evaluate(const TexturedRgb& colour, const std::vector<Texture>& textures, const vec2& uv) {
  return colour.is_constant() ? colour.constant : evaluate(textures[colour.texture], uv);
}

}  // namespace etendue
