// Alpha of shapes and opacity of their materials, as masks of the scene's shapes.
//
// What varies over (u, v) is asked where rays meet it. What varies by the place, and on lights, is cut away as holes in the
// mesh.

#include "framework/io/mesh/cut_away.h"
#include "framework/io/pbrt/reader.h"

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

// A texture of alpha in version 3, where only 0 lets light through.
struct Opaque {
  Texture operator()(ImageTexture t) const {
    t.gain = std::min(std::abs(t.gain) * 1e9f, 1e30f);
    return t;
  }
  Texture operator()(CheckerTexture t) const {
    t.even = Rgb(mean_component(t.even) != 0);
    t.odd = Rgb(mean_component(t.odd) != 0);
    return t;
  }
};

Opacity opacity_of(const Field& field) {
  return [field](const vec2& uv, const vec3& position) { return mean_component(field->at({uv, position})); };
}

}  // namespace

// The texture of 'alpha', if it is one that varies.
PbrtReader::TextureEntry* PbrtReader::varying_alpha(const PbrtParams& params) {
  const auto name = params.texture("alpha");
  if (!name) return nullptr;
  TextureEntry& entry = find_texture(params, "alpha", *name, float_textures_);
  return std::holds_alternative<Rgb>(entry.value) ? nullptr : &entry;
}

// The share of rays that the shape stops, as far as that is the same all over. None: nothing of it is to be seen.
std::optional<float> PbrtReader::constant_opacity(const PbrtParams& params) {
  const MaterialEntry& entry = materials_[attributes_.material];
  if (entry.invisible && attributes_.glow && !open_definition_) {
    if (version3_) return 0.0f;
    warn(params.where(), params.owner() + ": a light without a material does not shine, as in pbrt-v4");
  }
  if (entry.invisible) return std::nullopt;
  float alpha = varying_alpha(params) ? 1 : number(params, "alpha", 1, 0, 1);
  if (version3_ && alpha > 0) alpha = 1;  // there only 0 lets light through
  const auto name = params.texture("alpha"), of_shadow = params.texture("shadowalpha");
  if (params.has("shadowalpha") && (of_shadow ? name != of_shadow : name || params.number("shadowalpha", 1, 0, 1) != alpha))
    approximate(params.where("shadowalpha"), "'shadowalpha' that is not 'alpha' is not supported",
                "'alpha': shadows are those of what is seen");
  const float opacity = alpha * entry.constant_opacity;
  if (opacity == 0 && (!attributes_.glow || open_definition_)) return std::nullopt;
  if (opacity == 1 || !attributes_.glow || open_definition_) return opacity;
  approximate(params.where(), "a light that is half transparent, or shines and is not seen, is not supported", "an opaque one");
  return 1.0f;
}

std::uint32_t PbrtReader::constant_mask(float opacity) {
  if (opacity >= 1) return no_id;
  const auto [entry, is_new] = constant_masks_.try_emplace(opacity);
  if (is_new) entry->second = add_texture(ImageTexture{.size = {1, 1}, .texels = {Rgb(opacity)}});
  return entry->second;
}

std::uint32_t PbrtReader::add_mask(const PbrtParams& params, TriangleMesh& mesh, float constant) {
  const MaterialEntry& entry = materials_[attributes_.material];
  TextureEntry* const alpha = varying_alpha(params);
  if (constant == 0 || (!alpha && !entry.opacity)) return constant_mask(constant);
  const auto by_place = [](const Field& field) { return field && field->uses_position; };
  const auto* const alpha_field = alpha ? std::get_if<Field>(&alpha->value) : nullptr;
  const bool glows = attributes_.glow && !open_definition_;
  const bool cuts = glows || by_place(entry.opacity) || by_place(entry.field) || by_place(entry.relief.field) ||
                    (alpha_field && by_place(*alpha_field));
  if (!cuts) give_default_uvs(mesh);
  if (alpha && !alpha_field && !entry.opacity && constant == 1 && !cuts) {  // the texture as it is
    if (alpha->mask) return *alpha->mask;
    const Texture& texture = texture_to_copy(*alpha);
    alpha->mask = add_texture(version3_ ? std::visit(Opaque{}, texture) : texture);
    return *alpha->mask;
  }
  const Field opacity = opacity_field(params, alpha);
  if (!cuts) return baked_over_uv(opacity, Baked::reflectance, mesh, params);
  approximate(params.where(), "an opacity that varies, on a light or with a texture by the place, is not supported",
              "a hole where it is below a half, with edges to a fraction of a triangle");
  cut_away(mesh, opacity_of(opacity));
  return no_id;
}

// Joins the shape's alpha and its material's opacity, of which one at least varies.
Field PbrtReader::opacity_field(const PbrtParams& params, TextureEntry* alpha) {
  const MaterialEntry& entry = materials_[attributes_.material];
  if (!alpha) return entry.opacity;
  if (!alpha->alpha) {
    alpha->alpha = field_of(*alpha);
    if (version3_) alpha->alpha = mapped_field(alpha->alpha, [](const Rgb& value) { return Rgb(mean_component(value) != 0); });
  }
  const Field of_material = entry.opacity ? entry.opacity : constant_field(Rgb(entry.constant_opacity));
  if (!entry.opacity && entry.constant_opacity == 1) return alpha->alpha;
  return combined_field(params, {alpha->alpha, of_material},
                        [](const TexturePlace& place, std::span<const Field> f) { return f[0]->at(place) * f[1]->at(place); });
}

}  // namespace etendue
