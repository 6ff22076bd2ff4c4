// Scene::hash and content_hash: every field that changes an image, written out, so that padding and names do not count.
#include "framework/scene/scene.h"

#include <xxhash.h>
#include <memory>
#include <type_traits>

namespace etendue {

namespace {

class Hasher {
 public:
  Hasher() : state_(XXH3_createState(), XXH3_freeState) { XXH3_64bits_reset(state_.get()); }

  // Arithmetic values and GLM vectors: no padding.
  template <class... T>
  void add(const T&... values) {
    (add_bytes(&values, sizeof(values)), ...);
  }
  template <class T>
  void add_vector(const std::vector<T>& values) {
    add(static_cast<std::uint64_t>(values.size()));
    add_bytes(values.data(), values.size() * sizeof(T));
  }
  void add_transform(const Transform& t) {
    add(t.point(vec3(0)), t.vector({1, 0, 0}), t.vector({0, 1, 0}), t.vector({0, 0, 1}));
  }
  std::uint64_t digest() const { return XXH3_64bits_digest(state_.get()); }

  void operator()(const Sphere& s) { add(s.centre, s.radius); }
  void operator()(const Cylinder& c) { add(c.base, c.radius, c.axis, c.length, c.caps); }
  void operator()(const Disk& d) { add(d.centre, d.radius, d.normal, d.inner_radius); }

  void operator()(const Diffuse& m) { add_colour(m.reflectance); }
  void operator()(const Conductor& m) {
    add(m.eta, m.k, m.tint, m.ideal, m.alpha);
    add_distribution(m.distribution);
  }
  void operator()(const Dielectric& m) {
    add(m.eta, m.alpha, m.reflect_tint, m.transmit_tint);
    add_distribution(m.distribution);
    if (m.thin) add(m.thin);
  }
  void operator()(const Plastic& m) {
    add_colour(m.reflectance);
    add(m.coat.eta(), m.coat.internal_reflectance(), m.alpha);
    add_distribution(m.distribution);
    if (m.coat.depth() > 0) add(m.coat.depth());
  }

  void operator()(const DiffuseTransmission& m) {
    add_colour(m.reflectance);
    add_colour(m.transmittance);
  }

  void operator()(const ImageTexture& t) {
    add(t.size, t.uv_scale, t.uv_offset, t.gain);
    if (t.wrap_u != Wrap::repeat || t.wrap_v != Wrap::repeat) add(t.wrap_u, t.wrap_v);
    add_vector(t.texels);
  }
  void operator()(const CheckerTexture& t) { add(t.even, t.odd, t.uv_scale, t.uv_offset); }

  void operator()(const AreaLight& l) {
    add(l.primitive, l.radiance, l.two_sided);
    if (l.texture != no_id) add(l.texture);
  }
  void operator()(const PointLight& l) { add(l.position, l.intensity); }
  void operator()(const SpotLight& l) {
    add(l.position, l.direction, l.intensity, l.cos_outer, l.cos_inner);
    if (l.fade != SpotFade::cubic) add(l.fade == SpotFade::linear);  // hashes of older references stand by this
  }
  void operator()(const DirectionalLight& l) { add(l.direction, l.irradiance); }
  void operator()(const EnvironmentLight& l) {
    add(l.scale, l.size);
    add_vector(l.texels);
    add_transform(l.light_to_world);
  }

  template <class Variants>
  void add_variants(const Variants& variants) {
    add(static_cast<std::uint64_t>(variants.size()));
    for (const auto& variant : variants) {
      add(static_cast<std::uint64_t>(variant.index()));
      std::visit([this](const auto& value) { (*this)(value); }, variant);
    }
  }

  void add_object(const Object& object) {
    add_vector(object.geometry.positions);
    add_vector(object.geometry.triangles);
    add_variants(object.geometry.quadrics);
    add_vector(object.normals);
    add_vector(object.uvs);
    for (const Shape& s : object.shapes) {
      add(s.first_primitive, s.primitive_count, s.material, s.first_light, s.flip_normal, s.has_normals, s.has_uvs);
      if (s.mask != no_id) add(s.mask);
    }
  }

  void add_content(const Scene& scene) {
    for (const Object& object : scene.objects) add_object(object);
    for (const Instance& instance : scene.instances) {
      add(instance.object);
      add_transform(instance.to_world);
    }
    for (const InfinitePlane& plane : scene.planes) add(plane.point, plane.normal, plane.material);
    add_variants(scene.materials);
    add_variants(scene.textures);
    for (const Relief& r : scene.reliefs) add(r.kind, r.material, r.texture, r.scale);
    add_variants(scene.lights);
  }

 private:
  void add_distribution(NormalDistribution distribution) {
    if (distribution != NormalDistribution::ggx) add(distribution);
  }
  void add_colour(const TexturedRgb& c) { add(c.constant, c.texture); }
  void add_bytes(const void* data, std::size_t size) {
    if (size > 0) XXH3_64bits_update(state_.get(), data, size);
  }

  std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state_;
};

}  // namespace

std::uint64_t Scene::content_hash() const {
  Hasher h;
  h.add_content(*this);
  return h.digest();
}

std::uint64_t Scene::hash() const {
  Hasher h;
  h.add_content(*this);
  h.add_transform(camera.to_world);
  h.add(camera.fov, camera.lens_radius, camera.focal_distance, resolution, max_depth.value_or(0));
  if (max_depth == 0) h.add(true);  // which is not the same as none
  if (camera.is_parallel()) h.add(camera.half_width);
  if (filter) {
    const FilterShape& f = filter->shape();
    h.add(f.kind, f.radius, f.sigma, f.b, f.c, f.tau);
  }
  return h.digest();
}

}  // namespace etendue
