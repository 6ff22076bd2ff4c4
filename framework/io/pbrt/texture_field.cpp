#include "framework/io/pbrt/texture_field.h"

#include "framework/core/elementary.h"
#include "framework/core/fuzzing.h"
#include "framework/core/sampling.h"
#include "framework/io/pbrt/noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

constexpr int most_cost = 64;

Field make_field(std::function<Rgb(const TexturePlace&)> at, bool uses_position) {
  return std::make_shared<const TextureField>(TextureField{std::move(at), uses_position, 0, 1});
}

// Places solid textures. Version 3 looks them up by the transform itself where its inverse is meant (IdentityMapping3D).
Transform solid_mapping(const Transform& to_world, bool version3) { return version3 ? to_world : to_world.inverse(); }

bool is_even(float n) { return std::fmod(std::abs(n), 2.0f) == 0; }

// A cell of the unit grid has a dot where noise says so, moved by noise within the cell.
bool in_dot(const vec2& st) {
  constexpr float radius = 0.35f, most_shift = 0.5f - radius;
  const vec2 cell = glm::floor(st + 0.5f);
  const auto noise = [&](float s, float t) { return perlin_noise({cell.x + s, cell.y + t, 0.5f}); };
  if (!(noise(0.5f, 0.5f) > 0)) return false;
  const vec2 off = st - cell - most_shift * vec2(noise(1.5f, 2.8f), noise(4.5f, 9.8f));
  return glm::dot(off, off) < radius * radius;
}

Rgb marble(vec3 p, float scale, float variation, float roughness, int octaves) {
  static constexpr float colours[9][3] = {{0.58f, 0.58f, 0.6f}, {0.58f, 0.58f, 0.6f}, {0.58f, 0.58f, 0.6f},
                                          {0.5f, 0.5f, 0.5f},   {0.6f, 0.59f, 0.58f}, {0.58f, 0.58f, 0.6f},
                                          {0.58f, 0.58f, 0.6f}, {0.2f, 0.2f, 0.33f},  {0.58f, 0.58f, 0.6f}};
  constexpr int segments = 6;
  p *= scale;
  float t = 0.5f + 0.5f * math::sin(p.y + variation * fractal_noise(p, roughness, octaves));
  t = std::isfinite(t) ? t : 0;
  const int first = std::min(static_cast<int>(t * segments), segments - 1);
  t = t * segments - static_cast<float>(first);
  Rgb c[4];
  for (int i = 0; i < 4; ++i) c[i] = {colours[first + i][0], colours[first + i][1], colours[first + i][2]};
  for (int left = 3; left > 0; --left)
    for (int i = 0; i < left; ++i) c[i] = glm::mix(c[i], c[i + 1], t);
  return 1.5f * c[0];  // as pbrt brightens it
}

Field over_mapping(const PbrtParams& params, const TextureMapping& mapping, std::vector<Field> operands,
                   const std::function<Rgb(const vec2&, const TexturePlace&, std::span<const Field>)>& value) {
  const Field all = combined_field(params, std::move(operands), [=](const TexturePlace& place, std::span<const Field> fields) {
    return value(mapping.at(place), place, fields);
  });
  TextureField field = *all;
  field.uses_position = field.uses_position || !mapping.is_uv();
  return std::make_shared<const TextureField>(std::move(field));
}

}  // namespace

Field constant_field(const Rgb& value) {
  return make_field([value](const TexturePlace&) { return value; }, false);
}

Field texture_field(const Texture& texture) {
  const auto shared = std::make_shared<const Texture>(texture);
  TextureField field{[shared](const TexturePlace& place) { return evaluate(*shared, place.uv); }, false, 0, 1};
  if (const auto* image = std::get_if<ImageTexture>(shared.get())) {
    const vec2 texels = vec2(image->size) * glm::abs(image->uv_scale);
    field.resolution = static_cast<int>(std::min(std::max(texels.x, texels.y), 1e6f));
  }
  return std::make_shared<const TextureField>(std::move(field));
}

