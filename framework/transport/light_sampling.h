// Sampling lights: towards a point (next-event estimation), out of the light (photons, light paths), and the densities MIS
// needs. Particles leave lights in proportion to power. Next-event estimation chooses lights by power, all alike, or by a tree
// (light_tree.h), as the method says (choose_by); a scene of one light chooses nothing.
#pragma once

#include "framework/core/sampler.h"
#include "framework/transport/area_light.h"
#include "framework/transport/image_distribution.h"
#include "framework/transport/light_choice.h"
#include "framework/transport/light_tree.h"

#include <optional>
#include <span>
#include <vector>

namespace etendue {

// A direction towards a light from a reference point.
struct LightSample {
  vec3 wi;                // unit
  float distance;         // to the light's point; infinity for directions from infinity
  Rgb radiance;           // unoccluded; the estimator is f cos radiance / pdf_solid_angle
  float pdf_solid_angle;  // includes the light's selection probability; for delta lights that probability alone, `radiance`
                          // being then intensity / distance^2 (or irradiance)
  bool delta;
  std::uint32_t light;
  vec3 normal;  // of an area light at its point, as the shape defines it; the direction in which light travels otherwise
  vec3 end;     // where a ray to the light's point must end, off an area light; of no meaning where the distance is infinite
};

// The same in each lane (lanes.h); a density of 0: no light can come of it.
template <class F>
struct LightSampleOf {
  Vec3<F> wi{0.0f};
  F distance{0.0f};
  Vec3<F> radiance{0.0f};
  F pdf_solid_angle{0.0f};
  Mask<F> delta{false};
  Vec3<F> end{0.0f};
};

// An area light that is a triangle and emits by its winding: sampled in lanes, as AreaEmitter samples it.
struct FlatLight {
  TrianglePlaneOf<float> plane;
  vec3 radiance;
  float area;    // m^2
  float chosen;  // probability
  float two_sided;
};

// How a method finds direct light: by light samples alone at some surfaces at least, or everywhere by light and BSDF samples
// that are MIS-weighted.
enum class DirectSamples : std::uint8_t { of_lights, of_both };

// Share of a spot light's intensity that it sends along a unit direction.
float spot_falloff(const SpotLight& light, const vec3& from_light);

// A particle leaving a light.
struct LightRay {
  Ray ray;      // direction unit, origin offset off the light
  vec3 normal;  // at an area light; the direction itself otherwise
  Rgb power;    // emitted radiance cos / pdf: the particle's power in W for one particle in total
  float pdf;    // LightSampler::emission_pdf of the ray
  std::uint32_t light;
  bool delta_position, delta_direction;
};

class LightSampler {
 public:
  explicit LightSampler(const Scene& scene);

  bool empty() const { return power_.probability.empty(); }
  // How `sample` chooses from now on, until then by power; a tree is built here. With BSDF samples, `by_need` leaves even
  // environments to them, unless there is no other light: they are as good as light samples that are even over the sphere. Not
  // to be called while others sample.
  void choose_by(LightChoice choice, DirectSamples samples = DirectSamples::of_lights);
  LightChoice choice() const { return choice_; }
  bool only_even() const;  // there is light, and all of it comes from even environments
  bool any_delta() const { return any_delta_; }
  std::size_t lamps() const;  // number of shapes, points and spots of some power
  double spread() const;      // of their power about its centre, root mean square, over the scene's radius

  // All lights where all are flat, so few that lanes try them in turn, and none of so small a share of the power that sums of
  // single precision, or the steps of 2^-24 in which numbers are drawn, would blur it; else none. Beside them, the
  // probabilities of choosing those up to each, by power.
  static constexpr std::size_t most_flat = 8;
  static constexpr double least_flat_share = 0x1p-12;
  std::span<const FlatLight> flat_lights() const { return flat_; }
  std::span<const float> cumulative() const { return power_.cumulative; }

