// The state of reading a pbrt scene, and its directives. Internal to framework/io/pbrt/*.cpp, which split it by concept:
// reader (files, attributes, transforms), options (camera, film), rendering (what the command line decides), shapes, materials,
// textures, lights.
#pragma once

#include "framework/io/mesh/left_out.h"
#include "framework/io/object_builder.h"
#include "framework/io/pbrt/params.h"
#include "framework/io/pbrt/support.h"
#include "framework/io/pbrt/texture_bake.h"
#include "framework/io/pbrt/texture_field.h"
#include "framework/io/scene_files.h"
#include "framework/scene/scene.h"

#include <atomic>
#include <map>
#include <memory>

namespace etendue {

// The reflectance of a dielectric's surface seen straight on, and the index that has it.
inline float normal_reflectance(float eta) { return square((eta - 1) / (eta + 1)); }
inline float index_of_reflectance(float reflectance) {
  if (reflectance <= 1e-6f) return 1;
  const float root = std::sqrt(std::min(reflectance, 0.9f));
  return (1 + root) / (1 - root);
}

// W/(m^2 sr), W/sr or W/m^2, of a channel: its square, too, has room in single precision, and so has the power of a light.
inline constexpr float brightest = 1e12f;

struct PbrtQuadric;

class PbrtReader {
 public:
  PbrtReader(const std::string& path, const SceneReading& reading) : files_(path, reading, true) {
    scene_.resolution = default_resolution;
  }
  Scene read(std::string text);

 private:
  static constexpr ivec2 default_resolution{1280, 720};  // of versions 3 and 4
  using Handler = void (PbrtReader::*)(PbrtLexer&, const Token&);
  enum class Phase : std::uint8_t { options, world, any };
  struct Directive {
    std::string_view name;
    Phase phase;
    Handler handler;
  };
  static std::span<const Directive> directives();
  static const Directive* find_directive(std::string_view name);
  [[noreturn]] static void fail_unknown_directive(const PbrtLexer& lexer, const Token& token);

  // Says why nothing can be placed by a transform.
  struct Singular {
    Location where;
    std::string why;
  };
  struct Placement {
    Transform transform;
    std::optional<Singular> singular;
  };
  // The state that AttributeBegin saves.
  struct Attributes {
    Placement ctm;
    bool end_only = false;  // transforms are those of the end of motion, which nobody sees here
    std::map<std::string, PbrtDefaults, std::less<>> defaults;  // of Attribute, by what they are for
    bool reverse_orientation = false;
    std::uint32_t material = 0;  // index into materials_
    std::optional<ShapeLook::Glow> glow;
    bool glows_by_power = false;  // the glow's radiance is then the power of each of pbrt's shapes
  };
  enum class Block : std::uint8_t { attribute, transform, object };
  struct Saved {
    Block block;
    Attributes attributes;
    Location where;
    std::size_t forgets = 0;  // of forget_, before it
  };

  // Heights or normals: a texture of the scene, or a field that is to be baked for each shape.
  struct ReliefSource {
    Relief::Kind kind = Relief::Kind::heights;
    std::uint32_t texture = no_id;
    Field field = nullptr;

    explicit operator bool() const { return texture != no_id || field; }  // false: no relief
  };
  struct MaterialEntry {
    Material material;
    bool textured = false;
    Field field = nullptr;                     // its reflectance, where that is to be baked for each shape
    Field opacity = nullptr;                   // the share of rays that it stops, where that varies,
    float constant_opacity = 1;                // or does not
    ReliefSource relief = {};                  // of its shading normals
    bool invisible = false;                    // the boundary of a medium
    std::optional<std::uint32_t> scene_index;  // once a shape uses it
  };
  struct TextureEntry {
    std::variant<Rgb, Texture, Field> value;
    std::string file = {};                          // of an image, as messages name it
    std::optional<std::uint32_t> scene_index = {};  // once a surface uses it
    bool moved = false;                             // the value then lies in the scene
    std::optional<std::uint32_t> relief = {};       // in the scene, as heights
    std::optional<std::uint32_t> mask = {};         // in the scene, as a shape's alpha
    Field alpha = nullptr;                          // the field that is baked as such
    Field reflectance = nullptr;                    // likewise, which notes whether it reaches beyond 1
  };
  using TextureMap = std::map<std::string, TextureEntry, std::less<>>;

