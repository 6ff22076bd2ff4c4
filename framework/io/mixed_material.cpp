#include "framework/io/mixed_material.h"

namespace etendue {

namespace {

struct Mixing {
  const Rgb& share;

  std::optional<Material> operator()(const Diffuse& a, const Diffuse& b) const {
    if (!a.reflectance.is_constant() || !b.reflectance.is_constant()) return std::nullopt;
    return Diffuse{glm::mix(a.reflectance.constant, b.reflectance.constant, share)};
  }
  std::optional<Material> operator()(const Conductor& a, const Conductor& b) const {
    const bool same_fresnel = a.ideal == b.ideal && (a.ideal || (a.eta == b.eta && a.k == b.k));
    if (!same_fresnel || a.alpha != b.alpha || a.distribution != b.distribution) return std::nullopt;
    Conductor both = a;
    both.tint = glm::mix(a.tint, b.tint, share);
    return both;
  }
  std::optional<Material> operator()(const Dielectric& a, const Dielectric& b) const {
    if (a.eta != b.eta || a.thin != b.thin || a.alpha != b.alpha || a.distribution != b.distribution) return std::nullopt;
    Dielectric both = a;
    both.reflect_tint = glm::mix(a.reflect_tint, b.reflect_tint, share);
    both.transmit_tint = glm::mix(a.transmit_tint, b.transmit_tint, share);
    return both;
  }
  // Through the coat the base looks as albedo / (1 - inside albedo) does: that is what is mixed.
  std::optional<Material> operator()(const Plastic& a, const Plastic& b) const {
    if (!a.reflectance.is_constant() || !b.reflectance.is_constant() || a.coat.eta() != b.coat.eta() ||
        a.coat.depth() != b.coat.depth() || a.alpha != b.alpha || a.distribution != b.distribution)
      return std::nullopt;
    const float inside = a.coat.internal_reflectance();
    const auto seen = [inside](const Rgb& albedo) { return albedo / (1.0f - inside * albedo); };
    const Rgb both_seen = glm::mix(seen(a.reflectance.constant), seen(b.reflectance.constant), share);
    Plastic both = a;
    both.reflectance = both_seen / (1.0f + inside * both_seen);
    return both;
  }
  std::optional<Material> operator()(const DiffuseTransmission& a, const DiffuseTransmission& b) const {
    for (const TexturedRgb& colour : {a.reflectance, b.reflectance, a.transmittance, b.transmittance})
      if (!colour.is_constant()) return std::nullopt;
    return DiffuseTransmission{glm::mix(a.reflectance.constant, b.reflectance.constant, share),
                               glm::mix(a.transmittance.constant, b.transmittance.constant, share)};
  }
  template <class A, class B>
  std::optional<Material> operator()(const A&, const B&) const {
    return std::nullopt;
  }
};

}  // namespace

std::optional<Material> mixed(const Material& a, const Material& b, const Rgb& share) {
  return std::visit(Mixing{share}, a, b);
}

}  // namespace etendue
