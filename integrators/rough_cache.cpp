#include "integrators/rough_cache.h"

#include "framework/core/parallel.h"
#include "framework/transport/ray_tools.h"
#include "integrators/spherical_harmonics.h"

#include <cmath>

namespace etendue {

namespace {

constexpr int coarsest_grid = 64;
constexpr std::size_t batch_size = 64;
constexpr std::uint32_t rough_salt = 0x726f7567;  // its random numbers are not those of irradiance at the same pixel

// Of a rough lobe over an opaque surface; 0: none.
float least_alpha(const Material& material) {
  if (const auto* m = std::get_if<Conductor>(&material)) return std::min(m->alpha.x, m->alpha.y);
  if (const auto* m = std::get_if<Plastic>(&material)) return m->alpha;
  return 0;
}

}  // namespace

double lobe_share(float alpha, int degree) {
  const double x = 2.0 * alpha * degree;
  return x > 0 ? x * std::cyl_bessel_k(1.0, x) : 1;
}

int lobe_order(float alpha, float left_out) {
  constexpr int enough = 1000;
  int order = 1;
  while (order < enough && lobe_share(alpha, order) > left_out) ++order;
  return order;
}

void RoughCache::choose_orders(const Scene& scene) {
  order_ = 0;
  orders_.clear();
  for (const Material& material : scene.materials) {
    const float alpha = least_alpha(material);
    // The diffuse base of a plastic takes the three bands of irradiance.
    const int order = alpha > 0 ? std::max(lobe_order(alpha, settings_.left_out), 3) : 0;
    orders_.push_back(order <= settings_.highest_order ? order : 0);
    order_ = std::max(order_, orders_.back());
  }
}

void RoughCache::prepare(const RenderContext& context, int deepest, bool one_level) {
  one_level_ = one_level;
  choose_orders(context.scene);
  if (!active()) return;
  const ivec2 size = context.resolution;
  pixels_.assign(static_cast<std::size_t>(size.x) * size.y, {});
  parallel_pixels(size, [&](ivec2 pixel) {
    pixels_[static_cast<std::size_t>(pixel.y) * size.x + pixel.x] =
        follow_pixel(context, pixel, deepest, settings_.sampler, [this](const SurfacePoint& point, const Bsdf& bsdf) {
          return answers(point.material) ? Follow::arrives : bsdf.is_diffuse() ? Follow::ends : Follow::goes_on;
        });
  });
  bounds_ = {};
  levels_.clear();
  int highest = -1;
  for (const CachePoint& point : pixels_) {
    if (!point) continue;
    bounds_.extend(point.position);
    highest = std::max(highest, static_cast<int>(level(point.depth)));
  }
  Bounds whole = context.scene.bounds();
  if (whole.empty()) whole = bounds_;
  max_spacing_ = whole.empty() ? 0 : settings_.max_spacing * glm::length(whole.diagonal());
  for (int i = 0; i <= highest; ++i) levels_.push_back({{}, make_records(context, settings_.accuracy)});
}

RadianceRecords RoughCache::make_records(const RenderContext& context, float accuracy) const {
  return {context.make_balls(settings_.structure, bounds_), order_, accuracy,
          std::clamp(settings_.accuracy / accuracy, 1.0f, settings_.overlap)};
}

void RoughCache::rebuild(const RenderContext& context, float accuracy) {
  for (Level& level : levels_) {
    level.records = make_records(context, accuracy);
    for (const History& history : level.histories) insert(level, history);
  }
}

void RoughCache::insert(Level& level, const History& history) const {
  const RadianceSpacing spacing{
      settings_.accuracy, std::max(settings_.min_spacing * history.point.pixel_width, 1e-6f * max_spacing_), max_spacing_};
  level.records.insert(history.point.position, history.point.normal, history.mean, spacing, settings_.gradients);
}

void RoughCache::fill(const RenderContext& context, const HemisphereRadiance& radiance, float accuracy) {
  if (!active()) return;
  rebuild(context, accuracy);
  const auto fill_where = [&](const auto& wanted) {
    const auto width = static_cast<std::size_t>(context.resolution.x);
    std::vector<Query> queue;
    for (std::size_t i = 0; i < pixels_.size(); ++i)
      if (pixels_[i] && wanted(static_cast<int>(i % width), static_cast<int>(i / width)))
        queue.push_back({key_salt_ == 0 ? i : hash_keys(i, key_salt_), &pixels_[i]});
    cover(context, radiance, std::move(queue), 1);
  };
  // Every step-th pixel, but for those that the coarser pass has been to.
  for (int step = coarsest_grid; step >= 1; step /= 2)
    fill_where([=](int x, int y) {
      return x % step == 0 && y % step == 0 && (step == coarsest_grid || x % (2 * step) != 0 || y % (2 * step) != 0);
    });
  fill_where([](int, int) { return true; });
}

void RoughCache::cover(const RenderContext& context, const HemisphereRadiance& radiance, std::vector<Query> queue,
                       double passes) {
  std::erase_if(queue, [&](const Query& query) { return covered(*query.point); });
  std::sort(queue.begin(), queue.end(), [](const Query& a, const Query& b) { return mix_bits(a.key) < mix_bits(b.key); });
  std::vector<Query> batch;
  for (std::size_t next = 0; next < queue.size();) {
    batch.clear();
    for (; next < queue.size() && batch.size() < batch_size; ++next)
      if (!covered(*queue[next].point)) batch.push_back(queue[next]);
    std::vector<History> made(batch.size());
    parallel_for(batch.size(), 1, [&](std::size_t i) {
      made[i] = {*batch[i].point, hash_keys(batch[i].key, rough_salt), {}, 0};
      add_passes(context, radiance, made[i], passes);
    });
    for (History& history : made) {
      Level& level = levels_[this->level(history.point.depth)];
      insert(level, history);
      level.histories.push_back(std::move(history));
    }
    count(Counter::records, batch.size());
  }
}

void RoughCache::add_passes(const RenderContext& context, const HemisphereRadiance& radiance, History& history,
                            double passes) const {
  const auto target = static_cast<int>(passes + to_unit_float(static_cast<std::uint32_t>(hash_keys(history.key, 1u))));
  while (history.passes < std::max(target, 1)) {
    const auto pass = static_cast<std::uint32_t>(history.passes++);
    RadianceEstimate next = sample_hemisphere(context, radiance, history.point, history.key, pass);
    if (pass == 0)
      history.mean = std::move(next);
    else
      history.mean.average_in(next, history.passes);
  }
}

void RoughCache::refine(const RenderContext& context, const HemisphereRadiance& radiance, float accuracy, double passes,
                        std::span<const CachePoint> wanted, std::uint32_t round) {
  if (!active()) return;
  for (Level& level : levels_)
    parallel_for(level.histories.size(), 1, [&](std::size_t i) { add_passes(context, radiance, level.histories[i], passes); });
  rebuild(context, accuracy);
  std::vector<Query> queue;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!wanted[i]) continue;
    while (level(wanted[i].depth) >= levels_.size()) levels_.push_back({{}, make_records(context, accuracy)});
    queue.push_back({hash_keys(i, round), &wanted[i]});
  }
  cover(context, radiance, std::move(queue), passes);
}

