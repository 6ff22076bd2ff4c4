// A cache for rough metals and plastics: records of incident radiance (radiance_cache_records.h), filled and refined beside a
// cache of irradiance.
//
// Which materials, and in how many bands: a GGX lobe seen from above is (1 + (theta / 2 alpha)^2)^-2 about the mirror direction
// ([Walter2007], the half vector turned by half the angle), so that harmonics of degree l see a share x K_1(x), x = 2 alpha l,
// of it (the Hankel transform of that; K_1 is a modified Bessel function). A material of roughness alpha takes the first order
// whose share is below `left_out`; one that needs more than `highest_order` is too narrow to be cached. Seen at grazing angles,
// a lobe is narrower across than this.
//
// For each camera sample the lobe is projected by `lobe_samples` samples of the BSDF, so that materials are not limited to
// those in a table. Records are made, refined and spaced as those of irradiance are (record_levels.h).
#pragma once

#include "integrators/caches/records/cache_file.h"
#include "integrators/caches/records/radiance_cache_records.h"
#include "integrators/caches/records/record_levels.h"

namespace etendue {

struct RoughCacheSettings : RecordSettings {
  int highest_order = 10;
  float left_out = 0.025f;
  int lobe_samples = 4;
  bool gradients = true;
};

// Share of a GGX lobe's amplitude that harmonics of a degree see.
double lobe_share(float alpha, int degree);
// Sum of the squares of a lobe's even coefficients below an order, for a lobe that reflects all light: those of degree l share
// (2 l + 1) / 4 pi, of which even ones have half on the mean over directions.
float lobe_square(float alpha, int order);
// The least order that leaves out no more than that share.
int lobe_order(float alpha, float left_out);

class RoughCache final : public RecordLevels<RadianceEstimate, RadianceRecords> {
 public:
  explicit RoughCache(const RoughCacheSettings& settings) : settings_(settings) {}

  // Light is cached at surfaces with less than `deepest` events before them; `one_level`: records of all depths are shared.
  void prepare(const RenderContext& context, int deepest, bool one_level);
  void take_rays(int samples) { settings_.strata = HemisphereStrata::of(samples); }  // of a pass from now on
  // Has the scene materials to cache at all?
  bool active() const { return order_ > 0; }

  // Its part of a file (record_file.h). `read` throws Error where that holds what no cache of the scene can; the records wait
  // for `resume`, which follows `prepare`. Without `refine` they keep the spacings of their accuracy.
  void write(ByteWriter& out) const;
  void read(const RenderContext& context, ByteReader& in, bool one_level);
  void resume(const RenderContext& context, float accuracy, std::uint64_t key_salt, bool refine);

  bool answers(std::uint32_t material) const { return orders_[material] > 0; }
  // The least roughness of a material that it answers for; infinity where there is none.
  float narrowest() const { return narrowest_; }

  struct Reflected {
    Rgb radiance;
    float error;               // least of the records that serve
    float standard_error = 0;  // of the radiance's luminance, where it was asked for
  };
  // Indirect light that a surface scatters; empty where no record serves.
  std::optional<Reflected> reflected(const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, int depth, Sampler& sampler,
                                     bool states_error) const;
  void add_shapes(std::vector<RecordShape>& shapes) const;

 private:
  void choose_orders(const Scene& scene);
  RadianceRecords make_records(const RenderContext& context) const override;
  void insert(RadianceRecords& records, const History& history) const override;
  RadianceEstimate estimate(const RenderContext& context, const HemisphereRadiance& radiance, const History& history, int depth,
                            std::uint32_t pass) const override;

  RoughCacheSettings settings_;
  int order_ = 0;  // of the records: the highest that a material needs
  float narrowest_ = infinity;
  std::vector<int> orders_;                  // by material; 0: not cached
  std::vector<float> lobe_squares_;          // by material: sum of the squares of its lobe's even coefficients, of unit weight
  float max_spacing_ = 0;                    // metres
  std::vector<std::vector<History>> saved_;  // by level, until they are used
};

}  // namespace etendue
