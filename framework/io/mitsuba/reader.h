// The state of reading a Mitsuba scene. Internal to framework/io/mitsuba/*.cpp, which split it by concept: reader (the scene's
// children, references, messages), sensor (camera, film, integrator), clipping, shapes, obj_shapes, bsdfs, adapters (bsdfs of
// others), coated (bsdfs of several lobes), textures, emitters, colours.
#pragma once

#include "framework/io/mesh/left_out.h"
#include "framework/io/mesh/obj.h"
#include "framework/io/mitsuba/mitsuba.h"
#include "framework/io/mitsuba/properties.h"
#include "framework/io/object_builder.h"

#include <fmt/format.h>

#include <deque>
#include <map>

namespace etendue {

class MitsubaReader {
 public:
  MitsubaReader(std::string text, const std::string& path, const SceneReading& reading)
      : files_(path, reading), tree_(std::move(text), path, files_), ids_(tree_.root()) {}
  Scene read();

  // A type of an object: what is made of it, for docs/scene-files.md, and who makes it.
  template <class Handler>
  struct Type {
    std::string_view name, how;
    Handler handler;
  };
  struct MaterialEntry {
    Material material = Diffuse{Rgb(0.5f)};
    bool textured = false;
    bool two_sided = false;             // looks the same from both sides, as all opaque materials do here
    bool invisible = false;             // no surface at all
    std::uint32_t mask = no_id;         // as of Shape
    std::optional<Relief> relief = {};  // of its shading normals
    std::optional<std::uint32_t> scene_index = {};
  };
  using TextureValue = std::variant<Rgb, Texture>;
  // Shapes of the world or of a shapegroup; a quadric that a transform distorts is an object of its own under that transform.
  struct Part {
    ObjectBuilder builder;
    Transform to_group;
    std::optional<std::uint32_t> scene_index;
  };
  struct Group {
    std::vector<Part> parts{1};
    bool in_world = false;
  };
  using BsdfType = Type<MaterialEntry (MitsubaReader::*)(const Properties&)>;
  using TextureType = Type<TextureValue (MitsubaReader::*)(const Properties&)>;
  using EmitterType = Type<void (MitsubaReader::*)(const Properties&)>;
  using ShapeType = Type<void (MitsubaReader::*)(const Properties&, Group&)>;
  using SensorType = Type<void (MitsubaReader::*)(const Properties&)>;
  static std::span<const BsdfType> bsdf_types();
  static std::span<const TextureType> texture_types();
  static std::span<const EmitterType> emitter_types();
  static std::span<const ShapeType> shape_types();
  static std::span<const SensorType> sensor_types();

 private:
  static constexpr float degrees = pi / 180;
  // A factor is a value of a texture, which may be that of a surface or a light.
  enum class ColourUse : std::uint8_t { reflectance, factor, light, index };

  // reader.cpp
  void read_version();
  void find_camera();
  void read_child(const XmlElement& child);
  void finish();
  void warn(const Location& where, const std::string& what) { files_.warn(where, what); }
  // `what` cannot be represented, `taken` stands for it. Throws Error unless approximations are asked for.
  void approximate(const Location& where, const std::string& what, const std::string& taken);
  void leave_out_media(const Properties& of);
  void tell_of_transforms(const XmlElement& element, float until);  // the latest time that is seen
  Properties properties(const XmlElement& element) const { return {element, ids_, version0() ? &tell_ : nullptr}; }
  // Marks properties that change nothing here, as in Mitsuba, and tells of those that are given.
  void have_no_effect(const Properties& of, std::initializer_list<std::string_view> names, std::string_view why);
  SceneFiles::File read_file_of(const Properties& of);
  RgbImage read_image_of(const Properties& of, Encoding encoding);
  // `gamma`: the exponent by which integers encode colours; -1: as sRGB; 0: as the file says.
  RgbImage read_coloured_image(const Properties& of, float gamma);
  static float read_gamma(const Properties& of);
  static std::string file_name(const Properties& of);
  bool version0() const { return version_ < 2; }
  template <class Handler>
  const Type<Handler>& find_type(std::span<const Type<Handler>> types, const Properties& of) const {
    if (of.type().empty()) throw Error(of.where(), of.element().tag + ": 'type' is missing");
    std::vector<std::string> names;
    for (const auto& type : types) {
      if (type.name == of.type()) return type;
      names.emplace_back(type.name);
    }
    throw Error(of.element().where("type"), unknown_name(of.element().tag, of.type(), names));
  }