  // An object is its own geometry and, for each quadric that a transform distorts, the plain quadric under that transform.
  struct PlacedObject {
    ObjectBuilder builder;
    Transform to_parent;
    std::optional<std::uint32_t> scene_index;
  };
  struct Definition {
    std::vector<PlacedObject> parts{1};
  };

  struct CameraEntry {
    Location where;
    std::optional<float> frame_aspect;
    std::vector<float> screen_window;
    std::optional<float> open_time;  // of the shutter, where stated
    enum class Kind : std::uint8_t { perspective, orthographic, spherical } kind = Kind::perspective;
  };

  // reader.cpp
  void parse(PbrtLexer& lexer);
  void finish();
  void check_phase(const Directive& directive, const Location& where) const;
  void attribute(PbrtLexer& lexer, const Token& token);
  void named_medium(PbrtLexer& lexer, const Token& token);
  void medium_interface(PbrtLexer& lexer, const Token& token);
  void expose(std::vector<Emission>& emissions);
  void include(PbrtLexer& lexer, const Token& token);
  void import(PbrtLexer& lexer, const Token& token);
  void world_begin(PbrtLexer& lexer, const Token& token);
  void world_end(PbrtLexer& lexer, const Token& token);
  void attribute_begin(PbrtLexer& lexer, const Token& token);
  void attribute_end(PbrtLexer& lexer, const Token& token);
  void transform_begin(PbrtLexer& lexer, const Token& token);
  void transform_end(PbrtLexer& lexer, const Token& token);
  void reverse_orientation(PbrtLexer& lexer, const Token& token);
  // Version 3 forgets at a block's end what the block named: a name then means again what it meant before.
  template <class Names, class Value>
  void define(Names& names, const std::string& name, Value value, const Location& where, const std::string& what) {
    const bool in_block =
        version3_ && std::ranges::any_of(stack_, [](const auto& outer) { return outer.block != Block::transform; });
    if (names.contains(name))
      warn(where, what + " is defined twice; the last one counts" + (in_block ? ", to the end of its block" : ""));
    if (in_block)
      forget_.push_back([&names, name, before = std::make_shared<typename Names::node_type>(names.extract(name))] {
        names.erase(name);
        if (*before) names.insert(std::move(*before));
      });
    names.insert_or_assign(name, std::move(value));
  }
  void push(Block block, const Location& where);
  Attributes pop(Block block, std::string_view name, const Location& where);

  // transforms.cpp
  void identity(PbrtLexer& lexer, const Token& token);
  void translate(PbrtLexer& lexer, const Token& token);
  void scale(PbrtLexer& lexer, const Token& token);
  void rotate(PbrtLexer& lexer, const Token& token);
  void look_at(PbrtLexer& lexer, const Token& token);
  void transform(PbrtLexer& lexer, const Token& token);
  void concat_transform(PbrtLexer& lexer, const Token& token);
  void coordinate_system(PbrtLexer& lexer, const Token& token);
  void coord_sys_transform(PbrtLexer& lexer, const Token& token);
  void active_transform(PbrtLexer& lexer, const Token& token);
  void transform_times(PbrtLexer& lexer, const Token& token);
  std::optional<Transform> read_matrix(PbrtLexer& lexer, const Token& token) const;
  // Each changes what later things are placed by, unless that is the end of a motion.
  void set_ctm(const Transform& transform, const Location& where);
  void compose(const std::optional<Transform>& inner, const Location& where, const std::string& why_not);
  void replace(const Placement& placement);
  // Throws Error, at the transform, where it has no inverse.
  const Transform& ctm() const;

  // options.cpp
  void camera(PbrtLexer& lexer, const Token& token);
  void film(PbrtLexer& lexer, const Token& token);
  void color_space(PbrtLexer& lexer, const Token& token);
  void option(PbrtLexer& lexer, const Token& token);
  void untyped_option(PbrtLexer& lexer);
  void set_option(std::string_view name, const Location& where);
  void check_camera();
  void take_open_time(float seconds);
  void unscale_camera();
  void check_window(float aspect);
  void make_parallel(const vec2& middle, float half_width);
  void read_exposure(const PbrtParams& params);
  void read_crop(const PbrtParams& params);

  // rendering.cpp
  void integrator(PbrtLexer& lexer, const Token& token);
  void sampler(PbrtLexer& lexer, const Token& token);
  void accelerator(PbrtLexer& lexer, const Token& token);
  void pixel_filter(PbrtLexer& lexer, const Token& token);
  FilterShape filter_of_version() const;
  void accept_known(PbrtLexer& lexer, const Token& token, std::string_view kind);
  void warn_of_part(const Location& where, const std::string& type);
  void limit_to_direct_light();

