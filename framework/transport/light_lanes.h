// Light samples and particles in lanes (lanes.h), the same as LightSampler::sample and emit give one by one.
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

// The flat light that a number chooses in each lane.
template <class F>
struct ChosenLight {
  TrianglePlaneOf<F> plane;
  Vec3<F> radiance;
  F area, chosen, two_sided, before, width;

  ChosenLight(const LightSampler& lights, F u) {
    const std::span<const FlatLight> flat = lights.flat_lights();
    const std::span<const float> cumulative = lights.cumulative();
    set(flat[0], 0, cumulative[0], true);
    for (std::size_t i = 1; i < flat.size(); ++i) set(flat[i], cumulative[i - 1], cumulative[i], cumulative[i - 1] <= u);
  }

 private:
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

// u.x chooses the light, and is rescaled as LightSampler::sample does.
template <class F>
LightSampleOf<F> sample_lights(const LightSampler& lights, const Vec3<F>& position, Vec2<F> u, Mask<F> wanted) {
  const std::span<const FlatLight> flat = lights.flat_lights();
  // Few flat lights are tried in turn; of other kinds, if there are more, or where the choice depends on the position, lanes
  // choose one by one.
  if (flat.empty() || lights.choice() != LightChoice::power) return sample_lights_one_by_one<F>(lights, position, u, wanted);
  const ChosenLight<F> light(lights, u.x);
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

// A particle in each lane; black where none is emitted.
template <class F>
struct EmittedOf {
  Vec3<F> origin{0.0f}, direction{0.0f}, power{0.0f};
  F t_min = 0.0f;  // of the ray, above 0 from points and spots
};

template <class F>
EmittedOf<F> emit_particles(const LightSampler& lights, F u_light, const Vec2<F>& u_position, Vec2<F> u_direction,
                            Mask<F> wanted) {
  EmittedOf<F> out;
  if (lights.flat_lights().empty()) {
    for_lanes(wanted, [&](int i) {
      const auto emitted = lights.emit(lane(u_light, i), vec2(lane(u_position.x, i), lane(u_position.y, i)),
                                       vec2(lane(u_direction.x, i), lane(u_direction.y, i)));
      if (!emitted) return;
      set_lane(out.origin, i, emitted->ray.origin);
      set_lane(out.direction, i, emitted->ray.direction);
      set_lane(out.power, i, emitted->power);
      set_lane(out.t_min, i, emitted->ray.t_min);
    });
    return out;
  }
  const ChosenLight<F> light(lights, u_light);
  const TrianglePointOf<F> point = point_of<F>(light.plane, sample_triangle(u_position));
  const Mask<F> two_sided = light.two_sided > 0, back = two_sided & (u_direction.x < 0.5f);
  u_direction.x = select(two_sided, select(back, 2 * u_direction.x, 2 * u_direction.x - 1), u_direction.x);
  const Vec3<F> normal = select(back, -light.plane.normal, light.plane.normal);
  out.origin = point.position + point.clearance * normal;
  out.direction = FrameOf<Vec3<F>>::from_normal(normal).to_world(sample_cosine_hemisphere(u_direction));
  const Vec3<F> power = light.radiance * (pi * light.area * select(two_sided, F(2.0f), F(1.0f)) / light.chosen);
  out.power = select(wanted & (light.area > 0) & (light.chosen > 0), power, Vec3<F>(0.0f));
  return out;
}

}  // namespace etendue