  // sensor.cpp
  void sensor(const XmlElement& element);
  void read_sensor(const XmlElement& element);
  FilterShape filter_of(const Properties& of) const;
  void perspective(const Properties& of);
  void thin_lens(const Properties& of);
  void orthographic(const Properties& of);
  void other_sensor(const Properties& of);
  void default_sensor(const Location& whole);       // once all shapes are placed
  float field_of_view(const Properties& of) const;  // radians, across the shorter side
  void place_camera(const Properties& of);
  void film(const Properties& of);
  void crop(const Properties& of);
  void integrator(const XmlElement& element);
  void check_hidden_emitters(bool has_area_lights);
  void only_integrator(const XmlElement& element, bool& has_one);

  // clipping.cpp
  void keep_clipping(const Properties& of);  // of the sensor that was read last
  void warn_of_clipping();

  // obj_shapes.cpp
  void obj_mesh(const Properties& of, Group& group);
  void obj_parts(const Properties& of, Group& group, bool loads_materials);
  void take_obj_part(const Properties& of, std::string_view text, std::vector<ObjPart>& parts);
  void forget_names_of_no_part(const Properties& of, std::span<const ObjPart> parts,
                               std::vector<std::pair<std::string, const XmlElement*>>& bsdfs);

  // shapes.cpp
  void shape(const XmlElement& element, Group& group);
  void finish_file_mesh(const Properties& of, bool flip_v, TriangleMesh& mesh);
  void ply_mesh(const Properties& of, Group& group);
  void serialized_mesh(const Properties& of, Group& group);
  void file_mesh(const Properties& of, Group& group, bool flip_v, TriangleMesh (*parse)(const SceneFiles::File&, int),
                 int index);
  void rectangle(const Properties& of, Group& group);
  void cube(const Properties& of, Group& group);
  void sphere(const Properties& of, Group& group);
  void disk(const Properties& of, Group& group);
  void cylinder(const Properties& of, Group& group);
  void shape_group(const Properties& of, Group& group);
  void instance(const Properties& of, Group& group);
  void merge(const Properties& of, Group& group);
  void other_shape(const Properties& of, Group& group);
  std::optional<ShapeLook> look(const Properties& of, const Group& group, MaterialEntry& entry, bool has_uvs);
  void place(TriangleMesh mesh, const Properties& of, Group& group, const std::string& name, bool outward);
  void place(TriangleMesh mesh, const Transform& to_group, ShapeLook seen, const Properties& of, Group& group,
             const std::string& name, bool outward);
  void place(const Quadric& quadric, const Transform& to_group, const Properties& of, Group& group);
  void instantiate(Group& group, const Transform& to_world);
  std::optional<ShapeLook::Glow> area_emitter(const Properties& of, bool has_uvs);

  // bsdfs.cpp
  std::uint32_t material_of(const Properties& shape);
  std::uint32_t default_material(const Properties& shape);
  std::uint32_t bsdf(const XmlElement& element);
  MaterialEntry& nested_bsdf(const Properties& of, std::size_t most = 1);
  std::uint32_t scene_material(MaterialEntry& entry);
  MaterialEntry diffuse(const Properties& of);
  MaterialEntry rough_diffuse(const Properties& of);
  MaterialEntry dielectric(const Properties& of);
  MaterialEntry thin_dielectric(const Properties& of);
  MaterialEntry conductor(const Properties& of);
  float refractive_index(const Properties& of, std::string_view name, const std::string& otherwise);
  float relative_index(const Properties& of, const std::string& inside);
  void index_of_metal(const Properties& of, Conductor& metal);
  void named_metal(const Properties& of, float outside, Conductor& metal);
  struct Roughness {
    vec2 alpha{0};
    NormalDistribution distribution = NormalDistribution::ggx;
  };
  Roughness roughness(const Properties& of, bool rough, float otherwise);
  Roughness isotropic_roughness(const Properties& of, bool rough, float otherwise);  // both alphas the same

  // adapters.cpp
  MaterialEntry two_sided(const Properties& of);
  MaterialEntry null_bsdf(const Properties& of);
  MaterialEntry mask(const Properties& of);
  MaterialEntry bump(const Properties& of);
  void read_relief(const XmlElement& element, Relief::Kind kind, float scale, MaterialEntry& entry);
  MaterialEntry coating(const Properties& of);
  MaterialEntry blend(const Properties& of);
  MaterialEntry mixture(const Properties& of);
  // Mixes two that can be; `share` is that of the second.
  static std::optional<MaterialEntry> mixed_entry(const MaterialEntry& a, const MaterialEntry& b, float share);

  // coated.cpp
  MaterialEntry plastic(const Properties& of);
  MaterialEntry phong(const Properties& of);
  MaterialEntry ward(const Properties& of);
  MaterialEntry principled(const Properties& of);
  MaterialEntry polarizer(const Properties& of);
  MaterialEntry diffuse_transmitter(const Properties& of);
  MaterialEntry other_bsdf(const Properties& of);
  MaterialEntry diffuse_and_lobe(const Properties& of, float alpha);

