#include "integrators/irradiance_cache_file.h"

#include <cmath>

namespace etendue {

namespace {

constexpr std::size_t record_bytes = 10 * 4 + 4 + 8 + 4 + 24 * 4 + 6 * 8;
constexpr std::size_t most_levels = 1 << 16;
constexpr std::uint32_t most_rounds = 1u << 30;  // so that adding iterations does not wrap

// A field that is added must be written and read below, and the format's number raised.
static_assert(sizeof(IrradianceEstimate) == 24 * sizeof(float) + 6 * sizeof(double));

// Reads and writes in one order: `io` is a ByteWriter's add or a ByteReader's take.
template <class Io, class History>
void transfer(const Io& io, History& h) {
  io(h.point.position), io(h.point.normal), io(h.point.geometric), io(h.point.pixel_width), io(h.point.depth);
  io(h.key), io(h.passes);
  auto& mean = h.mean;
  io(mean.irradiance), io(mean.inverse_distance), io(mean.nearest), io(mean.variance), io(mean.rotation), io(mean.translation);
  for (auto* matrix : {&mean.hessian, &mean.geometric}) io(matrix->xx), io(matrix->xy), io(matrix->yy);
}

bool is_finite(const mat3& m) { return etendue::is_finite(m[0]) && etendue::is_finite(m[1]) && etendue::is_finite(m[2]); }
bool is_finite(const TangentMatrix& m) { return std::isfinite(m.xx) && std::isfinite(m.xy) && std::isfinite(m.yy); }
bool is_unit(const vec3& v) { return std::abs(length_squared(v) - 1) < 1e-3f; }

bool is_valid(const RecordHistory& h) {
  const IrradianceEstimate& mean = h.mean;
  return etendue::is_finite(h.point.position) && is_unit(h.point.normal) && is_unit(h.point.geometric) &&
         h.point.pixel_width >= 0 && std::isfinite(h.point.pixel_width) && h.point.depth >= 0 && h.passes >= 1 &&
         etendue::is_finite(mean.irradiance) && mean.inverse_distance >= 0 && std::isfinite(mean.inverse_distance) &&
         mean.nearest >= 0 && mean.variance >= 0 && std::isfinite(mean.variance) && is_finite(mean.rotation) &&
         is_finite(mean.translation) && is_finite(mean.hessian) && is_finite(mean.geometric);
}

}  // namespace

std::string write_irradiance_cache(const SavedIrradianceCache& cache, std::span<const std::span<const RecordHistory>> levels) {
  ByteWriter out;
  out.add(cache.view), out.add(cache.key_salt), out.add(cache.rounds), out.add(cache.accuracy);
  out.add(static_cast<std::uint64_t>(levels.size()));
  for (const auto& histories : levels) {
    out.add(static_cast<std::uint64_t>(histories.size()));
    for (const RecordHistory& history : histories) transfer([&](const auto& value) { out.add(value); }, history);
  }
  return out.bytes;
}

SavedIrradianceCache read_irradiance_cache(std::string_view body, bool one_level, const Location& where) {
  ByteReader in(body, where);
  SavedIrradianceCache cache;
  in.take(cache.view), in.take(cache.key_salt), in.take(cache.rounds), in.take(cache.accuracy);
  if (!(cache.accuracy > 0) || !std::isfinite(cache.accuracy)) in.refuse("its accuracy is no positive number");
  if (cache.rounds > most_rounds) in.refuse("more iterations than can be");
  const std::size_t levels = in.take_count(sizeof(std::uint64_t));
  if (levels > (one_level ? 1 : most_levels)) in.refuse("more levels than depths");
  for (std::size_t i = 0; i < levels; ++i) {
    auto& histories = cache.levels.emplace_back(in.take_count(record_bytes));
    for (RecordHistory& history : histories) {
      transfer([&](auto& value) { in.take(value); }, history);
      if (!is_valid(history) || (!one_level && static_cast<std::size_t>(history.point.depth) != i))
        in.refuse("a record holds what none can");
    }
  }
  if (!in.left().empty()) in.refuse("bytes are left over");
  return cache;
}

}  // namespace etendue
