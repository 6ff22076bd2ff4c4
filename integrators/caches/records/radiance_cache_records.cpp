#include "integrators/caches/records/radiance_cache_records.h"

#include "framework/core/check.h"
#include "framework/core/elementary.h"
#include "integrators/caches/records/error_of_mean.h"
#include "integrators/caches/records/spherical_harmonics.h"

#include <array>

namespace etendue {

namespace {

constexpr int diffuse_order = 7;

struct Harmonics {
  int order;
  const Frame& frame;
  std::array<float, highest_sh_order * highest_sh_order> up, down;

  // Values at a local direction and at its mirror image below the horizon, added.
  std::span<const float> at(const vec3& local) {
    const auto count = static_cast<std::size_t>(order) * order;
    evaluate_sh(order, frame.to_world(local), up);
    evaluate_sh(order, frame.to_world({local.x, local.y, -local.z}), down);
    for (std::size_t i = 0; i < count; ++i) up[i] += down[i];
    return std::span(up).first(count);
  }
};

void add(std::span<Rgb> sum, std::span<const float> harmonics, const Rgb& amount) {
  for (std::size_t i = 0; i < harmonics.size(); ++i) sum[i] += harmonics[i] * amount;
}

// Share of the gradients by which no extrapolation changes the coefficients by more than they are ([Krivanek2005]'s norm: that
// of coefficients, since those of high degree change faster than irradiance).
float kept_gradient(const RadianceEstimate& estimate, float extent) {
  const std::size_t count = estimate.coefficients.size() / 3;
  double squares = 0, x = 0, y = 0;
  for (std::size_t i = 0; i < count; ++i) {
    squares += square(luminance(estimate.coefficients[i]));
    x += square(luminance(estimate.coefficients[count + i]));
    y += square(luminance(estimate.coefficients[2 * count + i]));
  }
  const double change = std::sqrt(x + y) * extent, size = std::sqrt(squares);
  return change > size ? static_cast<float>(size / change) : 1;
}

Rgb dot(std::span<const Rgb> lobe, const Rgb* coefficients) {
  Rgb sum(0);
  for (std::size_t i = 0; i < lobe.size(); ++i) sum += lobe[i] * coefficients[i];
  return sum;
}

}  // namespace

ShLobe diffuse_lobe(int order, const vec3& normal) {
  const int used = std::min(order, diffuse_order);
  std::array<float, diffuse_order * diffuse_order> values;
  evaluate_sh(used, normal, values);
  ShLobe lobe(static_cast<std::size_t>(used) * used);
  for (int l = 0; l < used; ++l)
    for (int m = -l; m <= l; ++m) lobe[sh_index(l, m)] = Rgb(inv_pi * cosine_convolution(l) * values[sh_index(l, m)]);
  return lobe;
}

RadianceEstimate estimate_radiance(int order, const HemisphereStrata& strata, std::span<const HemisphereSample> samples,
                                   const Frame& frame) {
  CHECK_EQ(static_cast<int>(samples.size()), strata.count());
  const std::size_t count = static_cast<std::size_t>(order) * order;
  RadianceEstimate out;
  out.coefficients.assign(3 * count, Rgb(0));
  const auto value = std::span(out.coefficients).first(count);
  const auto along = [&](float angle, std::span<const float> harmonics, const Rgb& amount) {
    add(std::span(out.coefficients).subspan(count, count), harmonics, math::cos(angle) * amount);
    add(std::span(out.coefficients).subspan(2 * count, count), harmonics, math::sin(angle) * amount);
  };
  Harmonics harmonics{order, frame, {}, {}};
  const float solid_angle = 2 * pi / static_cast<float>(strata.count());
  const float sector = 2 * pi / static_cast<float>(strata.phi);
  const auto ring_angle = [&](int j) { return math::acos(1 - static_cast<float>(j) / static_cast<float>(strata.theta)); };
  const auto local = [](float theta, float phi) {
    return vec3(math::sin(theta) * math::cos(phi), math::sin(theta) * math::sin(phi), math::cos(theta));
  };
  double inverse_distance = 0, half_squares = 0;
  for (int k = 0; k < strata.phi; ++k)
    for (int j = 0; j < strata.theta; ++j) {
      const HemisphereSample& here = samples[static_cast<std::size_t>(j) * strata.phi + k];
      inverse_distance += 1 / static_cast<double>(here.distance);
      if (!is_black(here.radiance)) add(value, harmonics.at(frame.to_local(here.direction)), solid_angle * here.radiance);
      // The walls towards the ring above, which moves by cos(theta) / r, and towards the sector before, by 1 / (r sin(theta)):
      // [Ward1992], the harmonic for the cosine.
      const float middle = sector * (static_cast<float>(k) + 0.5f), edge = sector * static_cast<float>(k);
      const float upper = ring_angle(j), lower = ring_angle(j + 1);
      if (j > 0) {
        const HemisphereSample& above = samples[static_cast<std::size_t>(j - 1) * strata.phi + k];
        const Rgb step = (here.radiance - above.radiance) / std::min(here.distance, above.distance);
        if (!is_black(step))
          along(middle, harmonics.at(local(upper, middle)), step * (sector * math::sin(upper) * math::cos(upper)));
      }
      const HemisphereSample& before = samples[static_cast<std::size_t>(j) * strata.phi + (k + strata.phi - 1) % strata.phi];
      half_squares += 0.5 * square(luminance(here.radiance - before.radiance));
      const Rgb step = (here.radiance - before.radiance) / std::min(here.distance, before.distance);
      if (!is_black(step)) along(edge + 0.5f * pi, harmonics.at(local(0.5f * (upper + lower), edge)), step * (lower - upper));
    }
  out.inverse_distance = static_cast<float>(inverse_distance / strata.count());
  // Noise that is alike and independent in all directions has the variance per stratum times its solid angle in every
  // coefficient; mirrored below the horizon, twice that in the even ones, which alone are not zero.
  out.variance = 2 * solid_angle * static_cast<float>(half_squares / strata.count());
  return out;
}

void RadianceEstimate::average_in(const RadianceEstimate& next, int passes) {
  const float share = 1 / static_cast<float>(passes);
  for (std::size_t i = 0; i < coefficients.size(); ++i) coefficients[i] += share * (next.coefficients[i] - coefficients[i]);
  inverse_distance += share * (next.inverse_distance - inverse_distance);
  variance = square(1 - share) * variance + square(share) * next.variance;
}

void RadianceRecords::insert(const vec3& position, const vec3& normal, const RadianceEstimate& estimate,
                             const RadianceSpacing& spacing, bool gradients) {
  const std::size_t count = static_cast<std::size_t>(order_) * order_;
  CHECK_EQ(estimate.coefficients.size(), 3 * count);
  const auto id = static_cast<std::uint32_t>(records_.size());
  Record record{position, Frame::from_normal(normal), infinity, estimate.variance};
  if (estimate.inverse_distance > 0) record.validity_radius = 1 / estimate.inverse_distance;
  // No farther than where the irradiance would be extrapolated to 0; a gradient that still would is shortened.
  const ShLobe lobe = diffuse_lobe(order_, normal);
  const float brightness = luminance(dot(lobe, estimate.coefficients.data()));
  float steepness = 0;
  if (gradients) {
    const float x = luminance(dot(lobe, &estimate.coefficients[count])),
                y = luminance(dot(lobe, &estimate.coefficients[2 * count]));
    steepness = math::hypot(x, y);
    if (steepness > 0) record.validity_radius = std::min(record.validity_radius, brightness / steepness);
  }
  record.validity_radius = std::clamp(record.validity_radius, spacing.least / spacing.accuracy,
                                      std::max(spacing.least, spacing.most) / spacing.accuracy);
  const float kept = gradients ? kept_gradient(estimate, spacing.accuracy * record.validity_radius) : 0;
  for (std::size_t i = 0; i < 3 * count; ++i) coefficients_.push_back((i < count ? 1 : kept) * estimate.coefficients[i]);

  record.validity_radius = validity_.limit(position, record.validity_radius);
  validity_.shorten_around(position, record.validity_radius,
                           [&](std::uint32_t other, float length) { records_[other].validity_radius = length; });
  validity_.insert(position, record.validity_radius, id);
  index_->insert(position, answers_ * record.validity_radius, id);  // spheres do not shrink: weight decides
  records_.push_back(record);
}

void RadianceRecords::add_shapes(std::vector<RecordShape>& shapes) const {
  for (const Record& record : records_)
    shapes.push_back({record.position, record.frame.normal, accuracy_ * record.validity_radius});
}

float RadianceRecords::error(const Record& record, const vec3& position, const vec3& normal) const {
  const vec3 offset = position - record.position;
  const float cosine = glm::dot(normal, record.frame.normal);
  const float error = glm::length(offset) / record.validity_radius + safe_sqrt(1 - cosine);
  if (!(error < answers_) || cosine < 0) return infinity;  // as of irradiance records
  // The record is in front by more than rounding and curvature explain.
  if (0.5f * glm::dot(offset, normal + record.frame.normal) < -0.02f * std::min(accuracy_, 1.0f) * record.validity_radius)
    return infinity;
  return error;
}

bool RadianceRecords::covered(const vec3& position, const vec3& normal) const {
  static thread_local Neighbours found;
  index_->covering(position, found);
  for (const Neighbour& n : found)
    if (error(records_[n.id], position, normal) < accuracy_) return true;
  return false;
}

std::optional<float> RadianceRecords::interpolate(const vec3& position, const vec3& normal, std::span<Rgb> coefficients) const {
  static thread_local Neighbours found;
  index_->covering(position, found);
  const std::size_t stride = static_cast<std::size_t>(order_) * order_;
  float weights = 0, least = infinity;
  for (const Neighbour& n : found) {
    const Record& record = records_[n.id];
    const float e = error(record, position, normal);
    if (!(e < answers_)) continue;
    if (weights == 0) std::fill(coefficients.begin(), coefficients.end(), Rgb(0));
    const float w = weight(e);
    const vec3 offset = position - record.position;
    const float x = w * glm::dot(offset, record.frame.tangent), y = w * glm::dot(offset, record.frame.bitangent);
    const Rgb* at = &coefficients_[3 * stride * n.id];
    for (std::size_t i = 0; i < coefficients.size(); ++i)
      coefficients[i] += w * at[i] + x * at[stride + i] + y * at[2 * stride + i];
    weights += w;
    least = std::min(least, e);
  }
  if (!(weights > 0)) return std::nullopt;
  for (Rgb& c : coefficients) c /= weights;
  return least;
}

float RadianceRecords::standard_error(const vec3& position, const vec3& normal, std::span<const Rgb> lobe,
                                      float lobe_square) const {
  static thread_local Neighbours found;
  index_->covering(position, found);
  const std::size_t stride = static_cast<std::size_t>(order_) * order_;
  ErrorOfMean error_of_mean;
  for (const Neighbour& n : found) {
    const Record& record = records_[n.id];
    const float e = error(record, position, normal);
    if (!(e < answers_)) continue;
    const vec3 offset = position - record.position;
    const float x = glm::dot(offset, record.frame.tangent), y = glm::dot(offset, record.frame.bitangent);
    const Rgb* at = &coefficients_[3 * stride * n.id];
    const Rgb said = dot(lobe, at) + x * dot(lobe, at + stride) + y * dot(lobe, at + 2 * stride);
    error_of_mean.add(weight(e), luminance(said), lobe_square * record.variance, 0, e);
  }
  return error_of_mean.standard_error();
}

}  // namespace etendue
