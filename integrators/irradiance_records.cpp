#include "integrators/irradiance_records.h"

namespace etendue {

IrradianceRecord make_record(const vec3& position, const vec3& normal, const IrradianceEstimate& estimate, Gradients gradients,
                             float accuracy, float min_spacing, float max_spacing) {
  IrradianceRecord record{position, normal, estimate.harmonic_distance, estimate.irradiance};
  if (gradients != Gradients::none) record.rotation = estimate.rotation;
  const float brightness = luminance(estimate.irradiance);
  float steepness = 0;
  if (gradients == Gradients::both) {
    record.translation = estimate.translation;
    const auto& g = estimate.translation;
    steepness = glm::length(0.2126f * g[0] + 0.7152f * g[1] + 0.0722f * g[2]);
    if (steepness > 0) record.reach = std::min(record.reach, brightness / steepness);
  }
  record.reach = std::clamp(record.reach, min_spacing / accuracy, std::max(min_spacing, max_spacing) / accuracy);
  if (steepness * record.reach > brightness) record.translation *= brightness / (steepness * record.reach);
  return record;
}

float IrradianceRecords::weight(const IrradianceRecord& record, const vec3& position, const vec3& normal) const {
  const vec3 offset = position - record.position;
  const float cosine = glm::dot(normal, record.normal);
  const float error = glm::length(offset) / record.reach + safe_sqrt(1 - cosine);
  if (!(error < accuracy_)) return 0;
  // In front by more than rounding and curvature explain.
  if (0.5f * glm::dot(offset, normal + record.normal) < -0.02f * record.reach) return 0;
  return 1 / std::max(error, 1e-4f) - 1 / accuracy_;
}

void IrradianceRecords::insert(IrradianceRecord record) {
  if (clamp_) {
    // All pairs, so quadratic in the number of records: some nanoseconds each, small beside the rays of a record up to some
    // hundred thousand records of a thousand rays. The least of R_j + |p_i - p_j| over all records obeys
    // the triangle inequality, so the order of insertion does not matter. Balls are not shrunk: `weight` decides.
    for (const IrradianceRecord& other : records_)
      record.reach = std::min(record.reach, other.reach + glm::length(record.position - other.position));
    for (IrradianceRecord& other : records_)
      other.reach = std::min(other.reach, record.reach + glm::length(record.position - other.position));
  }
  balls_->insert(record.position, accuracy_ * record.reach, static_cast<std::uint32_t>(records_.size()));
  records_.push_back(record);
}

bool IrradianceRecords::covered(const vec3& position, const vec3& normal) const {
  static thread_local Neighbours found;
  balls_->covering(position, found);
  for (const Neighbour& n : found)
    if (weight(records_[n.id], position, normal) > 0) return true;
  return false;
}

std::optional<Rgb> IrradianceRecords::interpolate(const vec3& position, const vec3& normal) const {
  static thread_local Neighbours found;
  balls_->covering(position, found);
  Rgb sum(0);
  float weights = 0;
  for (const Neighbour& n : found) {
    const IrradianceRecord& record = records_[n.id];
    const float w = weight(record, position, normal);
    if (!(w > 0)) continue;
    // Vector times matrix: a dot product per column, that is per channel ([Ward1992]).
    const Rgb here = record.irradiance + glm::cross(record.normal, normal) * record.rotation +
                     (position - record.position) * record.translation;
    sum += w * glm::max(here, Rgb(0));
    weights += w;
  }
  if (!(weights > 0)) return std::nullopt;
  return sum / weights;
}

}  // namespace etendue
