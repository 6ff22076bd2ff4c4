#include "integrators/caches/records/irradiance_records.h"

#include "integrators/caches/records/error_of_mean.h"

namespace etendue {

IrradianceRecord make_record(const vec3& position, const vec3& normal, const IrradianceEstimate& estimate, Gradients gradients,
                             CacheMetric metric, const MetricContext& context) {
  const ValidityRadius radius = metric_radius(metric, estimate, Frame::from_normal(normal), context);
  IrradianceRecord record{.position = position,
                          .normal = normal,
                          .validity_radius = std::min(radius.length, context.scene_size / context.accuracy),
                          .irradiance = estimate.irradiance,
                          .anisotropy = radius.anisotropy,
                          .variance = estimate.variance,
                          .shared_variance = estimate.shared_variance,
                          .least = radius.least};
  if (gradients != Gradients::none) record.rotation = estimate.rotation;
  if (gradients >= Gradients::both) {
    record.translation = estimate.translation;
    const float brightness = luminance(estimate.irradiance);
    // The bounded split sphere holds its whole validity radius to this, but for its least spacing; others what they serve.
    const float extent =
        metric == CacheMetric::bounded_split_sphere ? record.validity_radius : context.accuracy * record.validity_radius;
    if (const float change = steepness(estimate) * extent; change > brightness) record.translation *= brightness / change;
  }
  return record;
}

void IrradianceRecord::shorten(float length) {
  length = std::max(length, least);
  if (!(length < validity_radius)) return;
  // The narrow axis, the radius / sqrt(1 + anisotropy^2), stays unless it too is longer.
  const float ratio = length / validity_radius * std::sqrt(1 + length_squared(anisotropy));
  const float size = glm::length(anisotropy);
  if (size > 0) anisotropy *= safe_sqrt(ratio * ratio - 1) / size;
  validity_radius = length;
}

float IrradianceRecords::error(const IrradianceRecord& record, const vec3& position, const vec3& normal) const {
  const vec3 offset = position - record.position;
  const float cosine = glm::dot(normal, record.normal);
  const float away = std::sqrt(length_squared(offset) + square(glm::dot(offset, record.anisotropy))) / record.validity_radius;
  const float turn = safe_sqrt(1 - cosine);
  constexpr float ten_degrees = 0.12325683f;  // sqrt(1 - cos 10 degrees)
  const float error = weight_ == CacheWeight::ward ? away + turn : std::max(away, turn * (usual_accuracy / ten_degrees));
  if (!(error < farthest_) || cosine < 0) return infinity;  // however coarse: the other side of a wall sees another world
  // The record is in front by more than rounding and curvature explain.
  if (0.5f * glm::dot(offset, normal + record.normal) < -0.02f * std::min(accuracy_, 1.0f) * record.validity_radius)
    return infinity;
  return error;
}

void IrradianceRecords::insert(IrradianceRecord record) {
  const auto id = static_cast<std::uint32_t>(records_.size());
  if (clamps_) {
    // The least of R_j + clamp |p_i - p_j| over all records obeys the triangle inequality, so the order of insertion does not
    // matter. Spheres are not shrunk: `error` decides.
    record.shorten(validity_.limit(record.position, record.validity_radius));
    validity_.shorten_around(record.position, record.validity_radius,
                             [&](std::uint32_t other, float length) { records_[other].shorten(length); });
    validity_.insert(record.position, record.validity_radius, id);
  }
  index_->insert(record.position, farthest_ * record.validity_radius, id);
  records_.push_back(record);
}

bool IrradianceRecords::covered(const vec3& position, const vec3& normal) const {
  static thread_local Neighbours found;
  index_->covering(position, found);
  for (const Neighbour& n : found)
    if (error(records_[n.id], position, normal) < accuracy_) return true;
  return false;
}

Rgb IrradianceRecords::extrapolate(const IrradianceRecord& record, const vec3& position, const vec3& normal) {
  // Vector times matrix: a dot product per column, that is per channel ([Ward1992]).
  const Rgb here = record.irradiance + glm::cross(record.normal, normal) * record.rotation +
                   (position - record.position) * record.translation;
  return glm::max(here, Rgb(0));
}

std::optional<Interpolated> IrradianceRecords::interpolate(const vec3& position, const vec3& normal, bool states_error) const {
  static thread_local Neighbours found;
  index_->covering(position, found);
  Rgb sum(0);
  float weights = 0, least = infinity;
  ErrorOfMean error_of_mean;
  const IrradianceRecord* best = nullptr;
  for (const Neighbour& n : found) {
    const IrradianceRecord& record = records_[n.id];
    const float e = error(record, position, normal);
    if (e < least) {
      least = e;
      best = &record;
    }
    if (!(e < answers_)) continue;
    const float w = weight_ == CacheWeight::ward ? 1 / std::max(e, 1e-4f) - 1 / answers_ : 1 - e / answers_;
    const Rgb here = extrapolate(record, position, normal);
    sum += w * here;
    weights += w;
    if (states_error) error_of_mean.add(w, luminance(here), record.variance, record.shared_variance, e);
  }
  if (weights > 0) return Interpolated{sum / weights, least, error_of_mean.standard_error()};
  if (!best) return std::nullopt;
  const Rgb alone = extrapolate(*best, position, normal);
  if (states_error) error_of_mean.add(1, luminance(alone), best->variance, best->shared_variance, least);
  return Interpolated{alone, least, error_of_mean.standard_error()};
}

}  // namespace etendue
