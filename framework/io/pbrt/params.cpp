#include "framework/io/pbrt/params.h"

#include "framework/io/spectra.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace etendue {

namespace {

enum class ValueKind : std::uint8_t { number, whole_number, boolean, string, any };

struct ParamType {
  std::string_view name, canonical;
  ValueKind values;
};
constexpr std::array<ParamType, 18> param_types{{{"integer", "integer", ValueKind::whole_number},
                                                 {"float", "float", ValueKind::number},
                                                 {"point2", "point2", ValueKind::number},
                                                 {"vector2", "vector2", ValueKind::number},
                                                 {"point3", "point3", ValueKind::number},
                                                 {"point", "point3", ValueKind::number},
                                                 {"vector3", "vector3", ValueKind::number},
                                                 {"vector", "vector3", ValueKind::number},
                                                 {"normal3", "normal3", ValueKind::number},
                                                 {"normal", "normal3", ValueKind::number},
                                                 {"rgb", "rgb", ValueKind::number},
                                                 {"color", "rgb", ValueKind::number},
                                                 {"xyz", "xyz", ValueKind::number},
                                                 {"blackbody", "blackbody", ValueKind::number},
                                                 {"spectrum", "spectrum", ValueKind::any},
                                                 {"bool", "bool", ValueKind::boolean},
                                                 {"string", "string", ValueKind::string},
                                                 {"texture", "texture", ValueKind::string}}};

const ParamType* find_type(std::string_view name) {
  const auto found = std::find_if(param_types.begin(), param_types.end(), [&](const ParamType& t) { return t.name == name; });
  return found == param_types.end() ? nullptr : &*found;
}

ValueKind values_of(const PbrtParam& param) { return find_type(param.type)->values; }

void add_value(const PbrtLexer& lexer, const Token& token, ValueKind kind, PbrtParam& param) {
  const auto fail = [&](const char* expected) {
    throw Error(lexer.where(token),
                fmt::format("expected {} for \"{} {}\", found {}", expected, param.type, param.name, lexer.describe(token)));
  };
  if (kind == ValueKind::boolean) {
    const bool is_true = token.text == "true", is_text = token.kind == TokenKind::word || token.kind == TokenKind::string;
    if (!is_text || (!is_true && token.text != "false")) fail("true or false");
    param.numbers.push_back(is_true ? 1 : 0);
  } else if (token.kind == TokenKind::number && kind != ValueKind::string) {
    if (kind == ValueKind::whole_number && (token.number != std::floor(token.number) || std::abs(token.number) > 0x7fffffff))
      fail("a whole number");
    param.numbers.push_back(token.number);
  } else if (token.kind == TokenKind::string && (kind == ValueKind::string || kind == ValueKind::any)) {
    param.strings.emplace_back(token.text);
  } else {
    fail(kind == ValueKind::string ? "a string" : kind == ValueKind::any ? "numbers or the name of a spectrum" : "a number");
  }
}

}  // namespace

bool is_of_material_in_version3(std::string_view name) {
  constexpr std::string_view names =
      " Kd Ks Kr Kt sigma roughness uroughness vroughness remaproughness index eta k opacity reflect transmit bumpmap amount "
      "mfp sigma_a sigma_s color metallic speculartint anisotropic sheen sheentint clearcoat clearcoatgloss spectrans "
      "scatterdistance flatness difftrans eumelanin pheomelanin beta_m beta_n bsdffile scale g name thin namedmaterial1 "
      "namedmaterial2 ";
  return names.find(fmt::format(" {} ", name)) != std::string_view::npos;
}

PbrtParams::PbrtParams(PbrtLexer& lexer, std::string owner, const Location& where, bool version3)
    : owner_(std::move(owner)), where_(where), file_(lexer.file()), files_(&lexer.files()), version3_(version3) {
  while (lexer.peek().kind == TokenKind::string) read(lexer);
}

void PbrtParams::read(PbrtLexer& lexer) {
  const Token declaration = lexer.next();
  WordReader words(declaration.text);
  const std::string type(words.word()), name(words.word());
  if (name.empty() || !words.word().empty())
    throw Error(lexer.where(declaration),
                fmt::format("{}: expected a parameter as \"type name\", found {}", owner_, quote(declaration.text)));
  const ParamType* known = find_type(type);
  if (!known) {
    std::vector<std::string> names;
    for (const ParamType& t : param_types) names.emplace_back(t.name);
    throw Error(lexer.where(declaration), fmt::format("{}: {}", owner_, unknown_name("parameter type", type, names)));
  }
  PbrtParam param{.type = std::string(known->canonical),
                  .name = name,
                  .numbers = {},
                  .strings = {},
                  .line = declaration.line,
                  .column = declaration.column};
  read_values(lexer, param);
  if (std::erase_if(params_, [&](const PbrtParam& other) { return other.name == name; }) > 0)
    files_->warn(lexer.where(declaration), fmt::format("{}: '{}' is given twice; the last one counts", owner_, name));
  if (params_.size() == most_params)
    throw Error(lexer.where(declaration), fmt::format("{}: more than {} parameters", owner_, most_params));
  params_.push_back(std::move(param));
}

