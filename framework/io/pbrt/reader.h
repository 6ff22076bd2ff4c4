// The state of reading a pbrt scene, and its directives. Internal to framework/io/pbrt/*.cpp, which split it by concept:
// reader (files, attributes, transforms), options (camera, film), rendering (what the command line
// decides), shapes, materials, textures, lights.
#pragma once

#include "framework/io/mesh/left_out.h"
#include "framework/io/object_builder.h"
#include "framework/io/pbrt/params.h"
#include "framework/io/scene_files.h"
#include "framework/scene/scene.h"

#include <map>

namespace etendue {

class PbrtReader {
 public:
  PbrtReader(const std::string& path, const SceneReading& reading) : files_(path, reading) {}
  Scene read(std::string text);

 private:
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

  // What AttributeBegin saves.
  struct Attributes {
    Transform ctm;
    bool reverse_orientation = false;
    std::uint32_t material = 0;  // index into materials_
    std::optional<ShapeLook::Glow> glow;
  };
  enum class Block : std::uint8_t { attribute, transform, object };
  struct Saved {
    Block block;
    Attributes attributes;
    Location where;
  };

  struct MaterialEntry {
    Material material;
    bool textured = false;
    std::optional<std::uint32_t> scene_index;  // once a shape uses it
  };
  struct TextureEntry {
    std::variant<Rgb, Texture> value;
    std::string file = {};                          // of an image, as messages name it
    std::optional<std::uint32_t> scene_index = {};  // once a surface uses it
    bool moved = false;                             // the value then lies in the scene
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
  };

  // reader.cpp
  void parse(PbrtLexer& lexer);
  void finish();
  void check_phase(const Directive& directive, const Location& where) const;
  void unsupported(PbrtLexer& lexer, const Token& token);
  void include(PbrtLexer& lexer, const Token& token);
  void import(PbrtLexer& lexer, const Token& token);
  void world_begin(PbrtLexer& lexer, const Token& token);
  void world_end(PbrtLexer& lexer, const Token& token);
  void attribute_begin(PbrtLexer& lexer, const Token& token);
  void attribute_end(PbrtLexer& lexer, const Token& token);
  void transform_begin(PbrtLexer& lexer, const Token& token);
  void transform_end(PbrtLexer& lexer, const Token& token);
  void reverse_orientation(PbrtLexer& lexer, const Token& token);
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
  Transform read_matrix(PbrtLexer& lexer, const Token& token) const;
  void set_ctm(const Transform& transform, const Location& where);

  // options.cpp
  void camera(PbrtLexer& lexer, const Token& token);
  void film(PbrtLexer& lexer, const Token& token);
  void color_space(PbrtLexer& lexer, const Token& token);
  void option(PbrtLexer& lexer, const Token& token);
  void check_camera();

  // rendering.cpp
  void integrator(PbrtLexer& lexer, const Token& token);
  void sampler(PbrtLexer& lexer, const Token& token);
  void accelerator(PbrtLexer& lexer, const Token& token);
  void pixel_filter(PbrtLexer& lexer, const Token& token);
  void accept_known(PbrtLexer& lexer, const Token& token, std::string_view kind);

  // shapes.cpp
  void shape(PbrtLexer& lexer, const Token& token);
  void object_begin(PbrtLexer& lexer, const Token& token);
  void object_end(PbrtLexer& lexer, const Token& token);
  void object_instance(PbrtLexer& lexer, const Token& token);
  void triangle_mesh(PbrtLexer& lexer, const PbrtParams& params);
  void ply_mesh(PbrtLexer& lexer, const PbrtParams& params);
  void place(TriangleMesh mesh, const PbrtParams& params, const std::string& name);
  void place(const Quadric& quadric, const PbrtParams& params);
  ShapeLook look(const PbrtParams& params, bool flip_normal);
  void instantiate(Definition& definition, const Transform& to_world);

  // materials.cpp
  void material(PbrtLexer& lexer, const Token& token);
  void make_named_material(PbrtLexer& lexer, const Token& token);
  void named_material(PbrtLexer& lexer, const Token& token);
  MaterialEntry make_material(const std::string& type, const PbrtParams& params);
  Material make_diffuse(const PbrtParams& params, std::string_view name, bool& textured);
  Material make_conductor(const PbrtParams& params, bool version3);
  Material make_mirror(const PbrtParams& params);
  Material make_glass(const PbrtParams& params);
  Material make_dielectric(const PbrtParams& params);
  Material make_plastic(const PbrtParams& params, bool& textured);
  Material make_coated_diffuse(const PbrtParams& params, bool& textured);
  vec2 roughness_alpha(const PbrtParams& params, float otherwise, bool version3);
  float isotropic_alpha(const PbrtParams& params, float otherwise, bool version3);
  float refractive_index(const PbrtParams& params);
  std::uint32_t scene_material(std::uint32_t entry);

  // textures.cpp
  void texture(PbrtLexer& lexer, const Token& token);
  TextureEntry make_texture(PbrtLexer& lexer, const std::string& type, const PbrtParams& params, TextureMap& textures);
  TextureEntry image_texture(PbrtLexer& lexer, const PbrtParams& params);
  Texture checker_texture(const PbrtParams& params, TextureMap& textures);
  TextureEntry scaled_texture(const PbrtParams& params, TextureMap& textures);
  Rgb mixed_texture(const PbrtParams& params, TextureMap& textures);
  std::variant<Rgb, const TextureEntry*> operand(const PbrtParams& params, std::string_view name, const Rgb& otherwise,
                                                 TextureMap& textures);
  Rgb constant_operand(const PbrtParams& params, std::string_view name, const Rgb& otherwise, TextureMap& textures);
  TextureEntry& find_texture(const PbrtParams& params, std::string_view param, const std::string& name, TextureMap& textures);
  // These read a material's numbers and colours, or a texture, which must be constant where only a constant will do.
  float number(const PbrtParams& params, std::string_view name, float otherwise, float low, float high);
  Rgb colour(const PbrtParams& params, std::string_view name, const Rgb& otherwise, ColourUse use);
  TexturedRgb textured_colour(const PbrtParams& params, std::string_view name, const Rgb& otherwise, bool& textured);
  Texture take_reflectance(TextureEntry& entry, const Location& where, const std::string& name);
  void warn_of_not_finite(const RgbImage& image, const Location& where, const std::string& file);

  // lights.cpp
  void light_source(PbrtLexer& lexer, const Token& token);
  void area_light_source(PbrtLexer& lexer, const Token& token);
  Light point_light(const PbrtParams& params) const;
  Light spot_light(const PbrtParams& params) const;
  Light distant_light(const PbrtParams& params) const;
  Light infinite_light(PbrtLexer& lexer, const PbrtParams& params);

  // Helpers of all of them.
  std::string expect_string(PbrtLexer& lexer, const std::string& what) const;
  float expect_number(PbrtLexer& lexer, const std::string& what) const;
  void warn(const Location& where, const std::string& what) { scene_.warnings.push_back(where.text() + ": " + what); }
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
  std::map<std::string, Transform, std::less<>> coordinate_systems_;
  std::optional<CameraEntry> camera_;
  std::vector<MaterialEntry> materials_{MaterialEntry{.material = Diffuse{Rgb(0.5f)}, .textured = false, .scene_index = {}}};
  std::map<std::string, std::uint32_t, std::less<>> named_materials_;
  TextureMap spectrum_textures_, float_textures_;
  Definition world_;
  std::map<std::string, Definition, std::less<>> definitions_;
  Definition* open_definition_ = nullptr;
};

}  // namespace etendue
