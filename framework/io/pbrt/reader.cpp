#include "framework/io/pbrt/reader.h"

#include "framework/io/pbrt/pbrt.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace etendue {

std::span<const PbrtReader::Directive> PbrtReader::directives() {
  using R = PbrtReader;
  static constexpr Directive table[] = {
      {"Accelerator", Phase::options, &R::accelerator},
      {"ActiveTransform", Phase::any, &R::active_transform},
      {"AreaLightSource", Phase::world, &R::area_light_source},
      {"Attribute", Phase::any, &R::attribute},
      {"AttributeBegin", Phase::any, &R::attribute_begin},
      {"AttributeEnd", Phase::any, &R::attribute_end},
      {"Camera", Phase::options, &R::camera},
      {"ColorSpace", Phase::any, &R::color_space},
      {"ConcatTransform", Phase::any, &R::concat_transform},
      {"CoordSysTransform", Phase::any, &R::coord_sys_transform},
      {"CoordinateSystem", Phase::any, &R::coordinate_system},
      {"Film", Phase::options, &R::film},
      {"Identity", Phase::any, &R::identity},
      {"Import", Phase::world, &R::import},
      {"Include", Phase::any, &R::include},
      {"Integrator", Phase::options, &R::integrator},
      {"LightSource", Phase::world, &R::light_source},
      {"LookAt", Phase::any, &R::look_at},
      {"MakeNamedMaterial", Phase::any, &R::make_named_material},
      {"MakeNamedMedium", Phase::any, &R::named_medium},
      {"Material", Phase::any, &R::material},
      {"MediumInterface", Phase::any, &R::medium_interface},
      {"NamedMaterial", Phase::any, &R::named_material},
      {"ObjectBegin", Phase::world, &R::object_begin},
      {"ObjectEnd", Phase::world, &R::object_end},
      {"ObjectInstance", Phase::world, &R::object_instance},
      {"Option", Phase::options, &R::option},
      {"PixelFilter", Phase::options, &R::pixel_filter},
      {"ReverseOrientation", Phase::any, &R::reverse_orientation},
      {"Rotate", Phase::any, &R::rotate},
      {"Sampler", Phase::options, &R::sampler},
      {"Scale", Phase::any, &R::scale},
      {"Shape", Phase::world, &R::shape},
      {"Texture", Phase::any, &R::texture},
      {"Transform", Phase::any, &R::transform},
      {"TransformBegin", Phase::any, &R::transform_begin},
      {"TransformEnd", Phase::any, &R::transform_end},
      {"TransformTimes", Phase::any, &R::transform_times},
      {"Translate", Phase::any, &R::translate},
      {"WorldBegin", Phase::options, &R::world_begin},
      {"WorldEnd", Phase::world, &R::world_end},
  };
  return table;
}

namespace {

// Has the text the directive that version 4 did away with, outside of comments and strings of its line?
bool has_world_end(std::string_view text) {
  constexpr std::string_view directive = "WorldEnd";
  for (std::size_t at = text.find(directive); at != std::string_view::npos; at = text.find(directive, at + 1)) {
    const std::string_view before = text.substr(0, at);
    const std::size_t line = before.rfind('\n') + 1;  // 0 where there is none
    if (before.substr(line).find_first_of("#\"") == std::string_view::npos) return true;
  }
  return false;
}

}  // namespace

Scene PbrtReader::read(std::string text) {
  version3_ = has_world_end(text);  // if it has no Film, which tells
  PbrtLexer lexer(std::move(text), files_.first_file(), files_);
  parse(lexer);
  finish();
  return std::move(scene_);
}

void PbrtReader::parse(PbrtLexer& lexer) {
  for (Token token = lexer.next(); token.kind != TokenKind::end; token = lexer.next()) {
    const Location where = lexer.where(token);
    if (token.kind != TokenKind::word) throw Error(where, fmt::format("expected a directive, found {}", lexer.describe(token)));
    const Directive* found = find_directive(token.text);
    if (!found) fail_unknown_directive(lexer, token);
    // Prose may begin with a word such as Scale, but then goes on with another.
    if (const Token& next = lexer.peek(); lexer.is_scene() || next.kind != TokenKind::word || find_directive(next.text))
      lexer.know_as_scene();
    check_phase(*found, where);
    (this->*found->handler)(lexer, token);
  }
}

const PbrtReader::Directive* PbrtReader::find_directive(std::string_view name) {
  const auto table = directives();
  const auto found = std::find_if(table.begin(), table.end(), [&](const Directive& d) { return d.name == name; });
  return found == table.end() ? nullptr : &*found;
}