void PbrtParams::read_values(PbrtLexer& lexer, PbrtParam& param) const {
  const ValueKind kind = values_of(param);
  Token token = lexer.next();
  if (token.kind != TokenKind::open) {
    add_value(lexer, token, kind, param);
    return;
  }
  for (token = lexer.next(); token.kind != TokenKind::close; token = lexer.next()) {
    if (token.kind == TokenKind::end)
      throw Error({*file_, param.line, param.column},
                  fmt::format("the values of \"{} {}\" have no closing ]", param.type, param.name));
    add_value(lexer, token, kind, param);
  }
}

const PbrtParam* PbrtParams::find(std::string_view name) const {
  if (std::find(understood_.begin(), understood_.end(), name) == understood_.end()) understood_.emplace_back(name);
  for (const PbrtParam& param : params_) {
    if (param.name != name) continue;
    param.used = true;
    return &param;
  }
  return nullptr;
}

Location PbrtParams::where(std::string_view name) const {
  for (const PbrtParam& param : params_)
    if (param.name == name) return {*file_, param.line, param.column};
  return where_;
}

void PbrtParams::fail(std::string_view name, const std::string& what) const {
  throw Error(where(name), fmt::format("{}: '{}' {}", owner_, name, what));
}

const PbrtParam* PbrtParams::find_typed(std::string_view name, std::initializer_list<std::string_view> types,
                                        std::string_view expected) const {
  const PbrtParam* param = find(name);
  if (param && std::find(types.begin(), types.end(), param->type) == types.end())
    fail(name, fmt::format("is of type {}; expected {}", param->type, expected));
  return param;
}

double PbrtParams::single(const PbrtParam& param) const {
  if (param.numbers.size() != 1) fail(param.name, fmt::format("has {} values; expected one", param.numbers.size()));
  return param.numbers[0];
}

bool PbrtParams::has(std::string_view name) const {
  return std::any_of(params_.begin(), params_.end(), [&](const PbrtParam& p) { return p.name == name; });
}

bool PbrtParams::is_number(std::string_view name) const {
  return std::any_of(params_.begin(), params_.end(),
                     [&](const PbrtParam& p) { return p.name == name && (p.type == "float" || p.type == "integer"); });
}

bool PbrtParams::is_spectrum(std::string_view name) const {
  return std::any_of(params_.begin(), params_.end(),
                     [&](const PbrtParam& p) { return p.name == name && p.type == "spectrum"; });
}

float PbrtParams::number(std::string_view name, float otherwise, float low, float high) const {
  const PbrtParam* param = find_typed(name, {"float", "integer"}, "float");
  if (!param) return otherwise;
  const auto value = static_cast<float>(single(*param));
  if (!(value >= low && value <= high)) fail(name, fmt::format("is {}; expected {} to {}", value, low, high));
  param->widened = param->type == "integer";
  return value;
}

int PbrtParams::integer(std::string_view name, int otherwise, int low, int high) const {
  const PbrtParam* param = find_typed(name, {"integer"}, "integer");
  if (!param) return otherwise;
  const int value = static_cast<int>(single(*param));
  if (value < low || value > high) fail(name, fmt::format("is {}; expected {} to {}", value, low, high));
  return value;
}

bool PbrtParams::boolean(std::string_view name, bool otherwise) const {
  const PbrtParam* param = find_typed(name, {"bool"}, "bool");
  return param ? single(*param) != 0 : otherwise;
}

std::string PbrtParams::string(std::string_view name, const std::string& otherwise) const {
  const PbrtParam* param = find_typed(name, {"string"}, "string");
  if (!param) return otherwise;
  if (param->strings.size() != 1) fail(name, fmt::format("has {} values; expected one", param->strings.size()));
  return param->strings[0];
}

std::vector<std::string> PbrtParams::strings(std::string_view name) const {
  const PbrtParam* param = find_typed(name, {"string"}, "string");
  return param ? param->strings : std::vector<std::string>();
}

std::optional<std::string> PbrtParams::texture(std::string_view name) const {
  const PbrtParam* param = find(name);
  if (!param || param->type != "texture") return std::nullopt;
  if (param->strings.size() != 1) fail(name, "expected the name of one texture");
  return param->strings[0];
}

