#include "integrators/path_space/plane_moments.h"

namespace etendue {

namespace {

constexpr float ridge = 16;  // values without slope, one edge away from the centre

vec3 squares(const vec2& v) { return {v.x * v.x, v.y * v.y, v.x * v.y}; }

}  // namespace

PlaneMoments PlaneMoments::of(const vec2& place, const Rgb& value) {
  return {1, 1, place, squares(place), value, place.x * value, place.y * value, etendue::square(luminance(value))};
}

PlaneMoments& PlaneMoments::operator+=(const PlaneMoments& other) {
  count += other.count;
  squared_weights += other.squared_weights;
  place += other.place;
  place_square += other.place_square;
  value += other.value;
  value_x += other.value_x;
  value_y += other.value_y;
  square += other.square;
  return *this;
}

PlaneMoments& PlaneMoments::operator*=(float weight) {
  count *= weight;
  squared_weights *= weight * weight;
  place *= weight;
  place_square *= weight;
  value *= weight;
  value_x *= weight;
  value_y *= weight;
  square *= weight;
  return *this;
}

PlaneMoments PlaneMoments::in_coarser(const vec2& centre) const {
  const vec2 half = 0.5f * place;
  const vec3 mixed(2 * half.x * centre.x, 2 * half.y * centre.y, half.x * centre.y + half.y * centre.x);
  return {count,
          squared_weights,
          half + count * centre,
          0.25f * place_square + mixed + count * squares(centre),
          value,
          0.5f * value_x + centre.x * value,
          0.5f * value_y + centre.y * value,
          square};
}

// The plane through the values' centre. Its slope is limited so that it stays between zero and twice the mean within the cell;
// limiting the slope, rather than clamping the result, keeps the mean over the values' places.
Rgb PlaneMoments::fit(const vec2& at, const vec2& reach) const {
  const float share = 1 / count;
  const Rgb mean = share * value;
  const vec2 centre = share * place;
  const vec3 spread = share * (place_square + ridge * vec3(1, 1, 0)) - squares(centre);
  const Rgb along_x = share * value_x - centre.x * mean, along_y = share * value_y - centre.y * mean;
  const float determinant = spread.x * spread.y - spread.z * spread.z;
  if (!(determinant > 1e-6f * spread.x * spread.y)) return mean;  // on a line, but for rounding
  const float scale = 1 / determinant;
  const Rgb slope_x = scale * (spread.y * along_x - spread.z * along_y);
  const Rgb slope_y = scale * (spread.x * along_y - spread.z * along_x);
  const Rgb most =
      reach.x * glm::abs(slope_x) + reach.y * glm::abs(slope_y) + glm::abs(centre.x * slope_x + centre.y * slope_y);
  const Rgb kept = glm::clamp(mean / glm::max(most, Rgb(1e-30f)), Rgb(0), Rgb(1));
  return mean + kept * ((at.x - centre.x) * slope_x + (at.y - centre.y) * slope_y);
}

float PlaneMoments::variance() const {
  const float n = effective_count();
  if (n < 2) return square / count;  // of one value nothing is known: it may all be error
  return std::max(0.0f, square / count - etendue::square(luminance(value) / count)) / (1 - 1 / n);
}

bool PlaneMoments::is_valid() const {
  const bool finite = std::isfinite(count) && std::isfinite(squared_weights) && std::isfinite(place.x) &&
                      std::isfinite(place.y) && is_finite(place_square) && is_finite(value) && is_finite(value_x) &&
                      is_finite(value_y) && std::isfinite(square);
  return finite && squared_weights > 0 && squared_weights <= count && square >= 0 &&
         glm::all(glm::greaterThanEqual(value, Rgb(0)));
}

}  // namespace etendue
