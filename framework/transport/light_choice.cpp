// The choice of a light: by power, all alike, or by a tree.
#include "framework/transport/light_choice.h"

#include "framework/core/elementary.h"
#include "framework/transport/cumulative.h"
#include "framework/transport/light_sampling.h"

#include <algorithm>
#include <limits>
#include <set>

namespace etendue {

namespace {

// A tree costs less than it saves from three lights at finite places on (builtin:veach-mis, results/many-lights). Where light
// samples alone find them it does from two on, as records share their noise: the lamp of a white room beside one of 300 times
// the power left its records 37 % too dark to 88 % too bright. Few lights that are all flat are an exception: lanes choose them
// by power all at once.
constexpr std::size_t fewest_for_tree = 3;
// A tree tells lights apart by their distances. Those of lights nearly as wide as the scene say little (builtin:glowing-room),
// but where BSDF samples do not find the light of near surfaces.
constexpr double widest_for_tree = 0.25;  // mean width over that of the scene, weighted by power

struct LuminousPower {
  float area;    // of an area light, m^2
  float radius;  // of the scene, m

  float operator()(const AreaLight& l) const { return luminance(l.radiance) * pi * area * (l.two_sided ? 2 : 1); }
  float operator()(const PointLight& l) const { return luminance(l.intensity) * 4 * pi; }
  float operator()(const SpotLight& l) const {
    return luminance(l.intensity) * 2 * pi * (1 - 0.5f * (l.cos_inner + l.cos_outer));
  }
  float operator()(const DirectionalLight& l) const { return luminance(l.irradiance) * pi * radius * radius; }
  float operator()(const EnvironmentLight& l) const {
    if (l.texels.empty()) return luminance(l.scale) * 4 * pi * pi * radius * radius;
    double sum = 0, weight = 0;
    for (int y = 0; y < l.size.y; ++y) {
      const double sine = math::sin(pi * (static_cast<float>(y) + 0.5f) / static_cast<float>(l.size.y));
      for (int x = 0; x < l.size.x; ++x)
        sum += sine * luminance(l.texels[static_cast<std::size_t>(y) * l.size.x + x] * l.scale);
      weight += sine * l.size.x;
    }
    return static_cast<float>(sum / weight) * 4 * pi * pi * radius * radius;
  }
};

// The factor by which an image on a light changes how often the light is chosen. It is never 0, since the image's mean is an
// estimate.
double image_share(const Rgb& mean) { return 0.01 + luminance(mean); }

bool is_infinite(const Light& light) {
  return std::holds_alternative<DirectionalLight>(light) || std::holds_alternative<EnvironmentLight>(light);
}

float to_number_below_one(double u) { return std::min(static_cast<float>(u), 0x1.fffffep-1f); }

// Tells a tree what it must know of a light; nothing of those at infinity.
struct AsEmitter {
  const Scene& scene;
  const AreaEmitter& emitter;

