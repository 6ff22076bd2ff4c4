// Of each level: u64 number of records; of each: f32 position[3], normal[3], geometric normal[3], pixel width; i32 depth; u64
// key; i32 passes; f32 inverse distance; f32 coefficients, as many as the scene's order asks for.
#include "integrators/rough_cache.h"

#include <cmath>

namespace etendue {

namespace {

constexpr std::size_t most_levels = 1 << 16;
constexpr std::size_t fixed_bytes = 10 * 4 + 4 + 8 + 4 + 4;

// Reads and writes in one order: `io` is a ByteWriter's add or a ByteReader's take.
template <class Io, class History>
void transfer(const Io& io, History& h) {
  io(h.point.position), io(h.point.normal), io(h.point.geometric), io(h.point.pixel_width), io(h.point.depth);
  io(h.key), io(h.passes), io(h.mean.inverse_distance);
  for (auto& c : h.mean.coefficients) io(c);
}

bool is_unit(const vec3& v) { return std::abs(length_squared(v) - 1) < 1e-3f; }

bool is_valid(const CachePoint& point, const RadianceEstimate& mean) {
  for (const Rgb& c : mean.coefficients)
    if (!is_finite(c)) return false;
  return is_finite(point.position) && is_unit(point.normal) && is_unit(point.geometric) && point.pixel_width >= 0 &&
         std::isfinite(point.pixel_width) && point.depth >= 0 && mean.inverse_distance >= 0 &&
         std::isfinite(mean.inverse_distance);
}

}  // namespace

void RoughCache::write(ByteWriter& out) const {
  const auto levels = histories();
  out.add(static_cast<std::uint64_t>(levels.size()));
  for (const auto& histories : levels) {
    out.add(static_cast<std::uint64_t>(histories.size()));
    for (const History& history : histories) transfer([&](const auto& value) { out.add(value); }, history);
  }
}

void RoughCache::read(const RenderContext& context, ByteReader& in, bool one_level) {
  choose_orders(context.scene);
  saved_.clear();
  if (active()) {
    const std::size_t coefficients = 3 * static_cast<std::size_t>(order_) * order_;
    const std::size_t levels = in.take_count(sizeof(std::uint64_t));
    if (levels > (one_level ? 1 : most_levels)) in.refuse("more levels than depths");
    for (std::size_t i = 0; i < levels; ++i) {
      auto& histories = saved_.emplace_back(in.take_count(fixed_bytes + coefficients * sizeof(Rgb)));
      for (History& history : histories) {
        history.mean.coefficients.resize(coefficients);
        transfer([&](auto& value) { in.take(value); }, history);
        if (!is_valid(history.point, history.mean) || history.passes < 1 ||
            (!one_level && static_cast<std::size_t>(history.point.depth) != i))
          in.refuse("a record holds what none can");
      }
    }
  }
  if (!in.left().empty()) in.refuse("bytes are left over");
}

void RoughCache::resume(const RenderContext& context, float accuracy, std::uint64_t key_salt, bool refine) {
  if (!refine) settings_.accuracy = std::min(settings_.accuracy, accuracy);
  RecordLevels::resume(context, std::move(saved_), accuracy, key_salt);
  saved_.clear();
}

}  // namespace etendue
