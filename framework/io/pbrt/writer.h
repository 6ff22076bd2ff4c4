// The state of writing a pbrt scene. Internal to framework/io/pbrt/writer*.cpp: writer (options, camera, instances),
// writer_shapes, writer_looks (materials, textures), writer_lights.
#pragma once

#include "framework/io/pbrt/write.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

namespace etendue {

class PbrtWriter {
 public:
  PbrtWriter(const Scene& scene, std::string folder, const TakeFile& take)
      : scene_(scene), folder_(std::move(folder)), take_(take) {}
  PbrtText write();

 private:
  // Says what a surface is made of, and whether it emits.
  struct Look {
    std::string material;
    bool flip_normal = false;
    const AreaLight* light = nullptr;  // null: does not emit
    std::uint32_t mask = no_id;        // as of Shape
  };

  // writer.cpp
  std::string filter_text() const;
  std::string camera_text();
  void add_instances();

  // writer_shapes.cpp
  void add_object(const Object& object, const vec3& origin);
  void add_mesh(const Object& object, const Shape& shape, const Look& look, const vec3& origin);
  void add_quadric(const Quadric& quadric, const Look& look, bool has_axes, const vec3& origin);
  void add_plane(const InfinitePlane& plane);
  void add_shape(const std::string& placement, const std::string& shape, const Look& look);
  Look look_of(const Object& object, const Shape& shape);

  // writer_looks.cpp
  std::string material_name(std::uint32_t material);  // defines it where it is not yet
  std::string colour_text(const char* name, const TexturedRgb& colour);
  std::string texture_name(std::uint32_t texture, const char* kind = "spectrum");
  std::string mask_text(std::uint32_t mask);
  std::string image_file(const char* kind, ivec2 size, const std::vector<Rgb>& texels, bool floats);
  std::string material_text(const Diffuse& diffuse);
  std::string material_text(const Conductor& conductor);
  std::string material_text(const Dielectric& dielectric);
  std::string material_text(const Plastic& plastic);
  std::string material_text(const DiffuseTransmission& sheet);
  std::string roughness_text(const vec2& alpha, NormalDistribution distribution);
  std::string wrap_text(const ImageTexture& image);
  float within(float value, float low, float high, const char* what);

  // writer_lights.cpp
  void add_light(const Light& light);
  std::string light_text(const PointLight& light);
  std::string light_text(const SpotLight& light);
  std::string light_text(const DirectionalLight& light);
  std::string light_text(const EnvironmentLight& light);

  // Each different warning once.
  void warn(const std::string& what);
  std::string file(const std::string& name, std::string_view bytes);  // returns its name as the text has it, in quotes
  std::string numbered(const char* kind) { return kind + ("-" + std::to_string(count_[kind]++)); }

  const Scene& scene_;
  std::string folder_;
  const TakeFile& take_;
  std::string looks_, shapes_;  // the text, in the order in which it stands there
  std::map<std::uint32_t, std::string> materials_, textures_;
  std::map<std::string, int> count_;
  std::vector<std::string> warnings_;
};

namespace pbrt_text {

std::string number_text(float value);  // that is read to the same bits
std::string bracketed(std::initializer_list<float> values);
std::string in_quotes(std::string_view text);
inline std::string vector_text(const vec3& v) { return bracketed({v.x, v.y, v.z}); }
std::string transform_text(const Transform& t, const vec3& origin = vec3(0));
inline std::string rgb_text(const char* name, const Rgb& c) { return std::string(" \"rgb ") + name + "\" " + vector_text(c); }

// A number that `read` turns into `wanted`, the one with the fewest digits, or the nearest where there is none. `guess`: an
// approximate inverse. What is read is then written as the same number again.
template <class Read, class Guess>
float number_read_as(float wanted, const Read& read, const Guess& guess) {
  float found = 0;
  for (int attempt = 0; attempt < 2; ++attempt) {
    const float start = guess(wanted);
    for (int digits = 1; digits <= 9; ++digits) {
      const auto shorter = static_cast<float>(parse_number(fmt::format("{:.{}g}", start, digits)).value_or(start));
      if (read(shorter) == wanted) return shorter;
    }
    found = start;
    float below = start, above = start;
    for (int step = 0; step < 16; ++step) {
      below = std::nextafter(below, -1e30f);
      above = std::nextafter(above, 1e30f);
      for (const float x : {below, above}) {
        if (read(x) == wanted) return x;
        if (std::abs(read(x) - wanted) < std::abs(read(found) - wanted)) found = x;
      }
    }
    wanted = read(found);
  }
  return found;
}

// A direction that `read` makes unit and by that turns into `wanted`; where there is none, into what `read` makes of `wanted`.
template <class Read>
vec3 direction_read_as(vec3 wanted, const Read& read) {
  for (int attempt = 0; attempt < 2; ++attempt) {
    for (int step = 0; step < 33; ++step) {
      const int steps = (step + 1) / 2 * (step % 2 == 0 ? 1 : -1);
      const vec3 candidate = wanted * (1 + static_cast<float>(steps) * 0x1p-23f);
      if (read(candidate) == wanted) return candidate;
    }
    wanted = read(wanted);
  }
  return wanted;
}

}  // namespace pbrt_text

}  // namespace etendue