  // shapes.cpp
  void shape(PbrtLexer& lexer, const Token& token);
  void object_begin(PbrtLexer& lexer, const Token& token);
  void object_end(PbrtLexer& lexer, const Token& token);
  void object_instance(PbrtLexer& lexer, const Token& token);
  void take_no_material_from(const PbrtParams& params);
  void quadric(const PbrtQuadric& quadric, const PbrtParams& params);
  template <class Value>
  void keep_as_many(const PbrtParams& params, std::string_view name, std::size_t points, bool may_exceed,
                    std::vector<Value>& values);
  TriangleMesh triangle_mesh(const PbrtParams& params);
  void mesh_file(PbrtLexer& lexer, const PbrtParams& params);
  void subdivided_mesh(const PbrtParams& params);
  void curve(const PbrtParams& params);
  void bilinear_mesh(const PbrtParams& params);
  void height_field(const PbrtParams& params);
  void nurbs(const PbrtParams& params);
  std::optional<float> constant_opacity(const PbrtParams& params);
  // Adds the mask of an alpha that varies. Both may change the mesh: holes are cut into it where rays cannot be asked, and it
  // gets coordinates.
  std::uint32_t add_mask(const PbrtParams& params, TriangleMesh& mesh, float constant);
  Field opacity_field(const PbrtParams& params, TextureEntry* alpha);
  TextureEntry* varying_alpha(const PbrtParams& params);
  std::uint32_t constant_mask(float opacity);
  // `shapes`: how many pbrt makes of it; 0: one for each triangle.
  void place(TriangleMesh mesh, const PbrtParams& params, const std::string& name, std::size_t shapes = 0);
  bool keeps_side_of_normals(const TriangleMesh& mesh, const PbrtParams& params, bool is_triangles);
  void place(const Quadric& quadric, const SurfacePatch& patch, const PbrtParams& params);
  // `patch`: where the surface is at (u, v), in the shape's own space; empty of meshes.
  void place_patch(const SurfacePatch& patch, const PbrtParams& params);
  bool glows_by_image() const;
  ShapeLook look(const PbrtParams& params, bool flip_normal, std::uint32_t material, std::uint32_t mask);
  bool needs_uvs(const PbrtParams& params);
  void give_uvs_of_quads(TriangleMesh& mesh) const;
  void spread_power(ShapeLook& look, double area, std::size_t shapes) const;
  void spread_power(ShapeLook& look, const TriangleMesh& mesh, const PbrtParams& params, std::size_t shapes);
  void instantiate(Definition& definition, const Transform& to_world);

  // baked_materials.cpp
  std::uint32_t material_on(TriangleMesh& mesh, const PbrtParams& params);
  std::uint32_t baked_over_uv(const Field& field, Baked values, const TriangleMesh& mesh, const PbrtParams& params);
  std::uint32_t material_in_atlas(const MaterialEntry& entry, TriangleMesh& mesh, const PbrtParams& params);
  void tell_of_lost_detail(const Field& field, const PbrtParams& params, const std::string& spacing);

  // materials.cpp
  void material(PbrtLexer& lexer, const Token& token);
  void make_named_material(PbrtLexer& lexer, const Token& token);
  void named_material(PbrtLexer& lexer, const Token& token);
  MaterialEntry make_material(const std::string& type, const PbrtParams& params);
  Material make_diffuse(const PbrtParams& params, std::string_view name, MaterialEntry& entry);
  Material make_conductor(const PbrtParams& params, bool version3);
  Material make_mirror(const PbrtParams& params);
  Material make_glass(const PbrtParams& params);
  Material make_dielectric(const PbrtParams& params);
  Material make_plastic(const PbrtParams& params, MaterialEntry& entry);
  Material make_coated_diffuse(const PbrtParams& params, MaterialEntry& entry);
  // Which parameters a material of version 3 knows: "roughness", "uroughness" with "vroughness", or all three.
  enum class RoughnessBy : std::uint8_t { any, axis, one };
  vec2 roughness_alpha(const PbrtParams& params, float otherwise, bool version3, RoughnessBy by = RoughnessBy::any);
  float isotropic_alpha(const PbrtParams& params, float otherwise, bool version3, RoughnessBy by = RoughnessBy::any);
  float refractive_index(const PbrtParams& params, float least, float otherwise = 1.5f, std::string_view param = "eta");