  std::optional<LightSample> sample(const vec3& position, float u_light, const vec2& u) const;
  // The same, but u.x also chooses the light and is then rescaled to [0, 1): points that are stratified over the square are
  // stratified over all lights together.
  std::optional<LightSample> sample(const vec3& position, vec2 u) const;
  // Density with which `sample` would have found `point` on an emitting surface, seen from `position` along unit wi.
  float pdf(const vec3& position, const vec3& wi, const SurfacePoint& point) const;
  // Gives the same density for environments, all of them together.
  float environment_pdf(const vec3& wi) const { return environment_pdf(wi, direct()); }
  // Probability with which `sample` chooses a light at a position.
  float choice_probability(const vec3& position, std::uint32_t light) const;

  // Radiance a surface point emits towards wo (0 on its dark side).
  Rgb emitted(const SurfacePoint& point, const vec3& wo) const;
  Rgb environment(const vec3& direction) const;

  // Light from infinity enters through a disk that covers Scene::bounds(); infinite planes get none of it beyond. There is none
  // where a plane stands before the disk.
  std::optional<LightRay> emit(float u_light, const vec2& u_position, const vec2& u_direction) const;
  // Density with which `emit` sends a ray along unit `direction`, the way light travels, to the point `to` that it can see: per
  // area and solid angle for area lights; per solid angle for point and spot lights; per area of the disk (and solid angle) for
  // light from infinity, all environments together. It includes the light's selection probability. `normal` as in LightSample.
  float emission_pdf(std::uint32_t light, const vec3& normal, const vec3& direction, const vec3& to) const;
  // The same over the cosine at an area light's side that emits, which may be 0: at the edge of a sphere as `sample` finds it.
  float emission_pdf_over_cosine(std::uint32_t light, const vec3& direction, const vec3& to) const;
  // Density with which `sample` at `to`, a point that the ray meets, finds the ray's origin; for delta lights a probability.
  float direct_pdf(const LightRay& ray, const vec3& to) const;
  // The first environment, which stands for all in emission_pdf.
  std::uint32_t environment_light() const { return environments_[0]; }

 private:
  // Lights chosen in fixed proportions.
  struct Table {
    std::vector<float> probability;  // per light
    std::vector<float> cumulative;   // where lights are few, and no share is small
    std::vector<double> finer;       // cumulative elsewhere

    Table() = default;
    explicit Table(std::span<const double> weights);
    // Rescales u within the chosen light to [0, 1). `salt` is a number beside u (cumulative.h).
    std::size_t choose(float& u, float salt) const;
  };
  struct Chosen {
    std::size_t light;
    float probability;
  };

  void gather_flat_lights();
  LightTree::Emitter as_emitter(std::size_t light) const;
  void build_tree();
  LightChoice needed_choice(DirectSamples samples) const;
  // The proportions in which `sample` chooses where they are fixed, as they are among lights at infinity.
  const Table& direct() const { return own_.probability.empty() ? power_ : own_; }
  Chosen choose_for(const vec3& position, vec2& u) const;  // rescales u.x
  Chosen choose_by_tree(const vec3& position, vec2& u) const;
  std::optional<LightSample> sample_light(const Chosen& chosen, const vec3& position, const vec2& u) const;
  vec3 sample_environment(const EnvironmentLight& light, std::size_t index, const vec2& u) const;  // towards it
  float environment_pdf(const vec3& wi, const Table& choice) const;
  std::optional<LightRay> emit_from_infinity(std::uint32_t light, const vec2& u_position, const vec2& u_direction) const;
  const ImageDistribution* distribution(std::size_t light) const;

  const Scene& scene_;
  LightChoice choice_ = LightChoice::power;
  std::vector<AreaEmitter> emitters_;    // per light
  Table power_, own_;                    // own: where `sample` chooses in other proportions
  LightTree tree_;                       // of lights at finite places
  bool any_delta_ = false;               // a light that no ray can meet
  std::size_t finite_ = 0;               // lights of some power at finite places
  double finite_power_ = 1;              // share of those in all power
  double finite_share_ = 1;              // with which a tree chooses among them
  std::vector<std::uint32_t> infinite_;  // the others
  std::vector<FlatLight> flat_;
  std::vector<std::uint32_t> environments_;
  std::vector<ImageDistribution> distributions_;  // parallel to environments_
  vec3 scene_centre_{0};
  float scene_radius_ = 1;

 public:
  LightSampler(const LightSampler&) = delete;
  LightSampler& operator=(const LightSampler&) = delete;
};

}  // namespace etendue
