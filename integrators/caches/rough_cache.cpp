#include "integrators/caches/rough_cache.h"

#include "framework/core/elementary.h"
#include "integrators/caches/cache_fill.h"
#include "integrators/caches/records/record_file.h"
#include "integrators/caches/records/spherical_harmonics.h"

#include <cmath>
#include <initializer_list>

namespace etendue {

namespace {

constexpr std::uint32_t rough_salt = 0x726f7567;  // its random numbers are not those of irradiance at the same pixel

// The least roughness of a rough lobe over an opaque surface; 0: none.
float least_alpha(const Material& material) {
  if (const auto* m = std::get_if<Conductor>(&material)) return std::min(m->alpha.x, m->alpha.y);
  if (const auto* m = std::get_if<Plastic>(&material)) return m->alpha;
  return 0;
}

// Value of a polynomial by Horner's rule, the lowest coefficient first.
double polynomial(std::initializer_list<double> coefficients, double x) {
  double value = 0;
  for (auto c = std::rbegin(coefficients); c != std::rend(coefficients); ++c) value = value * x + *c;
  return value;
}

// Modified Bessel function of the second kind, within 3e-7 of its value: [Abramowitz1964] 9.8.3, 9.8.7, 9.8.8.
double bessel_k1(double x) {
  if (x > 2)
    return math::exp(-x) / std::sqrt(x) *
           polynomial({1.25331414, 0.23498619, -0.03655620, 0.01504268, -0.00780353, 0.00325614, -0.00068245}, 2 / x);
  const double i1 =
      x * polynomial({0.5, 0.87890594, 0.51498869, 0.15084934, 0.02658733, 0.00301532, 0.00032411}, square(x / 3.75));
  return math::log(x / 2) * i1 +
         polynomial({1, 0.15443144, -0.67278579, -0.18156897, -0.01919402, -0.00110404, -0.00004686}, square(x / 2)) / x;
}

}  // namespace

double lobe_share(float alpha, int degree) {
  const double x = 2.0 * alpha * degree;
  return x > 0 ? x * bessel_k1(x) : 1;
}

int lobe_order(float alpha, float left_out) {
  constexpr int enough = 1000;
  int order = 1;
  while (order < enough && lobe_share(alpha, order) > left_out) ++order;
  return order;
}

float lobe_square(float alpha, int order) {
  double sum = 0;
  for (int degree = 0; degree < order; ++degree) sum += (2 * degree + 1) * square(lobe_share(alpha, degree));
  return static_cast<float>(sum / (8 * std::numbers::pi));
}

void RoughCache::choose_orders(const Scene& scene) {
  order_ = 0;
  narrowest_ = infinity;
  orders_.clear();
  lobe_squares_.clear();
  for (const Material& material : scene.materials) {
    const float alpha = least_alpha(material);
    // The diffuse base of a plastic takes the three bands of irradiance.
    const int order = alpha > 0 ? std::max(lobe_order(alpha, settings_.left_out), 3) : 0;
    orders_.push_back(order <= settings_.highest_order ? order : 0);
    lobe_squares_.push_back(lobe_square(alpha, orders_.back()));
    order_ = std::max(order_, orders_.back());
    if (orders_.back() > 0) narrowest_ = std::min(narrowest_, alpha);
  }
}

void RoughCache::prepare(const RenderContext& context, int deepest, bool one_level) {
  choose_orders(context.scene);
  if (!active()) return;
  const ivec2 size = context.resolution;
  std::vector<CachePoint> pixels(static_cast<std::size_t>(size.x) * size.y);
  parallel_pixels(size, [&](ivec2 pixel) {
    pixels[pixel_index(pixel, size)] =
        follow_pixel(context, pixel, deepest, settings_.sampler, [this](const SurfacePoint& point, const Bsdf& bsdf) {
          return answers(point.material) ? Follow::arrives : bsdf.is_diffuse() ? Follow::ends : Follow::goes_on;
        });
  });
  start(context, std::move(pixels), one_level, settings_.accuracy);
  Bounds whole = context.bounds;
  if (whole.empty()) whole = bounds();
  max_spacing_ = whole.empty() ? 0 : settings_.max_spacing * glm::length(whole.diagonal());
}

RadianceRecords RoughCache::make_records(const RenderContext& context) const {
  return {context.make_records(settings_.structure, bounds()), order_, accuracy(),
          std::clamp(settings_.accuracy / accuracy(), 1.0f, settings_.overlap)};
}

void RoughCache::insert(RadianceRecords& records, const History& history) const {
  const RadianceSpacing spacing{
      settings_.accuracy, std::max(settings_.min_spacing * history.point.pixel_width, 1e-6f * max_spacing_), max_spacing_};
  records.insert(history.point.position, history.point.normal, history.mean, spacing, settings_.gradients);
}

RadianceEstimate RoughCache::estimate(const RenderContext& context, const HemisphereRadiance& radiance, const History& history,
                                      int depth, std::uint32_t pass) const {
  const Frame frame = Frame::from_normal(history.point.normal);
  const auto samples = trace_hemisphere(context, settings_.sampler, history.point, frame, depth,
                                        hash_keys(history.key, rough_salt), pass, settings_.strata, true, radiance);
  return estimate_radiance(order_, settings_.strata, samples, frame);
}

std::optional<RoughCache::Reflected> RoughCache::reflected(const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo,
                                                           int depth, Sampler& sampler, bool states_error) const {
  const RadianceRecords* records = records_at(depth);
  if (!records) return std::nullopt;
  count(Counter::lookups);
  const int order = orders_[point.material];
  static thread_local std::vector<Rgb> coefficients, lobe;
  static thread_local std::vector<float> harmonics;
  coefficients.resize(static_cast<std::size_t>(order) * order);
  harmonics.resize(coefficients.size());
  const vec3 normal = towards(point.shading_normal, point.normal, wo);
  const auto error = records->interpolate(point.position, normal, coefficients);
  if (!error) return std::nullopt;
  // A lattice of rank one, turned at random ([Cranley1976] with the golden ratio).
  const float turn = sampler.get_1d();
  const vec2 shift = sampler.get_2d();
  const auto wrapped = [](float x) { return std::min(x - std::floor(x), 0x1.fffffep-1f); };
  if (states_error) lobe.assign(coefficients.size(), Rgb(0));
  Rgb sum(0), weights(0);
  for (int k = 0; k < settings_.lobe_samples; ++k) {
    const float place = static_cast<float>(k) / static_cast<float>(settings_.lobe_samples);
    const vec2 u(wrapped(shift.x + place), wrapped(shift.y + 0.61803399f * static_cast<float>(k)));
    const BsdfSample s = bsdf.sample(wo, wrapped(turn + 0.75487767f * static_cast<float>(k)), u);
    if (!s) continue;
    evaluate_sh(order, s.wi, harmonics);
    Rgb incident(0);
    for (std::size_t i = 0; i < coefficients.size(); ++i) incident += harmonics[i] * coefficients[i];
    sum += s.weight * incident;
    weights += s.weight;
    if (states_error)
      for (std::size_t i = 0; i < lobe.size(); ++i) lobe[i] += harmonics[i] * s.weight;
  }
  Reflected out{glm::max(sum / static_cast<float>(settings_.lobe_samples), Rgb(0)), *error};
  if (states_error) {
    const float share = 1 / static_cast<float>(settings_.lobe_samples);
    for (Rgb& l : lobe) l *= share;
    const float square_of_lobe = square(share * luminance(weights)) * lobe_squares_[point.material];
    out.standard_error = records->standard_error(point.position, normal, lobe, square_of_lobe);
  }
  return out;
}

void RoughCache::add_shapes(std::vector<RecordShape>& shapes) const {
  for (std::size_t level = 0; const RadianceRecords* records = records_in(level); ++level) records->add_shapes(shapes);
}

// The mean of a record in a file (record_file.h): f32 inverse distance, variance; f32 coefficients, as many as the scene's
// order asks for.
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