Field mapped_field(const Field& field, const std::function<Rgb(const Rgb&)>& map) {
  TextureField mapped = *field;
  mapped.at = [field, map](const TexturePlace& place) { return map(field->at(place)); };
  return std::make_shared<const TextureField>(std::move(mapped));
}

Field combined_field(const PbrtParams& params, std::vector<Field> fields,
                     const std::function<Rgb(const TexturePlace&, std::span<const Field>)>& combine) {
  TextureField all;
  for (const Field& field : fields) {
    all.uses_position |= field->uses_position;
    all.resolution = std::max(all.resolution, field->resolution);
    all.cost += field->cost;
  }
  if (all.cost > most_cost)
    throw Error(params.where(), fmt::format("{}: is composed of more than {} textures", params.owner(), most_cost));
  all.at = [fields = std::move(fields), combine](const TexturePlace& place) { return combine(place, fields); };
  return std::make_shared<const TextureField>(std::move(all));
}

TextureMapping::TextureMapping(const PbrtParams& params, const Transform& to_world, bool of_version3)
    : scale(params.number("uscale", 1), params.number("vscale", 1)),
      offset(params.number("udelta", 0), params.number("vdelta", 0)),
      v1(params.point("v1", {1, 0, 0})),
      v2(params.point("v2", {0, 1, 0})),
      version3(of_version3) {
  const std::string name = params.string("mapping", "uv");
  constexpr std::string_view names[] = {"uv", "planar", "spherical", "cylindrical"};
  const auto* const found = std::find(std::begin(names), std::end(names), name);
  if (found == std::end(names))
    params.fail("mapping", fmt::format("is '{}'; expected uv, planar, spherical or cylindrical", name));
  kind = static_cast<Kind>(found - std::begin(names));
  // Version 3 projects on planes of the world, wherever the texture is defined.
  if (!(kind == Kind::planar && version3)) to_texture = to_world.inverse();
}

vec2 TextureMapping::at(const TexturePlace& place) const {
  vec2 st = place.uv * scale + offset;
  if (!is_uv()) {
    const vec3 p = to_texture.point(place.position);
    const vec3 d = p / std::max(glm::length(p), 1e-30f);
    const float azimuth = math::atan2(p.y, p.x) / (2 * pi), turn = azimuth < 0 ? azimuth + 1 : azimuth;
    st = kind == Kind::planar      ? offset + vec2(glm::dot(p, v1), glm::dot(p, v2))
         : kind == Kind::spherical ? vec2(math::acos(std::clamp(d.z, -1.0f, 1.0f)) / pi, turn)
                                   : vec2(0.5f + azimuth, version3 ? d.z : p.z);  // version 3 takes a sphere's height
  }
  return is_finite({st, 0}) ? st : vec2(0);
}

Field procedural_field(const std::string& type, const PbrtParams& params, const Transform& to_world, bool version3,
                       const ReadOperand& operand) {
  if (type == "dots" || type == "uv" || type == "bilerp") {
    const TextureMapping mapping(params, to_world, version3);
    if (type == "uv")
      return over_mapping(params, mapping, {}, [](const vec2& st, const TexturePlace&, std::span<const Field>) {
        return Rgb(st - glm::floor(st), 0);
      });
    if (type == "dots")
      return over_mapping(
          params, mapping, {operand("outside", Rgb(0)), operand("inside", Rgb(1))},
          [](const vec2& st, const TexturePlace& place, std::span<const Field> f) { return f[in_dot(st) ? 1 : 0]->at(place); });
    return over_mapping(
        params, mapping, {operand("v00", Rgb(0)), operand("v10", Rgb(0)), operand("v01", Rgb(1)), operand("v11", Rgb(1))},
        [](const vec2& st, const TexturePlace& p, std::span<const Field> f) {
          return glm::mix(glm::mix(f[0]->at(p), f[1]->at(p), st.x), glm::mix(f[2]->at(p), f[3]->at(p), st.x), st.y);
        });
  }
  const Transform to_texture = solid_mapping(to_world, version3);
  const auto grey = [&](const std::function<float(const vec3&)>& value) {
    return make_field([=](const TexturePlace& place) { return Rgb(value(to_texture.point(place.position))); }, true);
  };
  if (type == "windy")
    return grey([](const vec3& p) { return std::abs(fractal_noise(0.1f * p, 0.5f, 3)) * fractal_noise(p, 0.5f, 6); });
  if (type != "fbm" && type != "wrinkled" && type != "marble") return nullptr;
  const int octaves = params.integer("octaves", 8, 1, 64);
  const float roughness = params.number("roughness", 0.5f, 0, 1);
  if (type == "fbm") return grey([=](const vec3& p) { return fractal_noise(p, roughness, octaves); });
  if (type == "wrinkled") return grey([=](const vec3& p) { return turbulence(p, roughness, octaves); });
  const float scale = params.number("scale", 1), variation = params.number("variation", 0.2f);
  return make_field(
      [=](const TexturePlace& place) { return marble(to_texture.point(place.position), scale, variation, roughness, octaves); },
      true);
}