  // textures.cpp
  TextureValue texture(const XmlElement& element);
  TextureValue bitmap(const Properties& of);
  TextureValue image_texture(const Properties& of, RgbImage image);
  TextureValue opacity(const XmlElement& element);
  void set_mask(const Properties& of, const TextureValue& opacity, MaterialEntry& entry);
  std::uint32_t add_texture(Texture texture);
  std::uint32_t image_of_light(Texture image, Rgb& radiance);
  TextureValue checkerboard(const Properties& of);
  TextureValue scaled(const Properties& of);
  TextureValue other_texture(const Properties& of);
  TexturedRgb reflectance(const Properties& of, std::string_view name, const Rgb& otherwise, bool& textured,
                          float internal_reflectance = 0);
  Rgb colour(const Properties& of, std::string_view name, const Rgb& otherwise, ColourUse use);  // a texture's mean, if asked
  float number(const Properties& of, std::string_view name, float otherwise, float low, float high);
  struct UvMap {
    vec2 scale{1}, offset{0};
  };
  UvMap uv_map(const Properties& of);

  // colours.cpp
  static bool is_colour(const XmlElement& element);
  // The factor by which a reflectance that goes up to `most` is to be multiplied before it is clamped to 1. Warns of what is
  // above 1.
  float limit_of_reflectance(const Location& where, std::string_view what, float most);
  Rgb read_colour(const XmlElement& element, ColourUse use);
  Rgb read_spectrum(const XmlElement& element, ColourUse use);
  Rgb spectrum_object(const XmlElement& element, ColourUse use);

  // emitters.cpp
  void emitter(const XmlElement& element);
  void point(const Properties& of);
  void spot(const Properties& of);
  void directional(const Properties& of);
  void constant(const Properties& of);
  void environment(const Properties& of);
  void sky(const Properties& of);
  void left_out_emitter(const Properties& of);
  void leave_out_emitter(const Properties& of, std::string_view why);
  float scale_of(const Properties& of);
  void add_light(const Properties& of, Light light, const Rgb& emitted);
  Rgb emitted(const Properties& of, std::string_view name);
  vec3 placed_point(const Properties& of, const Transform& t, const vec3& p) const;

  const Properties::Tell tell_ = [this](const Location& where, const std::string& what) { warn(where, what); };
  SceneFiles files_;
  XmlTree tree_;
  XmlIds ids_;
  int version_ = 3;
  Scene scene_;
  const XmlElement* camera_ = nullptr;  // of several sensors
  bool has_integrator_ = false;
  struct HiddenEmitters {
    Location where;
    std::string integrator;
  };
  std::optional<HiddenEmitters> hides_emitters_;
  struct Clipping {
    std::string sensor;  // in words
    Location where_near, where_far;
    Camera camera;
    ivec2 resolution;
    float near, far;  // metres of depth between which Mitsuba's camera sees
  };
  std::vector<Clipping> clippings_;
  LeftOutTriangles left_out_;
  Group world_{.parts = std::vector<Part>(1), .in_world = true};
  std::map<const XmlElement*, Group> groups_;
  // How many objects are being read, each for the one before it: a chain of references must end.
  class Nesting {
   public:
    Nesting(MitsubaReader& reader, const XmlElement& element) : depth_(reader.depth_) {
      reader.visit(element);
      if (++depth_ > most_nested) {
        --depth_;
        throw Error(element.where(), fmt::format("{}: references lead on more than {} objects deep", element.tag, most_nested));
      }
    }
    ~Nesting() { --depth_; }
    Nesting(const Nesting&) = delete;
    Nesting& operator=(const Nesting&) = delete;

   private:
    static constexpr int most_nested = 64;
    int& depth_;
  };
  int depth_ = 0;
  // Objects that refer to one another several times would be read without end.
  void visit(const XmlElement& element) {
    if (++visited_ > most_visited)
      throw Error(element.where(),
                  fmt::format("{}: with all references followed there are more than {} objects", element.tag, most_visited));
  }
  static constexpr std::uint64_t most_visited = 1'000'000;
  std::uint64_t visited_ = 0;
  // An object that is being read has an entry without a value, since references must not lead back to it.
  std::map<const XmlElement*, std::optional<std::uint32_t>> bsdfs_;
  bool conserves_energy_ = true;  // of the bsdf that is being read: ensureEnergyConservation, before version 2
  std::map<const XmlElement*, std::optional<TextureValue>> textures_;
  std::map<std::pair<const XmlElement*, float>, std::uint32_t> scene_textures_;
  std::deque<MaterialEntry> materials_;
  std::uint32_t mask_of_nothing_ = no_id;  // of lights that are no surface; once there is one
  std::uint64_t one_sided_ = 0;            // shapes of a material that is black from behind in Mitsuba
  std::optional<Location> first_one_sided_;
};

}  // namespace etendue
