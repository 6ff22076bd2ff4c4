// Materials whose textures are baked for each shape: over its (u, v), or by the place of its surface.

#include "framework/io/pbrt/reader.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {

namespace {

TexturedRgb textured(std::uint32_t texture) {
  TexturedRgb colour;
  colour.texture = texture;
  return colour;
}

// The colour that a texture can give; null of materials that have none.
TexturedRgb* reflectance_of(Material& material) {
  if (auto* diffuse = std::get_if<Diffuse>(&material)) return &diffuse->reflectance;
  if (auto* plastic = std::get_if<Plastic>(&material)) return &plastic->reflectance;
  if (auto* sheet = std::get_if<DiffuseTransmission>(&material)) return &sheet->reflectance;
  return nullptr;
}

}  // namespace

// The first shape of each field names the place; others are counted.
void PbrtReader::tell_of_lost_detail(const Field& field, const PbrtParams& params, const std::string& spacing) {
  const auto told = std::ranges::find(lost_details_, field, &LostDetail::field);
  if (told != lost_details_.end()) {
    ++told->more;
    return;
  }
  lost_details_.push_back({field, fmt::format("{}: {}: a texture is finer than the texels that it is baked into, which are {} "
                                              "apart: what is finer becomes its mean",
                                              params.where().text(), params.owner(), spacing)});
}

// Over the mesh's range of (u, v); an image that another shape has already serves again.
std::uint32_t PbrtReader::baked_over_uv(const Field& field, Baked values, const TriangleMesh& mesh, const PbrtParams& params) {
  Bounds range;
  for (const vec2& uv : mesh.uvs) range.extend(vec3(uv, 0));
  for (const BakedField& baked : baked_)
    if (baked.field == field && baked.values == values && baked.uv_range.lower == range.lower &&
        baked.uv_range.upper == range.upper)
      return baked.texture;
  BakedImage image = bake_over_uv(*field, values, range, bake_budget_);
  if (image.loses_detail) tell_of_lost_detail(field, params, fmt::format("{:.3g} in (u, v)", image.spacing));
  baked_.push_back({field, values, range, add_texture(std::move(image.image))});
  return baked_.back().texture;
}

// Serves what depends on the place: the mesh gets other texture coordinates, over which all of it is baked.
std::uint32_t PbrtReader::material_in_atlas(const MaterialEntry& entry, TriangleMesh& mesh, const PbrtParams& params) {
  if (open_definition_)
    approximate(params.where(), "a texture that depends on the place, on an object of which there are instances",
                "the same on each, as the object is defined");
  Material material = entry.material;
  TexturedRgb* const reflectance = reflectance_of(material);
  if (auto* sheet = std::get_if<DiffuseTransmission>(&material); sheet && !sheet->transmittance.is_constant()) {
    approximate(params.where(), "a texture of what passes through, beside one by the place", "its mean");
    sheet->transmittance = within_unit(mean_of(texture_field(scene_.textures[sheet->transmittance.texture])));
  }
  std::vector<FieldToBake> fields;
  Field colour = entry.field;
  if (!colour && reflectance && !reflectance->is_constant()) colour = texture_field(scene_.textures[reflectance->texture]);
  if (colour) fields.push_back({colour, Baked::reflectance});
  const auto* const metal = std::get_if<Conductor>(&entry.material);
  if (entry.relief && (entry.relief.kind == Relief::Kind::normals || (metal && metal->is_anisotropic())))
    approximate(params.where(), "relief on a surface that has both a texture by its place and one along (u, v)",
                "the smooth surface");
  else if (entry.relief)
    fields.push_back(
        {entry.relief.field ? entry.relief.field : texture_field(scene_.textures[entry.relief.texture]), Baked::heights});
  if (fields.empty()) return add_material(material, {});
  std::vector<BakedImage> images = bake_atlas(fields, mesh, bake_budget_);
  for (std::size_t i = 0; i < images.size(); ++i)
    if (images[i].loses_detail) tell_of_lost_detail(fields[i].field, params, fmt::format("{:.3g} m", images[i].spacing));
  if (colour) *reflectance = textured(add_texture(std::move(images.front().image)));
  if (fields.back().values != Baked::heights) return add_material(material, {});
  return add_material(material, Relief{.kind = Relief::Kind::heights, .texture = add_texture(std::move(images.back().image))});
}

std::uint32_t PbrtReader::material_on(TriangleMesh& mesh, const PbrtParams& params) {
  const MaterialEntry& entry = materials_[attributes_.material];
  const auto by_place = [](const Field& field) { return field && field->uses_position; };
  if (by_place(entry.field) || by_place(entry.relief.field)) {
    if (!glows_by_image()) return material_in_atlas(entry, mesh, params);
    approximate(params.where(), "a texture by its place on a light that shows an image", "its mean, without relief");
    give_default_uvs(mesh);  // which the light's image has
    Material plain = entry.material;
    if (entry.field) *reflectance_of(plain) = within_unit(mean_of(entry.field));
    return add_material(plain, {});
  }
  if (entry.field || entry.relief || glows_by_image()) give_default_uvs(mesh);
  if (!entry.field && !entry.relief.field) return scene_material(attributes_.material);
  Material material = entry.material;
  if (entry.field) *reflectance_of(material) = textured(baked_over_uv(entry.field, Baked::reflectance, mesh, params));
  if (!entry.relief) return add_material(material, {});
  const Field& heights = entry.relief.field;
  return add_material(material,
                      Relief{.kind = entry.relief.kind,
                             .texture = heights ? baked_over_uv(heights, Baked::heights, mesh, params) : entry.relief.texture});
}

}  // namespace etendue
