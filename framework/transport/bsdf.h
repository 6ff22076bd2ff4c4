// The BSDF of a surface point: evaluate, sample, pdf.
//
// Directions point away from the surface. Everything is in solid angle at the point. Delta lobes are reported by `sample` only;
// `evaluate` and `pdf` leave them out. Materials themselves are framework/materials/: here their lobes are placed in the world.
#pragma once

#include "framework/core/sampler.h"
#include "framework/scene/scene.h"

namespace etendue {

using BsdfSample = BsdfSampleOf<float>;

// The values of a BSDF for two directions: f(wo, wi) |cos(wi)|, and the densities of wi given wo and of wo given wi, which are
// of no meaning where the value is black.
template <class F>
struct BsdfPairOf {
  Vec3<F> value{0.0f};
  F pdf{0.0f}, pdf_reverse{0.0f};
};
using BsdfPair = BsdfPairOf<float>;

// Lobes of one material at a point, or at one in each lane.
template <class F, class Lobes>
struct PlacedLobes {
  FrameOf<Vec3<F>> frame;  // about the shading normal
  Vec3<F> normal;          // geometric
  Lobes lobes;

  // f(wo, wi) |cos(wi, shading normal)|, with the adjoint correction in importance mode.
  Vec3<F> evaluate(const Vec3<F>& wo, const Vec3<F>& wi, TransportMode mode = TransportMode::radiance) const {
    const F out_geometric = dot(wo, normal), in_geometric = dot(wi, normal);
    const Vec3<F> out = frame.to_local(wo), in = frame.to_local(wi);
    const F geometric = out_geometric * in_geometric, shading = out.z * in.z;
    // The two normals must agree on whether this is reflection; else light would leak through a closed surface.
    const Mask<F> valid = ((geometric > 0) & (shading > 0)) | ((geometric < 0) & (shading < 0));
    if (!any(valid)) return Vec3<F>(0.0f);
    const Mask<F> below = out.z < 0;
    Vec3<F> value = lobes.evaluate(mirrored(out, below), mirrored(in, below), below);
    if (mode == TransportMode::importance) {
      // [Veach1997] eq. 5.19; and no compression of radiance at an interface, eq. 5.13.
      value *= abs((out.z * in_geometric) / (out_geometric * in.z));
      if constexpr (Lobes::transmits) {
        const F eta2 = select(below, 1 / (F(lobes.m.eta) * lobes.m.eta), F(lobes.m.eta) * lobes.m.eta);
        value = select(shading < 0, value * eta2, value);
      }
    }
    return select(valid, value, Vec3<F>(0.0f));
  }
  F pdf(const Vec3<F>& wo, const Vec3<F>& wi) const {
    const Vec3<F> out = frame.to_local(wo), in = frame.to_local(wi);
    const Mask<F> below = out.z < 0;
    return select(out.z * in.z == 0, F(0.0f), lobes.pdf(mirrored(out, below), mirrored(in, below), below));
  }
  BsdfPairOf<F> pair(const Vec3<F>& wo, const Vec3<F>& wi, TransportMode mode = TransportMode::radiance) const {
    const Vec3<F> value = evaluate(wo, wi, mode);
    if (all(is_black(value))) return {};
    return {value, pdf(wo, wi), pdf(wi, wo)};
  }
  BsdfSampleOf<F> sample(const Vec3<F>& wo, F u_lobe, const Vec2<F>& u, TransportMode mode = TransportMode::radiance) const {
    const Vec3<F> out = frame.to_local(wo);
    const Mask<F> below = out.z < 0;
    BsdfSampleOf<F> s = lobes.sample(mirrored(out, below), below, u_lobe, u, mode);
    const Vec3<F> local = mirrored(s.wi, below);
    s.wi = normalize(frame.to_world(local));
    const F out_geometric = dot(wo, normal), in_geometric = dot(s.wi, normal), geometric = out_geometric * in_geometric;
    const Mask<F> valid = (out.z != 0) & (geometric != 0) & ((geometric > 0) != s.transmitted) & !is_black(s.weight);
    if (mode == TransportMode::importance) s.weight *= abs((out.z * in_geometric) / (out_geometric * local.z));
    s.weight = select(valid, s.weight, Vec3<F>(0.0f));
    return s;
  }

 private:
  static Vec3<F> mirrored(const Vec3<F>& w, Mask<F> below) { return {w.x, w.y, select(below, -w.z, w.z)}; }
};

// The frame that lobes are placed in: along the surface's tangent where they are anisotropic.
template <class V>
FrameOf<V> shading_frame(const V& shading_normal, const V& tangent, bool anisotropic) {
  auto frame = FrameOf<V>::from_normal(shading_normal);
  if (!anisotropic) return frame;
  const V along = tangent - dot(tangent, frame.normal) * frame.normal;
  const auto length_along = length(along);
  const auto known = (length_along > 0) & (length_along < infinity);
  const V unit = along / length_along;
  frame.tangent = select(known, unit, frame.tangent);
  frame.bitangent = select(known, cross(frame.normal, unit), frame.bitangent);
  return frame;
}

// Places a material's lobes at a point, or at one in each lane. `colour` looks up a TexturedRgb there.
template <class F, class M, class Point, class Colours>
auto place_lobes(const M& material, const Point& point, const Colours& colour) {
  using Lobes = typename M::template Lobes<F>;
  bool anisotropic = false;
  if constexpr (requires { material.is_anisotropic(); }) anisotropic = material.is_anisotropic();
  return PlacedLobes<F, Lobes>{shading_frame(point.shading_normal, point.tangent, anisotropic), point.normal,
                               Lobes(material, colour)};
}

// The BSDF of any material at one point.
class Bsdf {
 public:
  Bsdf(const Scene& scene, const SurfacePoint& point);

  Rgb evaluate(const vec3& wo, const vec3& wi, TransportMode mode = TransportMode::radiance) const;
  float pdf(const vec3& wo, const vec3& wi) const;
  BsdfPair pair(const vec3& wo, const vec3& wi, TransportMode mode = TransportMode::radiance) const;
  BsdfSample sample(const vec3& wo, float u_lobe, const vec2& u, TransportMode mode = TransportMode::radiance) const;

  bool has_specular() const { return has_specular_; }
  bool has_non_specular() const { return has_non_specular_; }
  bool is_diffuse() const { return std::holds_alternative<Placed<Diffuse>>(placed_); }  // diffuse only
  bool transmits() const {
    return std::visit([]<class Lobes>(const PlacedLobes<float, Lobes>&) { return Lobes::transmits; }, placed_);
  }
  // Reflectance of the purely diffuse part, for photon gathers and irradiance caches: f = albedo / pi. Black if there is none.
  Rgb diffuse_albedo() const;

 private:
  template <class M>
  using Placed = PlacedLobes<float, typename M::template Lobes<float>>;
  template <class Materials>
  struct OfVariant;
  template <class... M>
  struct OfVariant<std::variant<M...>> {
    using type = std::variant<Placed<M>...>;
  };
  using AnyPlaced = OfVariant<Material>::type;

  static AnyPlaced place(const Scene& scene, const SurfacePoint& point);

  AnyPlaced placed_;
  bool has_specular_, has_non_specular_;
};

}  // namespace etendue
