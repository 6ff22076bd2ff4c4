// Textures. What is constant becomes a colour as it is read; images and checkerboards over (u, v) are kept as they are; all
// else becomes a field, which is baked for each shape.

#include "framework/io/pbrt/reader.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

constexpr float reflectance_rounding = 1e-4f;

struct ScaleTexture {
  const Rgb& factor;

  Texture operator()(ImageTexture t) const {
    if (factor.x == factor.y && factor.y == factor.z) {
      t.gain *= factor.x;
    } else {
      for (Rgb& texel : t.texels) texel *= factor;
    }
    return t;
  }
  Texture operator()(CheckerTexture t) const {
    t.even *= factor;
    t.odd *= factor;
    return t;
  }
};

struct Extremes {
  float least = 0, most = 0;
  bool nan = false;

  void add(const Rgb& value) {
    for (int c = 0; c < 3; ++c) {
      least = std::min(least, value[c]);  // either is left as it is by NaN
      most = std::max(most, value[c]);
      nan = nan || std::isnan(value[c]);
    }
  }
  void operator()(const ImageTexture& t) {
    for (const Rgb& texel : t.texels) add(t.gain * texel);
  }
  void operator()(const CheckerTexture& t) {
    add(t.even);
    add(t.odd);
  }
};

// NaN, of a gain that overflows, becomes 0.
struct ClampToUnit {
  Texture operator()(ImageTexture t) const {
    for (Rgb& texel : t.texels) texel = within_unit(t.gain * texel);
    t.gain = 1;
    return t;
  }
  Texture operator()(CheckerTexture t) const {
    t.even = within_unit(t.even);
    t.odd = within_unit(t.odd);
    return t;
  }
};

// Every value of a texture by a function of it. Images keep their size: between texels the function's values are interpolated.
struct MapTexture {
  const std::function<Rgb(const Rgb&)>& map;

  Texture operator()(ImageTexture t) const {
    for (Rgb& texel : t.texels) texel = map(within_unit(t.gain * texel));
    t.gain = 1;
    return t;
  }
  Texture operator()(CheckerTexture t) const {
    t.even = map(within_unit(t.even));
    t.odd = map(within_unit(t.odd));
    return t;
  }
};

}  // namespace

void PbrtReader::texture(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string name = expect_string(lexer, "Texture");
  const Location at_kind = lexer.where(lexer.peek());
  const std::string kind = expect_string(lexer, "Texture");
  if (kind != "spectrum" && kind != "color" && kind != "float")
    throw Error(at_kind, unknown_name("kind of texture", kind, std::vector<std::string>{"spectrum", "float"}));
  const Location at_type = lexer.where(lexer.peek());
  const std::string type = expect_string(lexer, "Texture");
  PbrtParams params(lexer, titled(token.text, name), at_type, version3_);
  params.add_defaults(attributes_.defaults["texture"]);
  TextureMap& textures = kind == "float" ? float_textures_ : spectrum_textures_;
  define(textures, name, make_texture(lexer, type, params, textures), where, fmt::format("{} texture '{}'", kind, name));
  params.finish();
}

PbrtReader::TextureEntry PbrtReader::make_texture(PbrtLexer& lexer, const std::string& type, const PbrtParams& params,
                                                  TextureMap& textures) {
  require_known("Texture", "texture", type, params.where());
  if (type == "constant") {
    const auto value = operand(params, "value", Rgb(1), textures);
    if (const Rgb* constant = std::get_if<Rgb>(&value)) return {*constant};
    return {field_of(*std::get<const TextureEntry*>(value))};
  }
  if (type == "imagemap") return image_texture(lexer, params, &textures == &float_textures_);
  if (type == "checkerboard") return checker_texture(params, textures);
  if (type == "scale") return scaled_texture(params, textures);
  if (type == "mix") return mixed_texture(params, textures);
  const auto of = [&](std::string_view name, const Rgb& otherwise) { return field_operand(params, name, otherwise, textures); };
  if (type == "directionmix") return {direction_mix_field(params, ctm(), of)};
  if (type == "ptex") {
    approximate(params.where(), "texture \"ptex\" is not supported", "grey of 0.5");
    params.ignore_all();
    return {Rgb(0.5f)};
  }
  return {procedural_field(type, params, ctm(), version3_, of)};
}