  // nearest_materials.cpp: what has no exact equal
  using ColourMap = std::function<Rgb(const Rgb&)>;
  void make_nearest(const std::string& type, const PbrtParams& params, MaterialEntry& entry);
  // A diffuse base as bright as `base` under a coat of the index `eta`; bare where that is 1.
  Material make_coated(const PbrtParams& params, std::string_view base, const Rgb& otherwise, float eta, float alpha,
                       MaterialEntry& entry);
  float specular_strength(const PbrtParams& params, std::string_view name, float otherwise);
  Material make_uber(const PbrtParams& params, MaterialEntry& entry);
  Material make_substrate(const PbrtParams& params, MaterialEntry& entry);
  Material make_disney(const PbrtParams& params, MaterialEntry& entry);
  Material make_transmitting(const PbrtParams& params, bool version3, MaterialEntry& entry);
  void tell_of_excess(const PbrtParams& params, std::string_view name);
  TexturedRgb textured_part(const PbrtParams& params, std::string_view name, const Rgb& otherwise, MaterialEntry& entry,
                            const ColourMap& map);
  float most_of(const TexturedRgb& colour) const;
  Material make_coated_conductor(const PbrtParams& params);
  Material make_subsurface(const PbrtParams& params, bool by_colour, MaterialEntry& entry);
  Material make_hair(const PbrtParams& params, MaterialEntry& entry);
  MaterialEntry make_mix(const PbrtParams& params);
  const MaterialEntry& named_entry(const PbrtParams& params, std::string_view param, const std::string& name) const;
  static bool is_plain_surface(const MaterialEntry& entry);  // opaque and smooth, its colours constant or images
  std::optional<Field> diffuse_field(const MaterialEntry& entry) const;
  std::uint32_t scene_material(std::uint32_t entry);
  std::uint32_t add_material(const Material& material, const std::optional<Relief>& relief);
  void read_relief(const PbrtParams& params, MaterialEntry& entry);

  // textures.cpp
  void texture(PbrtLexer& lexer, const Token& token);
  TextureEntry make_texture(PbrtLexer& lexer, const std::string& type, const PbrtParams& params, TextureMap& textures);
  TextureEntry checker_texture(const PbrtParams& params, TextureMap& textures);
  TextureEntry scaled_texture(const PbrtParams& params, TextureMap& textures);
  TextureEntry mixed_texture(const PbrtParams& params, TextureMap& textures);
  Field field_of(const TextureEntry& entry);
  // The texture of an entry that is one, to be copied: there must be room for it.
  const Texture& texture_to_copy(const TextureEntry& entry);
  Field field_operand(const PbrtParams& params, std::string_view name, const Rgb& otherwise, TextureMap& textures);
  Rgb mean_operand(const PbrtParams& params, std::string_view name, const std::string& texture, TextureMap& textures);
  std::variant<Rgb, const TextureEntry*> operand(const PbrtParams& params, std::string_view name, const Rgb& otherwise,
                                                 TextureMap& textures);
  TextureEntry& find_texture(const PbrtParams& params, std::string_view param, const std::string& name, TextureMap& textures);
  // These read a material's numbers and colours, or a texture, which must be constant where only a constant will do.
  float number(const PbrtParams& params, std::string_view name, float otherwise, float low, float high);
  Rgb colour(const PbrtParams& params, std::string_view name, const Rgb& otherwise, ColourUse use);
  TexturedRgb textured_colour(const PbrtParams& params, std::string_view name, const Rgb& otherwise, MaterialEntry& entry,
                              const ColourMap& map = {});
  const Field& field_of_reflectance(TextureEntry& entry, const Location& where, const std::string& name);
  Texture take_reflectance(TextureEntry& entry, const Location& where, const std::string& name);
  std::uint32_t add_texture(Texture texture);

  // image_textures.cpp
  TextureEntry image_texture(PbrtLexer& lexer, const PbrtParams& params, bool of_numbers);
  void warn_of_texels(const RgbImage& image, const Location& where, const std::string& file, bool of_light = false);

