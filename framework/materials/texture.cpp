#include "framework/materials/texture.h"

namespace etendue {

namespace {

int modulo(int i, int size) {
  i %= size;
  return i < 0 ? i + size : i;
}

// Gives the origin where single precision does not hold the place.
template <class Mapped>
vec2 mapped(const Mapped& t, const vec2& uv) {
  const vec2 st = uv * t.uv_scale + t.uv_offset;
  return is_finite({st, 0}) ? st : vec2(0);
}

// A coordinate moved to where texels have numbers, and to the same texels.
float folded(float s, Wrap wrap) {
  if (wrap == Wrap::repeat) return s - std::floor(s);
  return wrap == Wrap::mirror ? s - 2 * std::floor(0.5f * s) : std::clamp(s, -1.0f, 2.0f);
}

// Takes a folded coordinate, -1 to size, which needs no division where an image repeats.
int wrapped(int i, int size, Wrap wrap) {
  switch (wrap) {
    case Wrap::repeat:
      return i < 0 ? i + size : i >= size ? i - size : i;
    case Wrap::mirror:
      return i = modulo(i, 2 * size), i < size ? i : 2 * size - 1 - i;
    case Wrap::clamp:
      return std::clamp(i, 0, size - 1);
    case Wrap::black:
      break;
  }
  return i < 0 || i >= size ? -1 : i;
}

// The four texels around a place, and where it is between them.
struct FourTexels {
  const Rgb *top_left, *top_right, *bottom_left, *bottom_right;
  vec2 at;

  FourTexels() = default;
  FourTexels(const ImageTexture& t, const vec2& uv) {
    static const Rgb black{0};
    const vec2 st = mapped(t, uv);
    const float x = folded(st.x, t.wrap_u) * static_cast<float>(t.size.x) - 0.5f;
    const float y = (1 - folded(st.y, t.wrap_v)) * static_cast<float>(t.size.y) - 0.5f;
    const float fx = std::floor(x), fy = std::floor(y);
    const int left = static_cast<int>(fx), top = static_cast<int>(fy);
    const int x0 = wrapped(left, t.size.x, t.wrap_u), x1 = wrapped(left + 1, t.size.x, t.wrap_u);
    const int y0 = wrapped(top, t.size.y, t.wrap_v), y1 = wrapped(top + 1, t.size.y, t.wrap_v);
    const auto texel = [&](int i, int j) {
      return i < 0 || j < 0 ? &black : &t.texels[static_cast<std::size_t>(j) * t.size.x + i];
    };
    top_left = texel(x0, y0);
    top_right = texel(x1, y0);
    bottom_left = texel(x0, y1);
    bottom_right = texel(x1, y1);
    at = {x - fx, y - fy};
  }

  void prefetch() const {
    for (const Rgb* texel : {top_left, top_right, bottom_left, bottom_right}) __builtin_prefetch(texel);
  }
  Rgb mixed() const {
    const Rgb top = glm::mix(*top_left, *top_right, at.x);
    const Rgb bottom = glm::mix(*bottom_left, *bottom_right, at.x);
    return glm::mix(top, bottom, at.y);
  }
};

struct Evaluate {
  const vec2& uv;

  Rgb operator()(const ImageTexture& t) const { return t.gain * FourTexels(t, uv).mixed(); }
  Rgb operator()(const CheckerTexture& t) const {
    const vec2 st = glm::floor(mapped(t, uv));
    return std::fmod(std::abs(st.x + st.y), 2.0f) == 0 ? t.even : t.odd;
  }
};

struct Slope {
  const vec2& uv;

  vec2 operator()(const ImageTexture& t) const {
    const FourTexels f(t, uv);
    const Rgb right = glm::mix(*f.top_right - *f.top_left, *f.bottom_right - *f.bottom_left, f.at.y);
    const Rgb down = glm::mix(*f.bottom_left - *f.top_left, *f.bottom_right - *f.top_right, f.at.x);
    return t.gain * vec2(mean_component(right), -mean_component(down)) * vec2(t.size) * t.uv_scale;
  }
  vec2 operator()(const CheckerTexture&) const { return vec2(0); }
};

}  // namespace

Rgb evaluate(const Texture& texture, const vec2& uv) { return std::visit(Evaluate{uv}, texture); }

void evaluate(const Texture& texture, std::span<const vec2> uvs, Rgb* colours) {
  constexpr std::size_t at_once = 16;
  FourTexels texels[at_once];
  const auto* image = std::get_if<ImageTexture>(&texture);
  for (std::size_t first = 0; first < uvs.size(); first += at_once) {
    const std::size_t end = std::min(first + at_once, uvs.size());
    for (std::size_t i = first; image != nullptr && i < end; ++i) {
      texels[i - first] = FourTexels(*image, uvs[i]);
      texels[i - first].prefetch();
    }
    for (std::size_t i = first; i < end; ++i)
      colours[i] = image != nullptr ? image->gain * texels[i - first].mixed() : evaluate(texture, uvs[i]);
  }
}

vec2 slope(const Texture& texture, const vec2& uv) { return std::visit(Slope{uv}, texture); }

}  // namespace etendue