std::uint32_t PbrtReader::add_texture(Texture texture) {
  scene_.textures.push_back(std::move(texture));
  return static_cast<std::uint32_t>(scene_.textures.size() - 1);
}

PbrtReader::TextureEntry PbrtReader::checker_texture(const PbrtParams& params, TextureMap& textures) {
  params.ignore({"aamode"});
  const auto a = operand(params, "tex1", Rgb(1), textures), b = operand(params, "tex2", Rgb(0), textures);
  const Rgb *even = std::get_if<Rgb>(&a), *odd = std::get_if<Rgb>(&b);
  if (even && odd && params.integer("dimension", 2, 2, 3) == 2)
    if (const TextureMapping mapping(params, ctm(), version3_); mapping.is_uv())
      return {CheckerTexture{.even = *even, .odd = *odd, .uv_scale = mapping.scale, .uv_offset = mapping.offset}};
  return {checkerboard_field(params, ctm(), version3_, [&](std::string_view name, const Rgb& otherwise) {
    return field_operand(params, name, otherwise, textures);
  })};
}

// Version 3 multiplies tex1 and tex2, version 4 tex and scale.
PbrtReader::TextureEntry PbrtReader::scaled_texture(const PbrtParams& params, TextureMap& textures) {
  const bool version4 = params.has("tex") || params.has("scale");
  const std::string_view names[] = {version4 ? "tex" : "tex1", version4 ? "scale" : "tex2"};
  // Version 4 scales by numbers, colours too.
  auto a = operand(params, names[0], Rgb(1), textures),
       b = operand(params, names[1], Rgb(1), version4 ? float_textures_ : textures);
  if (const Rgb* first = std::get_if<Rgb>(&a)) {
    if (const Rgb* second = std::get_if<Rgb>(&b)) return {*first * *second};
    std::swap(a, b);
  }
  const TextureEntry& entry = *std::get<const TextureEntry*>(a);
  const Rgb* factor = std::get_if<Rgb>(&b);
  if (!factor || std::holds_alternative<Field>(entry.value))
    return {combined_field(
        params, {field_of(entry), factor ? constant_field(*factor) : field_of(*std::get<const TextureEntry*>(b))},
        [](const TexturePlace& place, std::span<const Field> f) { return f[0]->at(place) * f[1]->at(place); })};
  return {std::visit(ScaleTexture{*factor}, texture_to_copy(entry)), entry.file};
}

PbrtReader::TextureEntry PbrtReader::mixed_texture(const PbrtParams& params, TextureMap& textures) {
  const auto a = operand(params, "tex1", Rgb(0), textures), b = operand(params, "tex2", Rgb(1), textures);
  const Rgb *first = std::get_if<Rgb>(&a), *second = std::get_if<Rgb>(&b);
  if (first && second && !params.texture("amount")) return {glm::mix(*first, *second, params.number("amount", 0.5f, 0, 1))};
  const Field amount = params.texture("amount") ? field_operand(params, "amount", Rgb(0.5f), float_textures_)
                                                : constant_field(Rgb(params.number("amount", 0.5f, 0, 1)));
  return {combined_field(
      params, {field_operand(params, "tex1", Rgb(0), textures), field_operand(params, "tex2", Rgb(1), textures), amount},
      [](const TexturePlace& place, std::span<const Field> f) {
        return glm::mix(f[0]->at(place), f[1]->at(place), f[2]->at(place));
      })};
}

const Texture& PbrtReader::texture_to_copy(const TextureEntry& entry) {
  const Texture& texture = entry.moved ? scene_.textures[*entry.scene_index] : std::get<Texture>(entry.value);
  if (const auto* image = std::get_if<ImageTexture>(&texture))
    files_.need_memory(image->texels.size() * sizeof(Rgb), entry.file);
  return texture;
}