Field checkerboard_field(const PbrtParams& params, const Transform& to_world, bool version3, const ReadOperand& operand) {
  const std::vector<Field> operands{operand("tex1", Rgb(1)), operand("tex2", Rgb(0))};
  if (params.integer("dimension", 2, 2, 3) == 2)
    return over_mapping(params, TextureMapping(params, to_world, version3), operands,
                        [](const vec2& st, const TexturePlace& place, std::span<const Field> f) {
                          return f[is_even(std::floor(st.x) + std::floor(st.y)) ? 0 : 1]->at(place);
                        });
  const Transform to_texture = solid_mapping(to_world, version3);
  TextureField field = *combined_field(params, operands, [=](const TexturePlace& place, std::span<const Field> f) {
    const vec3 cell = glm::floor(to_texture.point(place.position));
    return f[is_even(cell.x + cell.y + cell.z) ? 0 : 1]->at(place);
  });
  field.uses_position = true;
  return std::make_shared<const TextureField>(std::move(field));
}

Field direction_mix_field(const PbrtParams& params, const Transform& to_world, const ReadOperand& operand) {
  const vec3 direction = to_world.vector(params.point("dir", {0, 1, 0}));
  const float length = glm::length(direction);
  if (!(length > 0) || !std::isfinite(length)) params.fail("dir", "has no direction");
  TextureField field = *combined_field(params, {operand("tex1", Rgb(0)), operand("tex2", Rgb(1))},
                                       [unit = direction / length](const TexturePlace& place, std::span<const Field> f) {
                                         return glm::mix(f[1]->at(place), f[0]->at(place),
                                                         std::min(std::abs(glm::dot(place.normal, unit)), 1.0f));
                                       });
  field.uses_position = true;
  return std::make_shared<const TextureField>(std::move(field));
}

Field image_field(ImageTexture image, const TextureMapping& mapping) {
  const vec2 texels = vec2(image.size) * (mapping.is_uv() ? glm::abs(mapping.scale) : vec2(1));
  image.uv_scale = vec2(1);
  image.uv_offset = vec2(0);
  const auto shared = std::make_shared<const Texture>(std::move(image));
  return std::make_shared<const TextureField>(
      TextureField{[=](const TexturePlace& place) { return evaluate(*shared, mapping.at(place)); }, !mapping.is_uv(),
                   static_cast<int>(std::min(std::max(texels.x, texels.y), 1e6f)), 1});
}

Rgb mean_of(const Field& field) {
  constexpr int side = unless_fuzzed(64, 4);
  dvec3 sum(0);
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const vec2 uv((static_cast<float>(i) + 0.5f) / side, (static_cast<float>(j) + 0.5f) / side);
      const vec3 normal = sample_unit_sphere(uv);
      const Rgb value = field->at({uv, 16.0f * vec3(uv, uv.x + uv.y), normal});
      if (is_finite(value)) sum += dvec3(value);
    }
  return Rgb(sum / static_cast<double>(side * side));
}

}  // namespace etendue
