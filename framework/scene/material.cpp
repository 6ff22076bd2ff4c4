#include "framework/scene/material.h"

namespace etendue {

namespace {

struct HasSpecular {
  bool operator()(const Diffuse&) const { return false; }
  bool operator()(const Conductor& m) const { return m.alpha == vec2(0); }
  bool operator()(const Dielectric& m) const { return m.alpha == 0; }
  bool operator()(const Plastic& m) const { return m.alpha == 0; }
};

struct HasNonSpecular {
  bool operator()(const Diffuse&) const { return true; }
  bool operator()(const Conductor& m) const { return m.alpha != vec2(0); }
  bool operator()(const Dielectric& m) const { return m.alpha != 0; }
  bool operator()(const Plastic&) const { return true; }
};

struct UsesUvs {
  bool operator()(const Diffuse& m) const { return !m.reflectance.is_constant(); }
  bool operator()(const Conductor& m) const { return m.alpha.x != m.alpha.y; }
  bool operator()(const Dielectric&) const { return false; }
  bool operator()(const Plastic& m) const { return !m.reflectance.is_constant(); }
};

}  // namespace

bool has_specular(const Material& material) { return std::visit(HasSpecular{}, material); }
bool has_non_specular(const Material& material) { return std::visit(HasNonSpecular{}, material); }
bool uses_uvs(const Material& material) { return std::visit(UsesUvs{}, material); }

}  // namespace etendue