Field PbrtReader::field_of(const TextureEntry& entry) {
  if (const Rgb* constant = std::get_if<Rgb>(&entry.value)) return constant_field(*constant);
  if (const Field* field = std::get_if<Field>(&entry.value)) return *field;
  return texture_field(texture_to_copy(entry));
}

Field PbrtReader::field_operand(const PbrtParams& params, std::string_view name, const Rgb& otherwise, TextureMap& textures) {
  const auto value = operand(params, name, otherwise, textures);
  if (const Rgb* constant = std::get_if<Rgb>(&value)) return constant_field(*constant);
  return field_of(*std::get<const TextureEntry*>(value));
}

PbrtReader::TextureEntry& PbrtReader::find_texture(const PbrtParams& params, std::string_view param, const std::string& name,
                                                   TextureMap& textures) {
  const auto found = textures.find(name);
  if (found != textures.end()) return found->second;
  const bool of_numbers = &textures == &float_textures_;
  if ((of_numbers ? spectrum_textures_ : float_textures_).contains(name))
    throw Error(params.where(param),
                fmt::format("{}: '{}' expects a {} texture, but '{}' is a {} texture", params.owner(), param,
                            of_numbers ? "float" : "spectrum", name, of_numbers ? "spectrum" : "float"));
  std::vector<std::string> names;
  for (const auto& [known, entry] : textures) names.push_back(known);
  // Textures that are composed of others are made in their order there, and all of them before what they are for.
  const bool of_texture = params.owner().starts_with("Texture ");
  throw Error(params.where(param), fmt::format("{}: {}{}", params.owner(),
                                               unknown_name(of_numbers ? "float texture" : "spectrum texture", name, names),
                                               of_texture ? "" : or_further_down()));
}

std::variant<Rgb, const PbrtReader::TextureEntry*> PbrtReader::operand(const PbrtParams& params, std::string_view name,
                                                                       const Rgb& otherwise, TextureMap& textures) {
  const auto texture = params.texture(name);
  const bool of_numbers = &textures == &float_textures_;
  if (version3_ && !texture && params.has(name) && params.is_number(name) != of_numbers) {
    warn(params.where(name), fmt::format("{}: '{}' has no effect, as in pbrt-v3, which expects a {}", params.owner(), name,
                                         of_numbers ? "float" : "colour"));
    params.ignore({name});
    return otherwise;
  }
  if (!texture) return params.colour(name, ColourUse::factor).value_or(otherwise);
  const TextureEntry& entry = find_texture(params, name, *texture, textures);
  if (const Rgb* constant = std::get_if<Rgb>(&entry.value)) return *constant;
  return &entry;
}

// Call it where only a constant will do.
Rgb PbrtReader::mean_operand(const PbrtParams& params, std::string_view name, const std::string& texture,
                             TextureMap& textures) {
  const TextureEntry& entry = find_texture(params, name, texture, textures);
  if (const Rgb* constant = std::get_if<Rgb>(&entry.value)) return *constant;
  approximate(params.where(name), fmt::format("'{}' is a texture that varies: only constants are supported here", name),
              "its mean: the surface is the same all over");
  return mean_of(field_of(entry));
}

float PbrtReader::number(const PbrtParams& params, std::string_view name, float otherwise, float low, float high) {
  const auto texture = params.texture(name);
  if (!texture) return params.number(name, otherwise, low, high);
  const float value = mean_operand(params, name, *texture, float_textures_).x;
  if (!(value >= low && value <= high)) params.fail(name, fmt::format("is {}; expected {} to {}", value, low, high));
  return value;
}