  LightTree::Emitter operator()(const AreaLight& l) const {
    LightTree::Emitter e;
    e.bounds = scene.objects[0].geometry.primitive_bounds(l.primitive);
    e.theta_emission = 0.5f * pi;
    e.two_sided = l.two_sided;
    // A round surface shows a quarter of its area on average.
    const std::optional<vec3> normal = emitter.normal();
    if (normal) {
      e.axis = *normal;
      e.theta_normals = 0;
    }
    e.intensity = luminance(l.radiance) * emitter.area() * (normal ? 1 : 0.25f);
    if (l.texture != no_id) e.intensity *= static_cast<float>(image_share(emitter.mean_of_image()));
    return e;
  }
  LightTree::Emitter operator()(const PointLight& l) const {
    return {.bounds = {l.position, l.position}, .intensity = luminance(l.intensity)};
  }
  LightTree::Emitter operator()(const SpotLight& l) const {
    const float inner = math::acos(l.cos_inner), outer = math::acos(l.cos_outer);
    return {.bounds = {l.position, l.position},
            .axis = l.direction,
            .theta_normals = inner,
            .theta_emission = outer - inner,
            .intensity = luminance(l.intensity)};
  }
  LightTree::Emitter operator()(const DirectionalLight&) const { return {}; }
  LightTree::Emitter operator()(const EnvironmentLight&) const { return {}; }
};

}  // namespace

LightSampler::Table::Table(std::span<const double> weights) {
  double total = 0, sum = 0;
  for (const double w : weights) total += w;
  const bool fine = weights.size() > most_flat ||
                    std::ranges::any_of(weights, [&](double w) { return w > 0 && w < least_flat_share * total; });
  for (const double w : weights) {
    const double share = w / total;
    sum += share;
    probability.push_back(static_cast<float>(share));
    if (fine)
      finer.push_back(sum);
    else
      cumulative.push_back(static_cast<float>(sum));
  }
}

std::size_t LightSampler::Table::choose(float& u, float salt) const {
  if (probability.size() == 1) return 0;
  if (finer.empty()) return pick(cumulative.data(), cumulative.size(), u);
  double digits = with_more_digits(u, salt);
  const std::size_t chosen = pick(finer.data(), finer.size(), digits);
  u = to_number_below_one(digits);
  return chosen;
}

LightSampler::LightSampler(const Scene& scene) : scene_(scene) {
  const Bounds bounds = scene.bounds();
  if (!bounds.empty()) {
    scene_centre_ = bounds.centre();
    scene_radius_ = std::max(0.5f * glm::length(bounds.diagonal()), std::numeric_limits<float>::min());
  }
  std::vector<double> power;
  double total = 0, finite_power = 0;
  for (const Light& light : scene.lights) {
    const auto* area_light = std::get_if<AreaLight>(&light);
    emitters_.push_back(area_light ? AreaEmitter(scene, *area_light) : AreaEmitter());
    power.push_back(std::visit(LuminousPower{emitters_.back().area(), scene_radius_}, light));
    if (area_light && area_light->texture != no_id) power.back() *= image_share(emitters_.back().mean_of_image());
    total += power.back();
    any_delta_ |= is_delta(light);
    if (is_infinite(light) || !(power.back() > 0)) continue;
    finite_power += power.back();
    ++finite_;
  }
  if (!(total > 0)) return;  // no light has power: as if there were none
  power_ = Table(power);
  finite_power_ = finite_power / total;
  for (std::uint32_t i = 0; i < scene.lights.size(); ++i) {
    if (is_infinite(scene.lights[i])) infinite_.push_back(i);
    const auto* environment = std::get_if<EnvironmentLight>(&scene.lights[i]);
    if (!environment) continue;
    environments_.push_back(i);
    const bool black = !(power[i] > 0);
    distributions_.push_back(ImageDistribution(environment->texels.empty() || black ? EnvironmentLight{} : *environment));
  }
  gather_flat_lights();
}

void LightSampler::gather_flat_lights() {
  if (power_.cumulative.empty()) return;
  for (std::size_t i = 0; i < scene_.lights.size(); ++i) {
    const auto* light = std::get_if<AreaLight>(&scene_.lights[i]);
    const TrianglePlane* plane = light ? emitters_[i].flat_triangle() : nullptr;
    if (!plane) {
      flat_.clear();
      return;
    }
    flat_.push_back({*plane, light->radiance, emitters_[i].area(), power_.probability[i], light->two_sided ? 1.0f : 0.0f});
  }
}

LightChoice LightSampler::needed_choice(DirectSamples samples) const {
  if (!flat_.empty()) return LightChoice::power;
  if (samples == DirectSamples::of_lights) return LightChoice::tree;
  if (finite_ < fewest_for_tree) return LightChoice::power;
  double width = 0, finite_power = 0;
  for (std::size_t i = 0; i < scene_.lights.size(); ++i) {
    if (is_infinite(scene_.lights[i])) continue;
    finite_power += power_.probability[i];
    if (const auto* l = std::get_if<AreaLight>(&scene_.lights[i]))
      width += power_.probability[i] * glm::length(scene_.objects[0].geometry.primitive_bounds(l->primitive).diagonal());
  }
  return width > widest_for_tree * finite_power * 2 * scene_radius_ ? LightChoice::power : LightChoice::tree;
}

void LightSampler::choose_by(LightChoice choice, DirectSamples samples) {
  choice_ = choice == LightChoice::by_need ? needed_choice(samples) : choice;
  if (choice_ == LightChoice::tree && finite_ < 2) choice_ = LightChoice::power;  // among lights at infinity alone
  if (choice_ == LightChoice::tree && tree_.empty()) build_tree();
  own_ = {};
  finite_share_ = finite_power_;
  const bool leaves = choice == LightChoice::by_need && samples == DirectSamples::of_both && !only_even() &&
                      std::ranges::any_of(scene_.lights, is_even);
  if (empty() || (!leaves && choice_ != LightChoice::uniform)) return;
  std::vector<double> weights;
  double total = 0;
  for (std::size_t i = 0; i < scene_.lights.size(); ++i) {
    const double p = leaves && is_even(scene_.lights[i]) ? 0 : power_.probability[i];
    weights.push_back(choice_ == LightChoice::uniform && p > 0 ? 1 : p);
    total += p;
  }
  own_ = Table(weights);
  finite_share_ = std::min(finite_power_ / total, 1.0);
}

bool LightSampler::only_even() const {
  for (std::size_t i = 0; i < power_.probability.size(); ++i)
    if (power_.probability[i] > 0 && !is_even(scene_.lights[i])) return false;
  return !empty();
}

LightTree::Emitter LightSampler::as_emitter(std::size_t light) const {
  return std::visit(AsEmitter{scene_, emitters_[light]}, scene_.lights[light]);
}

void LightSampler::build_tree() {
  std::vector<LightTree::Emitter> finite;
  for (std::size_t i = 0; i < scene_.lights.size(); ++i) finite.push_back(as_emitter(i));
  tree_ = LightTree(finite);
}

std::size_t LightSampler::lamps() const {
  std::set<const Shape*> shapes;
  std::size_t others = 0;
  for (std::size_t i = 0; i < power_.probability.size(); ++i) {
    if (is_infinite(scene_.lights[i]) || !(power_.probability[i] > 0)) continue;
    if (const auto* light = std::get_if<AreaLight>(&scene_.lights[i]))
      shapes.insert(&scene_.objects[0].shape(light->primitive));
    else
      ++others;
  }
  return shapes.size() + others;
}

double LightSampler::spread() const {
  double power = 0, squares = 0;
  dvec3 moment(0);
  for (std::size_t i = 0; i < power_.probability.size(); ++i) {
    if (is_infinite(scene_.lights[i])) continue;
    const dvec3 place = dvec3(as_emitter(i).bounds.centre() - scene_centre_) / static_cast<double>(scene_radius_);
    const double p = power_.probability[i];
    power += p;
    moment += p * place;
    squares += p * glm::dot(place, place);
  }
  if (!(power > 0)) return 0;
  const dvec3 centre = moment / power;
  return std::sqrt(std::max(0.0, squares / power - glm::dot(centre, centre)));
}

LightSampler::Chosen LightSampler::choose_for(const vec3& position, vec2& u) const {
  if (choice_ == LightChoice::tree) return choose_by_tree(position, u);
  const std::size_t light = direct().choose(u.x, u.y);
  return {light, direct().probability[light]};
}

// Lights at finite places together, and each one at infinity, have the shares of their power.
LightSampler::Chosen LightSampler::choose_by_tree(const vec3& position, vec2& u) const {
  double digits = with_more_digits(u.x, u.y);
  if (infinite_.empty() || digits < finite_share_) {
    digits /= finite_share_;
    const LightTree::Chosen chosen = tree_.choose(position, digits);
    u.x = to_number_below_one(digits);
    return {chosen.light, static_cast<float>(finite_share_ * chosen.probability)};
  }
  digits -= finite_share_;
  std::uint32_t light = infinite_.back();
  for (const std::uint32_t i : infinite_) {
    if (digits < direct().probability[i]) {
      light = i;
      break;
    }
    if (i != infinite_.back()) digits -= direct().probability[i];
  }
  const float probability = direct().probability[light];
  if (!(probability > 0)) return {light, 0};
  u.x = to_number_below_one(digits / probability);
  return {light, probability};
}

float LightSampler::choice_probability(const vec3& position, std::uint32_t light) const {
  if (choice_ != LightChoice::tree || is_infinite(scene_.lights[light])) return direct().probability[light];
  return static_cast<float>(finite_share_ * tree_.probability(position, light));
}

}  // namespace etendue
