// What happens to light at a surface point: evaluate, sample, pdf.
//
// Directions point away from the surface. Everything is in solid angle at the point. Delta lobes are reported by `sample` only;
// `evaluate` and `pdf` leave them out.
#pragma once

#include "framework/core/sampler.h"
#include "framework/scene/scene.h"

namespace etendue {

// Radiance travels to the camera, importance to the lights; they differ at refraction (eta^2) and where the shading normal is
// not the geometric one ([Veach1997] 5.2, 5.3).
enum class TransportMode : std::uint8_t { radiance, importance };

struct BsdfSample {
  vec3 wi{0};
  Rgb weight{0};              // f |cos| / pdf; for delta lobes the same with their discrete probability
  float pdf_solid_angle = 0;  // 0 for delta lobes
  bool specular = false;
  bool transmitted = false;
  float eta = 1;  // relative index crossed, for Russian roulette

  explicit operator bool() const { return !is_black(weight); }
};

class Bsdf {
 public:
  Bsdf(const Scene& scene, const SurfacePoint& point);

  // f(wo, wi) |cos(wi, shading normal)|, with the adjoint correction in importance mode.
  Rgb evaluate(const vec3& wo, const vec3& wi, TransportMode mode = TransportMode::radiance) const;
  float pdf(const vec3& wo, const vec3& wi) const;
  BsdfSample sample(const vec3& wo, float u_lobe, const vec2& u, TransportMode mode = TransportMode::radiance) const;

  bool has_specular() const { return has_specular_; }
  bool has_non_specular() const { return has_non_specular_; }
  bool is_diffuse() const { return kind_ == Kind::diffuse; }  // diffuse only
  bool transmits() const { return kind_ == Kind::dielectric; }
  // Reflectance of the purely diffuse part, for photon gathers and irradiance caches: f = albedo / pi. Black if there is none.
  Rgb diffuse_albedo() const;

 private:
  enum class Kind : std::uint8_t { diffuse, conductor, dielectric, plastic };

  Rgb evaluate_local(const vec3& wo, const vec3& wi) const;
  BsdfSample sample_local(const vec3& wo, float u_lobe, const vec2& u, TransportMode mode) const;
  float pdf_local(const vec3& wo, const vec3& wi) const;
  float coat_probability(float fresnel) const;
  Rgb plastic_base(float cos_out, float cos_in) const;

  Frame frame_;
  vec3 normal_;  // geometric
  Kind kind_;
  bool has_specular_, has_non_specular_, smooth_ = false, ideal_ = false;
  vec2 alpha_{0};
  float eta_ = 1;
  Rgb reflectance_{0};  // diffuse albedo, or tint
  Rgb transmittance_{1};
  Rgb conductor_eta_{1}, conductor_k_{0};
  Rgb base_gain_{0};  // plastic: albedo / (eta^2 (1 - albedo F_internal))
};

}  // namespace etendue