Rgb PbrtReader::colour(const PbrtParams& params, std::string_view name, const Rgb& otherwise, ColourUse use) {
  const auto texture = params.texture(name);
  if (!texture) return params.colour(name, use).value_or(otherwise);
  Rgb value = mean_operand(params, name, *texture, spectrum_textures_);
  if (!is_finite(value)) params.fail(name, "is a texture of a value that is not finite; expected finite values");
  if (use == ColourUse::reflectance && -max_component(-value) < 0) {
    warn(params.where(name),
         fmt::format("{}: '{}' is a texture that falls to {:.4g}, less than a surface can reflect: clamped to 0",
                     params.owner(), name, -max_component(-value)));
    value = glm::max(value, Rgb(0));
  }
  if (use != ColourUse::reflectance || max_component(value) <= 1) return value;
  approximate(params.where(name), "a reflectance above 1", "1, for no surface makes light: it is darker");
  return glm::min(value, Rgb(1));
}

TexturedRgb PbrtReader::textured_colour(const PbrtParams& params, std::string_view name, const Rgb& otherwise,
                                        MaterialEntry& material, const ColourMap& map) {
  const auto texture = params.texture(name);
  const auto constant = [&] {
    const Rgb value = colour(params, name, otherwise, ColourUse::reflectance);
    return TexturedRgb(map ? map(value) : value);
  };
  if (!texture) return constant();
  TextureEntry& entry = find_texture(params, name, *texture, spectrum_textures_);
  if (std::holds_alternative<Rgb>(entry.value)) return constant();
  material.textured = true;
  if (std::holds_alternative<Field>(entry.value)) {
    const Field& field = field_of_reflectance(entry, params.where(name), *texture);
    material.field = map ? mapped_field(field, [map](const Rgb& value) { return map(within_unit(value)); }) : field;
    return Rgb(0.5f);
  }
  if (!entry.scene_index || map) {
    Texture reflectance =
        map ? std::visit(MapTexture{map}, texture_to_copy(entry)) : take_reflectance(entry, params.where(name), *texture);
    if (!map) entry.scene_index = static_cast<std::uint32_t>(scene_.textures.size());
    scene_.textures.push_back(std::move(reflectance));
  }
  TexturedRgb result;
  result.texture = map ? static_cast<std::uint32_t>(scene_.textures.size() - 1) : *entry.scene_index;
  return result;
}

const Field& PbrtReader::field_of_reflectance(TextureEntry& entry, const Location& where, const std::string& name) {
  if (entry.reflectance) return entry.reflectance;
  const auto above = std::make_shared<std::atomic<bool>>(false), below = std::make_shared<std::atomic<bool>>(false);
  entry.reflectance = mapped_field(std::get<Field>(entry.value), [above, below](const Rgb& value) {
    if (max_component(value) > 1 + reflectance_rounding) above->store(true, std::memory_order_relaxed);
    if (max_component(-value) > 0) below->store(true, std::memory_order_relaxed);
    return value;
  });
  const std::string title = fmt::format("{}: texture '{}' reaches", where.text(), name);
  out_of_range_.push_back({title + " beyond 1, more than a surface can reflect: clamped to 1", above});
  out_of_range_.push_back({title + " below 0, less than a surface can reflect: clamped to 0", below});
  return entry.reflectance;
}

// No surface reflects more light than it receives, nor less than none: values are clamped to 0 .. 1, as by pbrt-v4. The
// texture keeps its own, which another may scale.
Texture PbrtReader::take_reflectance(TextureEntry& entry, const Location& where, const std::string& name) {
  Texture& value = std::get<Texture>(entry.value);
  Extremes found;
  std::visit(found, value);
  if (found.least >= 0 && found.most <= 1 && !found.nan) {
    entry.moved = true;
    return std::move(value);
  }
  const std::string texture =
      fmt::format("texture '{}'{}", name, entry.file.empty() ? "" : fmt::format(" of '{}'", entry.file));
  if (found.most > 1 + reflectance_rounding)
    warn(where, fmt::format("{} reaches {:.4g}, more than a surface can reflect: clamped to 1", texture, found.most));
  if (found.least < -reflectance_rounding)
    warn(where, fmt::format("{} falls to {:.4g}, less than a surface can reflect: clamped to 0", texture, found.least));
  if (found.nan) warn(where, fmt::format("{} holds NaN, as of a product of infinity and 0: taken as 0", texture));
  return std::visit(ClampToUnit{}, value);
}

}  // namespace etendue
