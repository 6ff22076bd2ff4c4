#include "integrators/irradiance_records.h"

namespace etendue {

namespace {

// The error of a weighted mean of what records say: from their own variances, or from how far they disagree where that tells of
// more (gradients have noise too, and interpolation errs in each record by itself), and from what they all leave out.
class ErrorOfMean {
 public:
  void add(float weight, float said, float variance, float error) {
    const double w = weight;
    weights_ += w;
    squared_weights_ += w * w;
    said_ += w * said;
    squares_ += w * said * said;
    noise_ += w * w * variance;
    remainder_ += w * 0.5 * error * error * said;
  }

  float standard_error() const {
    const double mean = said_ / weights_, spread = std::max(0.0, squares_ / weights_ - mean * mean);
    const double share = squared_weights_ / (weights_ * weights_);  // 1 / n of n equal weights
    // With less than two records' worth of weights their spread says nothing, and may not be made much of.
    const double scatter = spread * share / std::max(1 - share, 0.5);
    const double noise = noise_ / (weights_ * weights_), remainder = remainder_ / weights_;
    return static_cast<float>(std::sqrt(std::max(noise, scatter) + remainder * remainder));
  }

 private:
  double weights_ = 0, squared_weights_ = 0, said_ = 0, squares_ = 0, noise_ = 0, remainder_ = 0;
};

}  // namespace

IrradianceRecord make_record(const vec3& position, const vec3& normal, const IrradianceEstimate& estimate, Gradients gradients,
                             CacheMetric metric, const MetricContext& context) {
  const Reach reach = metric_reach(metric, estimate, Frame::from_normal(normal), context);
  IrradianceRecord record{.position = position,
                          .normal = normal,
                          .reach = std::min(reach.length, context.scene_size / context.accuracy),
                          .irradiance = estimate.irradiance,
                          .squeeze = reach.squeeze,
                          .variance = estimate.variance,
                          .least = reach.least};
  if (gradients != Gradients::none) record.rotation = estimate.rotation;
  if (gradients >= Gradients::both) {
    record.translation = estimate.translation;
    const float brightness = luminance(estimate.irradiance);
    // The bounded split sphere holds its whole reach to this, but for its least spacing; others what they serve.
    const float extent = metric == CacheMetric::bounded_split_sphere ? record.reach : context.accuracy * record.reach;
    if (const float change = steepness(estimate) * extent; change > brightness) record.translation *= brightness / change;
  }
  return record;
}

void IrradianceRecord::shorten(float length) {
  length = std::max(length, least);
  if (!(length < reach)) return;
  // The narrow axis, reach / sqrt(1 + squeeze^2), stays unless it too is longer.
  const float ratio = length / reach * std::sqrt(1 + length_squared(squeeze));
  const float size = glm::length(squeeze);
  if (size > 0) squeeze *= safe_sqrt(ratio * ratio - 1) / size;
  reach = length;
}

float IrradianceRecords::error(const IrradianceRecord& record, const vec3& position, const vec3& normal) const {
  const vec3 offset = position - record.position;
  const float cosine = glm::dot(normal, record.normal);
  const float away = std::sqrt(length_squared(offset) + square(glm::dot(offset, record.squeeze))) / record.reach;
  const float turn = safe_sqrt(1 - cosine);
  constexpr float ten_degrees = 0.12325683f;  // sqrt(1 - cos 10 degrees)
  const float error = weight_ == CacheWeight::ward ? away + turn : std::max(away, turn * (usual_accuracy / ten_degrees));
  if (!(error < farthest_)) return infinity;
  // In front by more than rounding and curvature explain.
  if (0.5f * glm::dot(offset, normal + record.normal) < -0.02f * std::min(accuracy_, 1.0f) * record.reach) return infinity;
  return error;
}

void IrradianceRecords::insert(IrradianceRecord record) {
  const auto id = static_cast<std::uint32_t>(records_.size());
  if (clamps_) {
    // The least of R_j + clamp |p_i - p_j| over all records obeys the triangle inequality, so the order of insertion does not
    // matter. Balls are not shrunk: `error` decides.
    record.shorten(reaches_.limit(record.position, record.reach));
    reaches_.shorten_around(record.position, record.reach,
                            [&](std::uint32_t other, float length) { records_[other].shorten(length); });
    reaches_.insert(record.position, record.reach, id);
  }
  balls_->insert(record.position, farthest_ * record.reach, id);
  records_.push_back(record);
}

bool IrradianceRecords::covered(const vec3& position, const vec3& normal) const {
  static thread_local Neighbours found;
  balls_->covering(position, found);
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

std::optional<Interpolated> IrradianceRecords::interpolate(const vec3& position, const vec3& normal) const {
  static thread_local Neighbours found;
  balls_->covering(position, found);
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
    error_of_mean.add(w, luminance(here), record.variance, e);
  }
  if (weights > 0) return Interpolated{sum / weights, least, error_of_mean.standard_error()};
  if (!best) return std::nullopt;
  const Rgb alone = extrapolate(*best, position, normal);
  error_of_mean.add(1, luminance(alone), best->variance, least);
  return Interpolated{alone, least, error_of_mean.standard_error()};
}

}  // namespace etendue
