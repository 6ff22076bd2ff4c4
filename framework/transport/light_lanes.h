// Light samples in lanes (lanes.h), the same as LightSampler::sample gives one by one.
#pragma once

#include "framework/transport/light_sampling.h"

namespace etendue {

// Samples lights of any kind one by one, for the lanes of `wanted`.
template <class F>
LightSampleOf<F> sample_lights_one_by_one(const LightSampler& lights, const Vec3<F>& position, const Vec2<F>& u,
                                          Mask<F> wanted) {
  LightSampleOf<F> out;
  F delta = 0.0f;
  for_lanes(wanted, [&](int i) {
    const auto s = lights.sample(lane(position, i), vec2(lane(u.x, i), lane(u.y, i)));
    if (!s) return;
    set_lane(out.wi, i, s->wi);
    set_lane(out.distance, i, s->distance);
    set_lane(out.radiance, i, s->radiance);
    set_lane(out.pdf_solid_angle, i, s->pdf_solid_angle);
    set_lane(delta, i, s->delta ? 1.0f : 0.0f);
    set_lane(out.end, i, s->end);
  });
  out.delta = delta != 0;
  return out;
}

// The flat light that u.x chooses in each lane; u.x is rescaled as LightSampler::sample does.
template <class F>
struct ChosenLight {
  TrianglePlaneOf<F> plane;
  Vec3<F> radiance;
  F area, chosen, two_sided, before, width;

  void set(const FlatLight& light, float cumulative_before, float cumulative, Mask<F> where) {
    const auto put = [where](auto& to, const auto& value) { to = select(where, std::remove_cvref_t<decltype(to)>(value), to); };
    put(plane.p0, light.plane.p0);
    put(plane.e1, light.plane.e1);
    put(plane.e2, light.plane.e2);
    put(plane.normal, light.plane.normal);
    put(plane.doubled, light.plane.doubled);
    put(plane.extent, light.plane.extent);
    put(radiance, light.radiance);
    put(area, light.area);
    put(chosen, light.chosen);
    put(two_sided, light.two_sided);
    put(before, cumulative_before);
    put(width, cumulative - cumulative_before);
  }
};

template <class F>
LightSampleOf<F> sample_lights(const LightSampler& lights, const Vec3<F>& position, Vec2<F> u, Mask<F> wanted) {
  constexpr std::size_t most = 8;  // lights that are tried in turn; beyond, lanes choose one by one
  const std::span<const FlatLight> flat = lights.flat_lights();
  if (flat.empty() || flat.size() > most) return sample_lights_one_by_one<F>(lights, position, u, wanted);
  const std::span<const float> cumulative = lights.cumulative();
  ChosenLight<F> light;
  light.set(flat[0], 0, cumulative[0], true);
  for (std::size_t i = 1; i < flat.size(); ++i) light.set(flat[i], cumulative[i - 1], cumulative[i], cumulative[i - 1] <= u.x);
  if (flat.size() > 1)
    u.x = select(light.width > 0, min(max(F(0.0f), (u.x - light.before) / light.width), F(0x1.fffffep-1f)), F(0.0f));
  const TrianglePointOf<F> point = point_of<F>(light.plane, sample_triangle(u));
  const AreaSampleOf<F> seen =
      seen_from<F>(position, point.position, light.plane.normal, point.clearance, light.area, light.two_sided > 0);
  LightSampleOf<F> out;
  out.wi = seen.wi;
  out.distance = seen.distance;
  out.radiance = light.radiance;
  out.pdf_solid_angle = light.chosen * seen.pdf_solid_angle;
  out.end = seen.end;
  return out;
}

}  // namespace etendue