std::optional<std::string> PbrtParams::named_spectrum(std::string_view name) const {
  const PbrtParam* param = find(name);
  if (!param || param->type != "spectrum" || param->strings.size() != 1 || !param->numbers.empty()) return std::nullopt;
  return param->strings[0];
}

vec3 PbrtParams::point(std::string_view name, const vec3& otherwise) const {
  if (!has(name)) {
    find(name);
    return otherwise;
  }
  const std::vector<vec3> all = points3(name);
  if (all.size() != 1) fail(name, fmt::format("has {} points; expected one", all.size()));
  return all[0];
}

std::vector<float> PbrtParams::numbers(std::string_view name) const {
  const PbrtParam* param = find_typed(name, {"float", "integer"}, "float");
  if (!param) return {};
  param->widened = param->type == "integer";
  return {param->numbers.begin(), param->numbers.end()};
}

std::vector<int> PbrtParams::integers(std::string_view name) const {
  const PbrtParam* param = find_typed(name, {"integer"}, "integer");
  return param ? std::vector<int>(param->numbers.begin(), param->numbers.end()) : std::vector<int>();
}

std::vector<vec2> PbrtParams::points2(std::string_view name) const {
  const PbrtParam* param = find_typed(name, {"point2", "vector2", "float"}, "point2");
  if (!param) return {};
  if (param->numbers.size() % 2 != 0) fail(name, fmt::format("has {} numbers; expected pairs", param->numbers.size()));
  std::vector<vec2> points;
  points.reserve(param->numbers.size() / 2);
  for (std::size_t i = 0; i < param->numbers.size(); i += 2) points.emplace_back(param->numbers[i], param->numbers[i + 1]);
  return points;
}

std::vector<vec3> PbrtParams::points3(std::string_view name) const {
  const PbrtParam* param = find_typed(name, {"point3", "vector3", "normal3"}, "point3, vector3 or normal3");
  if (!param) return {};
  const std::vector<double>& n = param->numbers;
  if (n.size() % 3 != 0) fail(name, fmt::format("has {} numbers; expected triples", n.size()));
  std::vector<vec3> points;
  points.reserve(n.size() / 3);
  for (std::size_t i = 0; i < n.size(); i += 3) points.emplace_back(n[i], n[i + 1], n[i + 2]);
  return points;
}

void PbrtParams::reject(std::string_view name, const std::string& reason) const {
  if (has(name)) fail(name, "is not supported: " + reason);
}

void PbrtParams::approximate(std::string_view name, const std::string& reason, const std::string& instead) const {
  if (!has(name)) return;
  ignore({name});
  files_->approximations().take(where(name), fmt::format("{}: '{}' is not supported: {}", owner_, name, reason), instead);
}

void PbrtParams::ignore_all() const {
  for (const PbrtParam& param : params_) param.used = true;
}

void PbrtParams::drop(std::string_view name, const std::string& why) {
  if (!has(name)) return;
  files_->warn(where(name), fmt::format("{}: '{}' has no effect, as in pbrt-v3, {}", owner_, name, why));
  std::erase_if(params_, [&](const PbrtParam& param) { return param.name == name; });
}

void PbrtParams::add_defaults(const PbrtDefaults& defaults) {
  for (const auto& param : defaults)
    if (!has(param->name)) {
      params_.push_back(*param);
      params_.back().used = true;  // one for another kind of shape is no mistake
    }
}

void PbrtParams::ignore(std::initializer_list<std::string_view> names) const {
  for (const std::string_view name : names) find(name);
}

void PbrtParams::accept(std::string_view name, std::string_view type) const {
  const PbrtParam* param = find(name);
  if (param && param->type != type && !(type == "float" && param->type == "integer"))
    fail(name, fmt::format("is of type {}; expected {}", param->type, type));
}

void PbrtParams::finish() const {
  for (const PbrtParam& param : params_) {
    const Location at{*file_, param.line, param.column};
    if (version3_ && param.widened)
      files_->warn(at, fmt::format("{}: '{}' is an integer, which counts here; pbrt-v3 expects a float and takes its default",
                                   owner_, param.name));
    if (param.used) continue;
    const bool is_foreign = is_of_material_in_version3(param.name) || nearest_names(param.name, understood_, 1).empty();
    if (!version3_ || !is_foreign)
      throw Error(at, fmt::format("{}: {}", owner_, unknown_name("parameter", param.name, understood_)));
    files_->warn(at, fmt::format("{}: '{}' has no effect, as in pbrt-v3, which does not know it here", owner_,
                                 param.name.substr(0, 80)));
  }
}

}  // namespace etendue
