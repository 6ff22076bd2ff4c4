// The mean of a record of rough surfaces, on disk (record_file.h): f32 inverse distance, variance; f32 coefficients, as many as
// the scene's order asks for.
#include "integrators/caches/records/record_file.h"
#include "integrators/caches/rough_cache.h"

namespace etendue {

template <class Io, class Estimate>
requires std::is_same_v<std::remove_const_t<Estimate>, RadianceEstimate>
void transfer(const Io& io, Estimate& mean) {
  io(mean.inverse_distance), io(mean.variance);
  for (auto& c : mean.coefficients) io(c);
}

bool is_valid(const RadianceEstimate& mean) {
  for (const Rgb& c : mean.coefficients)
    if (!is_finite(c)) return false;
  return mean.inverse_distance >= 0 && std::isfinite(mean.inverse_distance) && mean.variance >= 0 &&
         std::isfinite(mean.variance);
}

void RoughCache::write(ByteWriter& out) const { write_levels(out, histories()); }

void RoughCache::read(const RenderContext& context, ByteReader& in, bool one_level) {
  choose_orders(context.scene);
  saved_.clear();
  if (!active()) return;
  RadianceEstimate empty;
  empty.coefficients.resize(3 * static_cast<std::size_t>(order_) * order_);
  saved_ = read_levels(in, one_level, empty);
}

void RoughCache::resume(const RenderContext& context, float accuracy, std::uint64_t key_salt, bool refine) {
  if (!refine) settings_.accuracy = std::min(settings_.accuracy, accuracy);
  RecordLevels::resume(context, std::move(saved_), accuracy, key_salt);
  saved_.clear();
}

}  // namespace etendue
