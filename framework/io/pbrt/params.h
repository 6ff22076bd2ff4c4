// The typed parameters of one pbrt directive: "type name" value, "type name" [ values ].
//
// Reading a parameter marks it. `finish` throws on what nobody read, or warns where pbrt-v3 would, so that no parameter is
// ignored in silence.
#pragma once

#include "framework/core/vec.h"
#include "framework/io/pbrt/lexer.h"

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace etendue {

struct PbrtParam {
  std::string type;  // canonical: "point" is "point3", "color" is "rgb"
  std::string name;
  std::vector<double> numbers;  // booleans are 0 and 1
  std::vector<std::string> strings;
  int line = 0, column = 0;
  mutable bool used = false;
  mutable bool widened = false;  // an integer that was read as a float
};
// No directive has a tenth of as many. Each is compared with each, which would take minutes for a hundred thousand.
inline constexpr std::size_t most_params = 1000;
// Those that an Attribute gives to what follows. Every block that opens keeps the list, and shares their values.
using PbrtDefaults = std::vector<std::shared_ptr<const PbrtParam>>;

// Tells what a colour stands for, which says how spectra become RGB and which values are possible. A factor is a texture's
// value, which others may scale.
enum class ColourUse : std::uint8_t { reflectance, factor, index, light };

class PbrtParams {
 public:
  // Reads parameters up to the next token that begins none. `owner` is the directive as messages name it: Shape "sphere".
  // `version3`: numbers and spectra mean what they do in pbrt-v3.
  PbrtParams(PbrtLexer& lexer, std::string owner, const Location& where, bool version3);

  const std::string& owner() const { return owner_; }
  const Location& where() const { return where_; }
  Location where(std::string_view name) const;  // of the parameter, else of the directive

  bool has(std::string_view name) const;
  bool is_number(std::string_view name) const;  // is it there, of type float or integer?
  bool is_spectrum(std::string_view name) const;
  // Each throws Error on a value of another type, a wrong number of values, or one that is out of range.
  float number(std::string_view name, float otherwise, float low = -1e30f, float high = 1e30f) const;
  int integer(std::string_view name, int otherwise, int low, int high) const;
  bool boolean(std::string_view name, bool otherwise) const;
  std::string string(std::string_view name, const std::string& otherwise) const;
  vec3 point(std::string_view name, const vec3& otherwise) const;  // point3 or vector3
  std::vector<float> numbers(std::string_view name) const;         // empty where absent
  std::vector<int> integers(std::string_view name) const;
  std::vector<vec2> points2(std::string_view name) const;  // point2, vector2 or pairs of float
  std::vector<vec3> points3(std::string_view name) const;  // point3, vector3 or normal3
  std::optional<Rgb> colour(std::string_view name, ColourUse use) const;
  std::vector<std::string> strings(std::string_view name) const;
  // The name in a parameter of type "texture".
  std::optional<std::string> texture(std::string_view name) const;
  std::optional<std::string> named_spectrum(std::string_view name) const;

  // The parameter exists but cannot be honoured: throws with the reason.
  void reject(std::string_view name, const std::string& reason) const;
  // Does what reject does where approximations are refused; else the parameter is known and `instead` is taken.
  void approximate(std::string_view name, const std::string& reason, const std::string& instead) const;
  // These are known and have no effect here.
  void ignore(std::initializer_list<std::string_view> names) const;
  // It is known and left to the command line; throws where it is of another type.
  void accept(std::string_view name, std::string_view type) const;
  // Ignores all of them, for what is approximated without looking.
  void ignore_all() const;
  // Forgets what the file gives, with a warning that says why.
  void drop(std::string_view name, const std::string& why);
  // Those that are not given, from an earlier Attribute.
  void add_defaults(const PbrtDefaults& defaults);
  const std::vector<PbrtParam>& all() const { return params_; }
  // Throws Error on what was not read. In version 3 that is a warning, as in pbrt-v3, unless it looks like a misspelling.
  void finish() const;
  [[noreturn]] void fail(std::string_view name, const std::string& what) const;

 private:
  void read(PbrtLexer& lexer);
  void read_values(PbrtLexer& lexer, PbrtParam& param) const;
  const PbrtParam* find(std::string_view name) const;
  const PbrtParam* find_typed(std::string_view name, std::initializer_list<std::string_view> types,
                              std::string_view expected) const;
  double single(const PbrtParam& param) const;
  Rgb spectrum_colour(const PbrtParam& param, ColourUse use) const;
  Rgb blackbody_colour(const PbrtParam& param, ColourUse use) const;

  std::string owner_;
  Location where_;
  std::shared_ptr<const std::string> file_;
  SceneFiles* files_;
  bool version3_;
  std::vector<PbrtParam> params_;
  mutable std::vector<std::string> understood_;
};

// Does a material of pbrt-v3 know the parameter? There a shape's own parameters come before those of its material.
bool is_of_material_in_version3(std::string_view name);

}  // namespace etendue