  // lights.cpp
  PbrtParams light_params(PbrtLexer& lexer, const Token& token, const std::string& type);
  // Its colour times its scale. `photometric`: the parameter that states its power, or the illuminance, in version 4;
  // `power_of_unit`: what a light of colour 1 has of that.
  Rgb emitted(const PbrtParams& params, std::string_view name, std::string_view photometric, float power_of_unit = 1) const;
  void light_source(PbrtLexer& lexer, const Token& token);
  void area_light_source(PbrtLexer& lexer, const Token& token);
  RgbImage image_file_of_light(PbrtLexer& lexer, const PbrtParams& params, std::string_view param);
  std::uint32_t image_of_light(PbrtLexer& lexer, const PbrtParams& params, Rgb& radiance);
  Light point_light(const PbrtParams& params) const;
  Light spot_light(const PbrtParams& params);
  Light distant_light(const PbrtParams& params) const;
  Light infinite_light(PbrtLexer& lexer, const PbrtParams& params);
  Light goniometric_light(PbrtLexer& lexer, const PbrtParams& params);
  Light projection_light(PbrtLexer& lexer, const PbrtParams& params);
  struct MeanImage {
    Rgb colour{1};
    ivec2 size{1};
  };
  MeanImage mean_of_image(PbrtLexer& lexer, const PbrtParams& params, bool sphere);

  // Helpers of all of them.
  // Does the error name a place in the file of these parameters, of which it is then nearer?
  static bool has_place(const Error& e, const PbrtParams& params) {
    return std::string_view(e.what()).starts_with(params.where().file + ":");
  }
  // What follows the message that a name is unknown: version 4 allows its definition further down.
  std::string or_further_down() const {
    return version3_ ? "" : "; pbrt-v4 also finds what is defined further down, but here it must stand before its use";
  }
  std::string expect_string(PbrtLexer& lexer, const std::string& what) const;
  float expect_number(PbrtLexer& lexer, const std::string& what) const;
  void approximate(const Location& where, const std::string& what, const std::string& instead) {
    files_.approximations().take(where, what, instead);
  }
  void warn(const Location& where, const std::string& what) { files_.warn(where, what); }
  static std::string titled(std::string_view directive, const std::string& name) {
    return std::string(directive) + " \"" + name + "\"";
  }

  SceneFiles files_;
  Scene scene_;
  bool in_world_ = false, world_ended_ = false;
  int include_depth_ = 0;
  LeftOutTriangles left_out_;
  Attributes attributes_;
  std::vector<Saved> stack_;
  std::vector<std::function<void()>> forget_;
  struct CoordinateSystem {
    Placement ctm;
    int of_import = 0;  // the number of the import that names it
  };
  std::map<std::string, CoordinateSystem, std::less<>> coordinate_systems_;
  int import_ = 0, imports_ = 0;  // the number of the import that is being read, 0 of none, and how many there have been
  Rgb exposure_{1};               // by which the film scales the image
  bool version3_ = false;         // as its film tells, or without one its WorldEnd
  struct DirectOnly {
    Location where;
    std::string type;
  };
  std::optional<DirectOnly> direct_only_;   // where an integrator shows no other light
  std::optional<Location> of_pbrts_depth_;  // an integrator that states none
  bool has_integrator_ = false;
  std::optional<FilterShape> filter_;
  glm::bvec2 filter_by_version_{false};  // its radius is that of a Gaussian in the file's version, which the film tells
  std::optional<CameraEntry> camera_;
  std::map<float, std::uint32_t> constant_masks_;  // in the scene, by opacity
  std::vector<MaterialEntry> materials_{MaterialEntry{.material = Diffuse{Rgb(0.5f)}, .textured = false, .scene_index = {}}};
  std::map<std::string, std::uint32_t, std::less<>> named_materials_;
  TextureMap spectrum_textures_, float_textures_;
  struct OutOfRange {
    std::string text;
    std::shared_ptr<std::atomic<bool>> met;  // by what was baked
  };
  std::vector<OutOfRange> out_of_range_;
  struct LostDetail {
    Field field;
    std::string text;
    std::uint64_t more = 0;  // shapes
  };
  std::vector<LostDetail> lost_details_;
  BakeBudget bake_budget_;
  struct BakedField {
    Field field;
    Baked values;
    Bounds uv_range;
    std::uint32_t texture;
  };
  std::vector<BakedField> baked_;  // over ranges of (u, v), for other shapes that need the same
  Definition world_;
  std::map<std::string, Definition, std::less<>> definitions_;
  Definition* open_definition_ = nullptr;
};

}  // namespace etendue