void PbrtReader::fail_unknown_directive(const PbrtLexer& lexer, const Token& token) {
  std::vector<std::string> names;
  for (const Directive& d : directives()) names.emplace_back(d.name);
  constexpr std::string_view of_older[] = {"SurfaceIntegrator", "VolumeIntegrator", "Volume", "Renderer", "SearchPath"};
  if (std::ranges::find(of_older, token.text) != std::end(of_older))
    throw Error(lexer.where(token),
                fmt::format("{} is of pbrt's versions 1 and 2; those that are read are 3 and 4", token.text));
  if (lexer.is_scene()) throw Error(lexer.where(token), unknown_name("directive", token.text, names));
  const std::vector<std::string> nearest = nearest_names(token.text, names, 1);
  throw Error(lexer.where(token), "no pbrt scene: its first word is no directive such as Camera, Shape or Include" +
                                      (nearest.empty() ? "" : fmt::format("; did you mean '{}'?", nearest[0])));
}

void PbrtReader::check_phase(const Directive& directive, const Location& where) const {
  if (world_ended_) throw Error(where, fmt::format("{} after WorldEnd: one scene per file", directive.name));
  if (directive.phase == Phase::options && in_world_)
    throw Error(where, fmt::format("{} must stand before WorldBegin", directive.name));
  if (directive.phase == Phase::world && !in_world_)
    throw Error(where, fmt::format("{} must stand after WorldBegin", directive.name));
}

void PbrtReader::finish() {
  if (!stack_.empty()) {
    constexpr std::string_view names[] = {"AttributeBegin", "TransformBegin", "ObjectBegin"};
    throw Error(stack_.back().where, fmt::format("{} is never closed", names[static_cast<int>(stack_.back().block)]));
  }
  if (!in_world_) throw Error(Location{files_.first_file()}, "the file has no WorldBegin");
  std::vector<Emission> emissions;
  scene_.objects[0] = world_.parts[0].builder.take(&emissions);
  if (scene_.objects[0].shapes.empty() && !scene_.has_instances()) warn({files_.first_file()}, "the scene has no shapes");
  if (emissions.empty() && scene_.lights.empty()) warn({files_.first_file()}, "the scene has no lights");
  limit_to_direct_light();
  if (const Bounds bounds = scene_.bounds();
      scene_.has_instances() && !bounds.empty() && !(within_reach(bounds.lower) && within_reach(bounds.upper)))
    throw Error(Location{files_.first_file()}, fmt::format("an instance lies beyond {:g} m", farthest));
  check_camera();
  scene_.filter = make_pixel_filter(filter_of_version());
  expose(emissions);
  for (const OutOfRange& texture : out_of_range_)
    if (*texture.met) scene_.warnings.push_back(texture.text);
  for (const LostDetail& lost : lost_details_)
    scene_.warnings.push_back(lost.more == 0 ? lost.text : fmt::format("{} (and in {} more places)", lost.text, lost.more));
  for (std::string& warning : files_.warnings()) scene_.warnings.push_back(std::move(warning));
  for (std::string& warning : left_out_.warnings()) scene_.warnings.push_back(std::move(warning));
  finish_scene(scene_, emissions);
}

// Sets parameters that later directives do not give themselves.
void PbrtReader::attribute(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string target = expect_string(lexer, "Attribute");
  const std::vector<std::string> targets{"shape", "light", "material", "medium", "texture"};
  if (std::find(targets.begin(), targets.end(), target) == targets.end())
    throw Error(where, unknown_name("target of Attribute", target, targets));
  const PbrtParams params(lexer, titled(token.text, target), lexer.where(token), version3_);
  PbrtDefaults& defaults = attributes_.defaults[target];
  for (const PbrtParam& param : params.all()) {
    std::erase_if(defaults, [&](const auto& other) { return other->name == param.name; });
    if (defaults.size() == most_params)
      throw Error(params.where(), fmt::format("{}: more than {} parameters for what follows", params.owner(), most_params));
    defaults.push_back(std::make_shared<const PbrtParam>(param));
  }
}

namespace {

constexpr std::string_view no_media = "there are no participating media";
constexpr std::string_view vacuum = "vacuum: nothing scatters or absorbs between surfaces";

}  // namespace

void PbrtReader::named_medium(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(token);
  const std::string name = expect_string(lexer, "MakeNamedMedium");
  const PbrtParams params(lexer, titled(token.text, name), where, version3_);
  approximate(where, fmt::format("MakeNamedMedium is not supported: {}", no_media), std::string(vacuum));
}

