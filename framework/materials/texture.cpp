#include "framework/materials/texture.h"

namespace etendue {

namespace {

int wrap(int i, int size) {
  i %= size;
  return i < 0 ? i + size : i;
}

struct Evaluate {
  vec2 uv;

  Rgb operator()(const ImageTexture& t) const {
    const vec2 st = mapped(t);
    const float x = (st.x - std::floor(st.x)) * static_cast<float>(t.size.x) - 0.5f;
    const float y = (1 - (st.y - std::floor(st.y))) * static_cast<float>(t.size.y) - 0.5f;
    const float fx = std::floor(x), fy = std::floor(y);
    const int x0 = wrap(static_cast<int>(fx), t.size.x), y0 = wrap(static_cast<int>(fy), t.size.y);
    const int x1 = wrap(x0 + 1, t.size.x), y1 = wrap(y0 + 1, t.size.y);
    const auto texel = [&](int i, int j) { return t.texels[static_cast<std::size_t>(j) * t.size.x + i]; };
    const Rgb top = glm::mix(texel(x0, y0), texel(x1, y0), x - fx);
    const Rgb bottom = glm::mix(texel(x0, y1), texel(x1, y1), x - fx);
    return t.gain * glm::mix(top, bottom, y - fy);
  }
  Rgb operator()(const CheckerTexture& t) const {
    const vec2 st = glm::floor(mapped(t));
    return std::fmod(std::abs(st.x + st.y), 2.0f) == 0 ? t.even : t.odd;
  }

 private:
  // Gives the origin where single precision does not hold the place.
  template <class Mapped>
  vec2 mapped(const Mapped& t) const {
    const vec2 st = uv * t.uv_scale + t.uv_offset;
    return is_finite({st, 0}) ? st : vec2(0);
  }
};

}  // namespace

Rgb evaluate(const Texture& texture, const vec2& uv) { return std::visit(Evaluate{uv}, texture); }

}  // namespace etendue
