#include "accel/points/neighbourhood.h"

namespace etendue {

namespace {

constexpr std::size_t bins = 256;

// Points found on a surface are as many at each squared distance. So a counting sort by it leaves a few to a bin, which is
// faster than selecting by comparisons that are hardly predictable.
void sort_into_bins(const Neighbours& found, float bins_per_distance, std::size_t k, Neighbours& sorted) {
  const auto bin = [&](const Neighbour& n) {
    return std::min(static_cast<std::size_t>(n.distance_squared * bins_per_distance), bins - 1);
  };
  std::array<std::uint32_t, bins + 1> end{};  // behind a shift by one: counts, then where bins begin, then where they end
  for (const Neighbour& n : found) ++end[bin(n) + 1];
  for (std::size_t i = 1; i <= bins; ++i) end[i] += end[i - 1];
  sorted.resize(found.size());
  for (const Neighbour& n : found) sorted[end[bin(n)]++] = n;
  for (std::size_t i = 0, begin = 0; i < bins && begin < k; begin = end[i++])
    if (end[i] > begin + 1) std::sort(sorted.begin() + static_cast<std::ptrdiff_t>(begin), sorted.begin() + end[i], is_nearer);
}

}  // namespace

void keep_nearest(Neighbours& found, std::size_t k) {
  constexpr std::size_t few = 24;
  float farthest = 0;
  for (const Neighbour& n : found) farthest = std::max(farthest, n.distance_squared);
  const float bins_per_distance = bins / farthest;
  if (found.size() > few && bins_per_distance > 0 && bins_per_distance < infinity) {
    static thread_local Neighbours sorted;
    sort_into_bins(found, bins_per_distance, k, sorted);
    found.swap(sorted);
  } else {
    std::sort(found.begin(), found.end(), is_nearer);
  }
  if (k < found.size()) found.resize(k);
}

}  // namespace etendue