// Two empty names are the vacuum that is here anyway.
void PbrtReader::medium_interface(PbrtLexer& lexer, const Token& token) {
  bool is_vacuum = expect_string(lexer, "MediumInterface").empty();
  if (lexer.peek().kind == TokenKind::string) is_vacuum &= lexer.next().text.empty();
  if (!is_vacuum)
    approximate(lexer.where(token), fmt::format("MediumInterface is not supported: {}", no_media), std::string(vacuum));
}

void PbrtReader::include(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string name = expect_string(lexer, std::string(token.text));
  if (include_depth_ == SceneFiles::most_nested_includes)
    throw Error(where, fmt::format("files include each other more than {} deep: does one include itself?",
                                   SceneFiles::most_nested_includes));
  SceneFiles::File file = files_.include(name, *lexer.file(), where);
  PbrtLexer included(std::move(file.bytes), file.path, files_);
  ++include_depth_;
  parse(included);
  --include_depth_;
}

// Import is Include, but attributes that the file sets end with it.
void PbrtReader::import(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(token);
  push(Block::attribute, where);
  const int outer = std::exchange(import_, ++imports_);
  include(lexer, token);
  import_ = outer;
  attributes_ = pop(Block::attribute, "Import", where);
}

void PbrtReader::world_begin(PbrtLexer&, const Token& token) {
  if (!stack_.empty()) throw Error(stack_.back().where, fmt::format("a block is open at {}", token.text));
  in_world_ = true;
  attributes_.ctm = {};
  attributes_.end_only = false;
  coordinate_systems_.insert_or_assign("world", CoordinateSystem{attributes_.ctm});
}

void PbrtReader::world_end(PbrtLexer&, const Token&) { world_ended_ = true; }

void PbrtReader::push(Block block, const Location& where) {
  constexpr std::size_t most_nested = 1024;
  if (stack_.size() == most_nested) throw Error(where, fmt::format("blocks nest more than {} deep", most_nested));
  stack_.push_back({block, attributes_, where, forget_.size()});
}

PbrtReader::Attributes PbrtReader::pop(Block block, std::string_view name, const Location& where) {
  constexpr std::string_view begins[] = {"AttributeBegin", "TransformBegin", "ObjectBegin"};
  if (stack_.empty()) throw Error(where, fmt::format("{} without {}", name, begins[static_cast<int>(block)]));
  if (stack_.back().block != block)
    throw Error(where, fmt::format("{} inside the {} of line {}", name, begins[static_cast<int>(stack_.back().block)],
                                   stack_.back().where.line));
  Attributes saved = std::move(stack_.back().attributes);
  if (block != Block::transform)
    for (; forget_.size() > stack_.back().forgets; forget_.pop_back()) forget_.back()();
  stack_.pop_back();
  return saved;
}

void PbrtReader::attribute_begin(PbrtLexer& lexer, const Token& token) { push(Block::attribute, lexer.where(token)); }
void PbrtReader::attribute_end(PbrtLexer& lexer, const Token& token) {
  attributes_ = pop(Block::attribute, token.text, lexer.where(token));
}
void PbrtReader::transform_begin(PbrtLexer& lexer, const Token& token) { push(Block::transform, lexer.where(token)); }
// Version 3 restores the transform alone, version 4 all that AttributeEnd does.
void PbrtReader::transform_end(PbrtLexer& lexer, const Token& token) {
  Attributes saved = pop(Block::transform, token.text, lexer.where(token));
  attributes_.ctm = saved.ctm;
  attributes_.end_only = saved.end_only;
  if (!version3_) attributes_ = std::move(saved);
}
void PbrtReader::reverse_orientation(PbrtLexer&, const Token&) {
  attributes_.reverse_orientation = !attributes_.reverse_orientation;
}

std::string PbrtReader::expect_string(PbrtLexer& lexer, const std::string& what) const {
  const Token token = lexer.next();
  if (token.kind != TokenKind::string)
    throw Error(lexer.where(token), fmt::format("{}: expected a string, found {}", what, lexer.describe(token)));
  return std::string(token.text);
}

float PbrtReader::expect_number(PbrtLexer& lexer, const std::string& what) const {
  const Token token = lexer.next();
  if (token.kind != TokenKind::number)
    throw Error(lexer.where(token), fmt::format("{}: expected a number, found {}", what, lexer.describe(token)));
  return static_cast<float>(token.number);
}

Scene parse_pbrt(std::string text, const std::string& path, const SceneReading& reading) {
  return PbrtReader(path, reading).read(std::move(text));
}

Scene read_pbrt(const std::string& path, const SceneReading& reading) { return parse_pbrt(read_file(path), path, reading); }

}  // namespace etendue