RadianceEstimate RoughCache::sample_hemisphere(const RenderContext& context, const HemisphereRadiance& radiance,
                                               const CachePoint& point, std::uint64_t key, std::uint32_t pass) const {
  const HemisphereStrata& strata = settings_.strata;
  const Frame frame = Frame::from_normal(point.normal);
  const auto samples = trace_hemisphere(context, settings_.sampler, point, frame, static_cast<int>(level(point.depth)) + 1, key,
                                        pass, strata, even_direction, radiance);
  return estimate_radiance(order_, strata, samples, frame);
}

std::optional<RoughCache::Reflected> RoughCache::reflected(const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo,
                                                           int depth, Sampler& sampler) const {
  if (level(depth) >= levels_.size()) return std::nullopt;
  count(Counter::lookups);
  const int order = orders_[point.material];
  static thread_local std::vector<Rgb> coefficients;
  static thread_local std::vector<float> harmonics;
  coefficients.resize(static_cast<std::size_t>(order) * order);
  harmonics.resize(coefficients.size());
  const vec3 normal = towards(point.shading_normal, point.normal, wo);
  const auto error = levels_[level(depth)].records.interpolate(point.position, normal, coefficients);
  if (!error) return std::nullopt;
  // A lattice of rank one, turned at random ([Cranley1976] with the golden ratio).
  const float turn = sampler.get_1d();
  const vec2 shift = sampler.get_2d();
  const auto wrapped = [](float x) { return std::min(x - std::floor(x), 0x1.fffffep-1f); };
  Rgb sum(0);
  for (int k = 0; k < settings_.lobe_samples; ++k) {
    const float place = static_cast<float>(k) / static_cast<float>(settings_.lobe_samples);
    const vec2 u(wrapped(shift.x + place), wrapped(shift.y + 0.61803399f * static_cast<float>(k)));
    const BsdfSample s = bsdf.sample(wo, wrapped(turn + 0.75487767f * static_cast<float>(k)), u);
    if (!s) continue;
    evaluate_sh(order, s.wi, harmonics);
    Rgb incident(0);
    for (std::size_t i = 0; i < coefficients.size(); ++i) incident += harmonics[i] * coefficients[i];
    sum += s.weight * incident;
  }
  return Reflected{glm::max(sum / static_cast<float>(settings_.lobe_samples), Rgb(0)), *error};
}

void RoughCache::add_discs(std::vector<RecordDisc>& discs) const {
  for (const Level& level : levels_) level.records.add_discs(discs);
}

}  // namespace etendue
