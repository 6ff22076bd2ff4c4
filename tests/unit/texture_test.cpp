// Textures beyond their edges, at many places at once, and their slopes.
#include "framework/materials/texture.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

// Columns 0, 1, 2 and 3 from the left, alike in all rows.
ImageTexture four_columns(Wrap wrap) {
  ImageTexture image{.size = {4, 2}, .texels = {}};
  for (int i = 0; i < 8; ++i) image.texels.emplace_back(static_cast<float>(i % 4));
  image.wrap_u = image.wrap_v = wrap;
  return image;
}

float at(Wrap wrap, float u) { return evaluate(four_columns(wrap), {u, 0.5f}).x; }

TEST(Textures, WrapEachTexel) {
  for (const Wrap wrap : {Wrap::repeat, Wrap::mirror, Wrap::clamp, Wrap::black}) EXPECT_FLOAT_EQ(at(wrap, 0.5f), 1.5f);
  EXPECT_FLOAT_EQ(at(Wrap::repeat, 1), 1.5f) << "half way from the last to the first";
  EXPECT_FLOAT_EQ(at(Wrap::repeat, -0.875f), 0);
  EXPECT_FLOAT_EQ(at(Wrap::mirror, 1), 3);
  EXPECT_FLOAT_EQ(at(Wrap::mirror, 1.375f), 2);
  EXPECT_FLOAT_EQ(at(Wrap::mirror, -0.375f), 1);
  EXPECT_FLOAT_EQ(at(Wrap::clamp, 7), 3);
  EXPECT_FLOAT_EQ(at(Wrap::clamp, -7), 0);
  EXPECT_FLOAT_EQ(at(Wrap::black, 1), 1.5f) << "half way from the last to black";
  EXPECT_FLOAT_EQ(at(Wrap::black, 1.125f), 0);
  EXPECT_FLOAT_EQ(at(Wrap::black, 1e30f), 0);
  EXPECT_FLOAT_EQ(evaluate(four_columns(Wrap::black), {0.375f, 1}).x, 0.5f);
  EXPECT_FLOAT_EQ(evaluate(four_columns(Wrap::black), {0.375f, 0}).x, 0.5f);
}

TEST(Textures, GiveManyPlacesTheSameBits) {
  std::vector<vec2> uvs;
  for (int i = 0; i < 37; ++i) uvs.emplace_back(0.0731f * static_cast<float>(i) - 1.2f, 1.3f - 0.0917f * static_cast<float>(i));
  const auto compare = [&](const Texture& texture) {
    std::vector<Rgb> colours(uvs.size());
    evaluate(texture, uvs, colours.data());
    for (std::size_t i = 0; i < uvs.size(); ++i) EXPECT_EQ(colours[i], evaluate(texture, uvs[i])) << i;
  };
  for (const Wrap wrap : {Wrap::repeat, Wrap::mirror, Wrap::clamp, Wrap::black}) compare(four_columns(wrap));
  compare(CheckerTexture{});
}

TEST(Textures, HaveTheSlopeOfTheirValues) {
  ImageTexture image{.size = {3, 4}, .texels = {}, .uv_scale = {2, -3}, .uv_offset = {0.1f, 0.2f}, .gain = 0.5f};
  for (int i = 0; i < 12; ++i) image.texels.emplace_back(static_cast<float>(i * i % 7), static_cast<float>(i % 5), 1);
  for (const Wrap wrap : {Wrap::repeat, Wrap::mirror, Wrap::clamp, Wrap::black}) {
    image.wrap_u = image.wrap_v = wrap;
    for (int i = 0; i < 200; ++i) {
      const vec2 uv(0.0137f * static_cast<float>(i) - 1, 0.0071f * static_cast<float>((i * 37) % 200) - 0.7f);
      constexpr float step = 1e-3f;
      const auto height = [&](const vec2& offset) { return mean_component(evaluate(image, uv + offset)); };
      const vec2 found = slope(image, uv);
      const float right = (height({step, 0}) - height({0, 0})) / step, left = (height({0, 0}) - height({-step, 0})) / step;
      const float up = (height({0, step}) - height({0, 0})) / step, down = (height({0, 0}) - height({0, -step})) / step;
      // At the edges of texels, the two sides differ.
      if (std::abs(right - left) < 1e-2f) {
        EXPECT_NEAR(found.x, 0.5f * (left + right), 2e-2f) << uv.x << ' ' << uv.y;
      }
      if (std::abs(up - down) < 1e-2f) {
        EXPECT_NEAR(found.y, 0.5f * (up + down), 2e-2f) << uv.x << ' ' << uv.y;
      }
    }
  }
  EXPECT_EQ(slope(CheckerTexture{}, {0.3f, 0.4f}), vec2(0));
}

}  // namespace
}  // namespace etendue
