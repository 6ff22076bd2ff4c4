#include "integrators/caches/records/record_file.h"

#include "integrators/paths/sample_shares.h"

namespace etendue {

namespace {

bool is_finite(const mat3& m) { return etendue::is_finite(m[0]) && etendue::is_finite(m[1]) && etendue::is_finite(m[2]); }
bool is_finite(const TangentMatrix& m) { return std::isfinite(m.xx) && std::isfinite(m.xy) && std::isfinite(m.yy); }

std::uint64_t view_of(const RenderContext& context) {
  return hash_keys(context.scene.hash(), context.resolution.x, context.resolution.y, context.seed);
}

}  // namespace

bool is_unit(const vec3& v) { return std::abs(length_squared(v) - 1) < 1e-3f; }

bool is_valid(const CachePoint& point) {
  return etendue::is_finite(point.position) && is_unit(point.normal) && is_unit(point.geometric) &&
         etendue::is_finite(point.origin) && point.pixel_width >= 0 && std::isfinite(point.pixel_width) && point.depth >= 0;
}

bool is_valid(const IrradianceEstimate& mean) {
  return etendue::is_finite(mean.irradiance) && mean.inverse_distance >= 0 && std::isfinite(mean.inverse_distance) &&
         mean.nearest >= 0 && mean.variance >= 0 && std::isfinite(mean.variance) && mean.shared_variance >= 0 &&
         std::isfinite(mean.shared_variance) && is_finite(mean.rotation) && is_finite(mean.translation) &&
         is_finite(mean.hessian) && is_finite(mean.geometric);
}

void CacheStanding::write(ByteWriter& out, float accuracy) const {
  out.add(view_), out.add(key_salt_), out.add(rounds_), out.add(stage_), out.add(spacing_), out.add(accuracy);
}

void CacheStanding::read(ByteReader& in) {
  in.take(view_), in.take(key_salt_), in.take(rounds_), in.take(stage_), in.take(spacing_), in.take(accuracy_);
  if (!(accuracy_ > 0) || !std::isfinite(accuracy_)) in.refuse("its accuracy is no positive number");
  if (rounds_ > SampleShares::most_first || stage_ > SampleShares::most_first || spacing_ > stage_)
    in.refuse("more iterations than can be");
  loaded_ = true;
}

void CacheStanding::begin(const RenderContext& context, bool has_overture) {
  const std::uint64_t view = view_of(context);
  same_view_ = loaded_ && view == view_;
  if (loaded_ && !same_view_) key_salt_ = view;
  view_ = view;
  first_round_ = rounds_;
  cut_short_ = loaded_ && !has_overture && stage_ < CacheProgress::overture_stages;
  if (!has_overture) stage_ = std::max(stage_, CacheProgress::overture_stages);
  if (!loaded_) spacing_ = stage_;
}

float CacheStanding::accuracy_wanted(const CacheProgress& progress) {
  if (!progress.refines) return std::min(accuracy_, progress.accuracy);
  if (cut_short_ || progress.accuracy_at(spacing_) != accuracy_) spacing_ = stage_;
  return progress.accuracy_at(spacing_);
}

}  // namespace etendue
