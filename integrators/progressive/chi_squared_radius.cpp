#include "integrators/progressive/chi_squared_radius.h"

#include <numeric>

namespace etendue {

static_assert(RadiusPolicy<ChiSquaredRadius>);

namespace {

// The value that chi-squared stays below with probability 0.95, by degrees of freedom.
float chi_squared_limit(int degrees) {
  switch (degrees) {
    case 2:
      return 5.991f;
    case 5:
      return 11.070f;
    default:
      return 19.675f;  // 11
  }
}

// Sector of 60 degrees that (u, v) lies in, counted from the positive u axis. Without branches, which could not be predicted.
int sector_of(float u, float v) {
  constexpr float tan_60 = 1.7320508f;
  const bool lower = v < 0;
  const float x = tan_60 * (lower ? -u : u), y = std::abs(v);  // turned by half in the lower half
  return (y >= x) + (y < -x) + (lower ? 3 : 0);
}

}  // namespace

void ChiSquaredRadius::Observed::begin(const GatherDisc& disc, const GatherPoint& at, const Rgb&) {
  const Frame frame = Frame::from_normal(at.normal());
  tangent_ = frame.tangent;
  bitangent_ = frame.bitangent;
  half_squared_ = 0.5f * square(disc.radius);
}

void ChiSquaredRadius::Observed::add(const Rgb&, const vec3& offset, float distance_squared) {
  const int sector = sector_of(glm::dot(offset, tangent_), glm::dot(offset, bitangent_));
  ++counts[static_cast<std::size_t>(sector + (distance_squared > half_squared_) * sectors)];
}

ChiSquaredRadius::ChiSquaredRadius(InitialRadii radii, const Rules& rules) : rules_(rules) {
  pixels_.reserve(radii.size());
  for (const float r : radii) pixels_.push_back({r, first_count});
}

bool ChiSquaredRadius::looks_even(const std::array<std::uint32_t, parts>& counts, int rings_tested, bool odd) {
  const int across = odd ? sectors / 2 : sectors, tested = rings_tested * across;
  double sum = 0, squares = 0;
  for (int ring = 0; ring < rings_tested; ++ring)
    for (int s = 0; s < across; ++s) {
      const auto i = static_cast<std::size_t>(ring * sectors + s);
      const double count = odd ? counts[i] + counts[i + sectors / 2] : counts[i];
      sum += count;
      squares += count * count;
    }
  // sum (count - sum / tested)^2 / (sum / tested)
  return sum == 0 || squares * tested / sum - sum < chi_squared_limit(tested - 1);
}

void ChiSquaredRadius::update(std::size_t pixel, std::uint32_t, const Observed& observed) {
  Pixel& p = pixels_[pixel];
  for (std::size_t i = 0; i < parts; ++i) p.counts[i] += observed.counts[i];
  const auto total = std::accumulate(p.counts.begin(), p.counts.end(), std::uint64_t{0});
  if (static_cast<float>(total) < p.enough || looks_even(p.counts, rings, rules_.odd)) return;
  p.radius *= std::sqrt(looks_even(p.counts, 1, rules_.odd) ? 0.5f : 0.8f);
  p.enough *= rules_.beta;
  p.counts = {};
}

}  // namespace etendue
