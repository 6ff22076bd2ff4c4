#include "framework/transport/bsdf.h"

#include "framework/core/sampling.h"
#include "framework/transport/fresnel.h"
#include "framework/transport/microfacet.h"

namespace etendue {

namespace {

vec3 reflect_about_normal(const vec3& w) { return {-w.x, -w.y, w.z}; }
vec3 reflect(const vec3& w, const vec3& h) { return 2 * glm::dot(w, h) * h - w; }

Frame shading_frame(const SurfacePoint& point, bool anisotropic) {
  Frame frame = Frame::from_normal(point.shading_normal);
  if (!anisotropic) return frame;
  const vec3 tangent = point.tangent - glm::dot(point.tangent, frame.normal) * frame.normal;
  const float length = glm::length(tangent);
  if (length > 0 && std::isfinite(length)) {
    frame.tangent = tangent / length;
    frame.bitangent = glm::cross(frame.normal, frame.tangent);
  }
  return frame;
}

// What a rough interface does between two directions, seen with wo.z > 0: eta is the index beyond it over the one wo is in.
struct RoughInterface {
  Ggx ggx;
  float eta;

  // The half vector of refraction, or of reflection; z > 0. Zero where no microfacet serves ([Walter2007] eq. 13, 16).
  vec3 half_vector(const vec3& wo, const vec3& wi) const {
    const vec3 h = wi.z > 0 ? wo + wi : wo + eta * wi;
    const float length = glm::length(h);
    if (!(length > 0)) return vec3(0);
    const vec3 unit = h / length;
    return unit.z < 0 ? -unit : unit;
  }
  // Solid angle of h per solid angle of wi at refraction ([Walter2007] eq. 17).
  float refraction_jacobian(const vec3& wo, const vec3& wi, const vec3& h) const {
    return eta * eta * std::abs(glm::dot(wi, h)) / square(glm::dot(wo, h) + eta * glm::dot(wi, h));
  }
};

}  // namespace

Bsdf::Bsdf(const Scene& scene, const SurfacePoint& point) : normal_(point.normal) {
  const Material& material = scene.materials[point.material];
  if (const auto* m = std::get_if<Diffuse>(&material)) {
    kind_ = Kind::diffuse;
    has_specular_ = false;
    has_non_specular_ = true;
    reflectance_ = etendue::evaluate(m->reflectance, scene.textures, point.uv);
  } else if (const auto* m = std::get_if<Conductor>(&material)) {
    kind_ = Kind::conductor;
    alpha_ = m->alpha;
    ideal_ = m->ideal;
    reflectance_ = m->tint;
    conductor_eta_ = m->eta;
    conductor_k_ = m->k;
  } else if (const auto* m = std::get_if<Dielectric>(&material)) {
    kind_ = Kind::dielectric;
    alpha_ = vec2(m->alpha);
    eta_ = m->eta;
    reflectance_ = m->reflect_tint;
    transmittance_ = m->transmit_tint;
  } else {
    const auto& plastic = std::get<Plastic>(material);
    kind_ = Kind::plastic;
    alpha_ = vec2(plastic.alpha);
    eta_ = plastic.eta;
    reflectance_ = etendue::evaluate(plastic.reflectance, scene.textures, point.uv);
    const float average = fresnel_average(eta_);
    const float internal = 1 - (1 - average) / (eta_ * eta_);
    base_gain_ = reflectance_ / (eta_ * eta_ * (1.0f - reflectance_ * internal));
  }
  if (kind_ != Kind::diffuse) {
    has_specular_ = etendue::has_specular(material);
    has_non_specular_ = etendue::has_non_specular(material);
  }
  smooth_ = alpha_ == vec2(0);
  frame_ = shading_frame(point, alpha_.x != alpha_.y);
}

Rgb Bsdf::diffuse_albedo() const { return kind_ == Kind::diffuse ? reflectance_ : Rgb(0); }

// The coat is chosen by what it reflects against what the base does.
float Bsdf::coat_probability(float fresnel) const {
  const float base = (1 - fresnel) * mean_component(reflectance_);
  return base == 0 ? 1 : std::clamp(fresnel / (fresnel + base), 0.05f, 0.95f);
}

// f of the diffuse base under the coat: transmission both ways, internal reflections summed.
Rgb Bsdf::plastic_base(float cos_out, float cos_in) const {
  return base_gain_ * ((1 - fresnel_dielectric(cos_out, eta_)) * (1 - fresnel_dielectric(cos_in, eta_)) * inv_pi);
}

Rgb Bsdf::evaluate(const vec3& wo, const vec3& wi, TransportMode mode) const {
  const float out_geometric = glm::dot(wo, normal_), in_geometric = glm::dot(wi, normal_);
  const vec3 out = frame_.to_local(wo), in = frame_.to_local(wi);
  if (out_geometric * in_geometric == 0 || out.z * in.z == 0) return Rgb(0);
  // The two normals must agree on whether this is reflection; else light would leak through a closed surface.
  if ((out_geometric * in_geometric > 0) != (out.z * in.z > 0)) return Rgb(0);
  Rgb value = evaluate_local(out, in);
  if (mode == TransportMode::importance) {
    // [Veach1997] eq. 5.19; and no compression of radiance at an interface, eq. 5.13.
    value *= std::abs((out.z * in_geometric) / (out_geometric * in.z));
    if (out.z * in.z < 0) value *= out.z > 0 ? eta_ * eta_ : 1 / (eta_ * eta_);
  }
  return value;
}

// f |cos wi| for radiance. Opaque surfaces are two-sided: both directions are mirrored to the upper side.
Rgb Bsdf::evaluate_local(const vec3& wo_in, const vec3& wi_in) const {
  const bool below = wo_in.z < 0;
  vec3 wo = wo_in, wi = wi_in;
  if (below) {
    wo.z = -wo.z;
    wi.z = -wi.z;
  }
  switch (kind_) {
    case Kind::diffuse:
      return wi.z > 0 ? reflectance_ * (inv_pi * wi.z) : Rgb(0);
    case Kind::conductor: {
      if (smooth_ || wi.z <= 0) return Rgb(0);
      const Ggx ggx(alpha_);
      const vec3 h = glm::normalize(wo + wi);
      const Rgb fresnel = ideal_ ? Rgb(1) : fresnel_conductor(glm::dot(wo, h), conductor_eta_, conductor_k_);
      return reflectance_ * fresnel * (ggx.density(h) * ggx.masking_shadowing(wo, wi) / (4 * wo.z));
    }
    case Kind::plastic: {
      if (wi.z <= 0) return Rgb(0);
      const Rgb base = plastic_base(wo.z, wi.z) * wi.z;
      if (smooth_) return base;
      const Ggx ggx(alpha_);
      const vec3 h = glm::normalize(wo + wi);
      const float coat =
          fresnel_dielectric(glm::dot(wo, h), eta_) * ggx.density(h) * ggx.masking_shadowing(wo, wi) / (4 * wo.z);
      return base + coat;
    }
    case Kind::dielectric: {
      if (smooth_) return Rgb(0);
      const RoughInterface surface{Ggx(alpha_), below ? 1 / eta_ : eta_};
      const vec3 h = surface.half_vector(wo, wi);
      const float out_h = glm::dot(wo, h), in_h = glm::dot(wi, h);
      if (h == vec3(0) || out_h <= 0 || in_h * wi.z <= 0) return Rgb(0);
      const float fresnel = fresnel_dielectric(out_h, surface.eta);
      if (wi.z > 0)
        return reflectance_ * (fresnel * surface.ggx.density(h) * surface.ggx.masking_shadowing(wo, wi) / (4 * wo.z));
      const vec3 mirrored(wi.x, wi.y, -wi.z);
      const float masking = surface.ggx.masking_shadowing(wo, mirrored);
      // [Walter2007] eq. 21 times |cos wi|, over eta^2: radiance spreads as it leaves the denser side.
      return transmittance_ * ((1 - fresnel) * surface.ggx.density(h) * masking * out_h *
                               surface.refraction_jacobian(wo, wi, h) / (wo.z * surface.eta * surface.eta));
    }
  }
  return Rgb(0);
}

float Bsdf::pdf(const vec3& wo, const vec3& wi) const {
  const vec3 out = frame_.to_local(wo), in = frame_.to_local(wi);
  return out.z * in.z == 0 ? 0 : pdf_local(out, in);
}

float Bsdf::pdf_local(const vec3& wo_in, const vec3& wi_in) const {
  const bool below = wo_in.z < 0;
  vec3 wo = wo_in, wi = wi_in;
  if (below) {
    wo.z = -wo.z;
    wi.z = -wi.z;
  }
  switch (kind_) {
    case Kind::diffuse:
      return wi.z > 0 ? inv_pi * wi.z : 0;
    case Kind::conductor: {
      if (smooth_ || wi.z <= 0) return 0;
      const vec3 h = glm::normalize(wo + wi);
      return Ggx(alpha_).visible_density(wo, h) / (4 * glm::dot(wo, h));
    }
    case Kind::plastic: {
      if (wi.z <= 0) return 0;
      const float coat = coat_probability(fresnel_dielectric(wo.z, eta_));
      const float base = (1 - coat) * inv_pi * wi.z;
      if (smooth_) return base;
      const vec3 h = glm::normalize(wo + wi);
      return base + coat * Ggx(alpha_).visible_density(wo, h) / (4 * glm::dot(wo, h));
    }
    case Kind::dielectric: {
      if (smooth_) return 0;
      const RoughInterface surface{Ggx(alpha_), below ? 1 / eta_ : eta_};
      const vec3 h = surface.half_vector(wo, wi);
      const float out_h = glm::dot(wo, h), in_h = glm::dot(wi, h);
      if (h == vec3(0) || out_h <= 0 || in_h * wi.z <= 0) return 0;
      const float fresnel = fresnel_dielectric(out_h, surface.eta);
      const float density = surface.ggx.visible_density(wo, h);
      return wi.z > 0 ? fresnel * density / (4 * out_h) : (1 - fresnel) * density * surface.refraction_jacobian(wo, wi, h);
    }
  }
  return 0;
}

[[gnu::always_inline]] inline BsdfSample Bsdf::sample_local(const vec3& wo_in, float u_lobe, const vec2& u,
                                                            TransportMode mode) const {
  const bool below = wo_in.z < 0;
  vec3 wo = wo_in;
  if (below) wo.z = -wo.z;
  // Back to the side wo came from.
  const auto placed = [&](BsdfSample s) {
    if (below) s.wi.z = -s.wi.z;
    return s;
  };
  // A lobe with a density: the weight is the whole BSDF over the whole density.
  const auto weighed = [&](const vec3& wi) -> BsdfSample {
    const float density = pdf_local(wo_in, {wi.x, wi.y, below ? -wi.z : wi.z});
    if (!(density > 0)) return {};
    BsdfSample s{.wi = wi, .weight = {}, .pdf_solid_angle = density, .specular = false, .transmitted = wi.z < 0, .eta = 1};
    s.weight = evaluate_local(wo_in, {wi.x, wi.y, below ? -wi.z : wi.z}) / density;
    if (s.transmitted) {
      s.eta = below ? 1 / eta_ : eta_;
      if (mode == TransportMode::importance) s.weight *= s.eta * s.eta;
    }
    return placed(s);
  };

  switch (kind_) {
    case Kind::diffuse: {
      const vec3 wi = sample_cosine_hemisphere(u);
      if (!(wi.z > 0)) return {};
      return placed({.wi = wi, .weight = reflectance_, .pdf_solid_angle = inv_pi * wi.z});
    }
    case Kind::conductor: {
      if (!smooth_) {
        const vec3 wi = reflect(wo, Ggx(alpha_).sample_visible(wo, u));
        return wi.z > 0 ? weighed(wi) : BsdfSample{};
      }
      const Rgb fresnel = ideal_ ? Rgb(1) : fresnel_conductor(wo.z, conductor_eta_, conductor_k_);
      return placed({.wi = reflect_about_normal(wo), .weight = reflectance_ * fresnel, .specular = true});
    }
    case Kind::plastic: {
      const float fresnel = fresnel_dielectric(wo.z, eta_);
      const float coat = coat_probability(fresnel);
      if (u_lobe >= coat) return weighed(sample_cosine_hemisphere(u));
      if (smooth_) return placed({.wi = reflect_about_normal(wo), .weight = Rgb(fresnel / coat), .specular = true});
      const vec3 wi = reflect(wo, Ggx(alpha_).sample_visible(wo, u));
      return wi.z > 0 ? weighed(wi) : BsdfSample{};
    }
    case Kind::dielectric: {
      const float eta = below ? 1 / eta_ : eta_;
      const vec3 h = smooth_ ? vec3(0, 0, 1) : Ggx(alpha_).sample_visible(wo, u);
      const float out_h = glm::dot(wo, h);
      float cos_t = 0;
      const float fresnel = fresnel_dielectric(out_h, eta, &cos_t);
      const bool reflects = u_lobe < fresnel;
      const vec3 wi = reflects ? reflect(wo, h) : (out_h / eta - cos_t) * h - wo / eta;
      if (wi.z == 0 || (wi.z > 0) != reflects) return {};
      if (!smooth_) return weighed(wi);
      BsdfSample s{.wi = wi, .weight = reflects ? reflectance_ : transmittance_, .specular = true, .transmitted = !reflects};
      if (!reflects) {
        s.eta = eta;
        if (mode == TransportMode::radiance) s.weight /= eta * eta;
      }
      return placed(s);
    }
  }
  return {};
}

// Nothing is copied after it was written in parts, which stalls: all is computed first and written once, into the caller's.
BsdfSample Bsdf::sample(const vec3& wo, float u_lobe, const vec2& u, TransportMode mode) const {
  const vec3 out = frame_.to_local(wo);
  if (out.z == 0) return {};
  const BsdfSample local = sample_local(out, u_lobe, u, mode);
  if (!local) return {};
  const vec3 wi = glm::normalize(frame_.to_world(local.wi));
  const float out_geometric = glm::dot(wo, normal_), in_geometric = glm::dot(wi, normal_);
  if ((out_geometric * in_geometric > 0) == local.transmitted || out_geometric * in_geometric == 0) return {};
  const float adjoint =
      mode == TransportMode::importance ? std::abs((out.z * in_geometric) / (out_geometric * local.wi.z)) : 1.0f;
  return {.wi = wi,
          .weight = adjoint * local.weight,
          .pdf_solid_angle = local.pdf_solid_angle,
          .specular = local.specular,
          .transmitted = local.transmitted,
          .eta = local.eta};
}

}  // namespace etendue
