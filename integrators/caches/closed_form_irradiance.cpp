#include "integrators/caches/closed_form_irradiance.h"

#include "framework/core/check.h"
#include "framework/core/error.h"
#include "framework/transport/bsdf.h"
#include "framework/transport/ray_tools.h"

#include <fmt/format.h>

#include <array>

namespace etendue {

namespace {

constexpr float step_share = 2e-3f;  // of the scene's diagonal: rounding of positions is 1e-4 of it at most

// Irradiance over (x, y) in the tangent plane at a point, by rays that fall on the surface from a step above.
class TangentPlane {
 public:
  TangentPlane(const RenderContext& context, const CachePoint& point, float step)
      : context_(context), point_(point), frame_(Frame::from_normal(point.normal)), step_(step) {}

  struct Value {
    dvec2 at;  // where the rounded ray actually lands
    dvec3 irradiance;
  };
  std::optional<Value> at(int x, int y) const {
    const vec3 offset = step_ * (static_cast<float>(x) * frame_.tangent + static_cast<float>(y) * frame_.bitangent);
    const float height = x == 0 && y == 0 ? 0.02f * step_ : step_;  // at the point itself less may stand between
    const Ray ray{.origin = point_.position + offset + height * point_.normal, .direction = -point_.normal};
    const Hit hit = trace(context_, ray);
    if (!hit || std::abs(hit.t - height) > 0.5f * height) return std::nullopt;
    const SurfacePoint surface = context_.scene.surface_at(ray, hit);
    const Bsdf bsdf(context_.scene, surface);
    if (!bsdf.is_diffuse()) return std::nullopt;
    const dvec3 radiance = context_.scene.closed_form->radiance(ray) - dvec3(context_.lights.emitted(surface, point_.normal));
    const dvec3 moved = dvec3(ray.origin) - dvec3(point_.position), albedo(bsdf.diffuse_albedo());
    Value value{{glm::dot(moved, dvec3(frame_.tangent)), glm::dot(moved, dvec3(frame_.bitangent))}, dvec3(0)};
    for (int c = 0; c < 3; ++c)
      if (albedo[c] > 0) value.irradiance[c] = std::numbers::pi * radiance[c] / albedo[c];
    return value;
  }
  const Frame& frame() const { return frame_; }

 private:
  const RenderContext& context_;
  const CachePoint& point_;
  Frame frame_;
  float step_;
};

using Stencil = std::array<std::array<std::optional<TangentPlane::Value>, 3>, 3>;  // by x + 1, y + 1

// First derivative along an axis, by the neighbours there are.
dvec3 slope(const TangentPlane::Value& here, const std::optional<TangentPlane::Value>& before,
            const std::optional<TangentPlane::Value>& after, int axis) {
  const TangentPlane::Value &a = before ? *before : here, &b = after ? *after : here;
  const double way = b.at[axis] - a.at[axis];
  return way > 0 ? (b.irradiance - a.irradiance) / way : dvec3(0);
}

TangentMatrix second_differences(const Stencil& values, double step) {
  const auto y = [&](int i, int j) { return static_cast<double>(luminance(Rgb(values[i][j]->irradiance))); };
  const double inverse = 1 / (step * step);
  return {(y(2, 1) - 2 * y(1, 1) + y(0, 1)) * inverse, 0.25 * (y(2, 2) - y(2, 0) - y(0, 2) + y(0, 0)) * inverse,
          (y(1, 2) - 2 * y(1, 1) + y(1, 0)) * inverse};
}

}  // namespace

IrradianceEstimate closed_form_irradiance(const RenderContext& context, const CachePoint& point) {
  CHECK(context.scene.closed_form.has_value());
  const float step = step_share * glm::length(context.bounds.diagonal());
  const TangentPlane plane(context, point, step);
  Stencil values;
  bool whole = true;
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y) {
      values[x][y] = plane.at(x - 1, y - 1);
      whole = whole && values[x][y];
    }
  if (!values[1][1])
    throw Error(fmt::format("irradiance by closed form: {} has another than a diffuse surface at ({:.3g}, {:.3g}, {:.3g})",
                            context.scene.name, point.position.x, point.position.y, point.position.z));
  IrradianceEstimate estimate;
  const TangentPlane::Value& here = *values[1][1];
  estimate.irradiance = Rgb(here.irradiance);
  const dvec3 x = slope(here, values[0][1], values[2][1], 0), y = slope(here, values[1][0], values[1][2], 1);
  for (int c = 0; c < 3; ++c)
    estimate.translation[c] =
        static_cast<float>(x[c]) * plane.frame().tangent + static_cast<float>(y[c]) * plane.frame().bitangent;
  if (whole) estimate.hessian = second_differences(values, step);
  return estimate;
}

}  // namespace etendue
