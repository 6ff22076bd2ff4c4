// Materials and textures. Each is defined once, where it is first used.

#include "framework/io/image/exr.h"
#include "framework/io/image/image_file.h"
#include "framework/io/pbrt/writer.h"

#include <algorithm>

namespace etendue {

using namespace pbrt_text;

namespace {

// The value of each byte of an image file in sRGB, as the reader decodes it.
std::vector<float> decoded_bytes() {
  std::vector<std::uint8_t> ramp;
  for (int i = 0; i < 256; ++i) ramp.insert(ramp.end(), 3, static_cast<std::uint8_t>(i));
  const auto png = encode_png(ramp.data(), {256, 1});
  std::vector<float> values;
  for (const Rgb& texel : decode_image({png.begin(), png.end()}, "ramp").texels) values.push_back(texel.x);
  return values;
}

// As a PNG, if each texel is a value of its bytes: so are those of an 8-bit image. Empty otherwise.
std::string bytes_of_png(ivec2 size, const std::vector<Rgb>& texels) {
  static const std::vector<float> values = decoded_bytes();
  std::vector<std::uint8_t> rgb;
  rgb.reserve(3 * texels.size());
  for (const Rgb& texel : texels)
    for (int c = 0; c < 3; ++c) {
      const auto found = std::lower_bound(values.begin(), values.end(), texel[c]);
      if (found == values.end() || *found != texel[c]) return {};
      rgb.push_back(static_cast<std::uint8_t>(found - values.begin()));
    }
  const auto png = encode_png(rgb.data(), size);
  return {png.begin(), png.end()};
}

std::string bytes_of_exr(ivec2 size, const std::vector<Rgb>& texels) {
  Image image(size);
  std::copy(texels.begin(), texels.end(), image.pixels.begin());
  return encode_exr(image);
}

std::string mapping_text(const vec2& scale, const vec2& offset) {
  std::string text;
  const auto add = [&](const char* name, float value, float otherwise) {
    if (value != otherwise) text += fmt::format(" \"float {}\" {}", name, bracketed({value}));
  };
  add("uscale", scale.x, 1);
  add("vscale", scale.y, 1);
  add("udelta", offset.x, 0);
  add("vdelta", offset.y, 0);
  return text;
}

Rgb normal_reflectance(const Conductor& metal) {
  if (metal.ideal) return metal.tint;
  const Rgb k2 = metal.k * metal.k, less = metal.eta - 1.0f, more = metal.eta + 1.0f;
  return metal.tint * (less * less + k2) / (more * more + k2);
}

// pbrt-v4's index of a metal of a given reflectance.
Conductor plain_conductor(const Rgb& reflectance, const vec2& alpha) {
  const Rgb r = glm::clamp(reflectance, Rgb(0), Rgb(0.9999f));
  return {.eta = Rgb(1), .k = glm::max(2.0f * glm::sqrt(r) / glm::sqrt(1.0f - r), Rgb(1e-4f)), .alpha = alpha};
}

}  // namespace

std::string PbrtWriter::image_file(const char* kind, ivec2 size, const std::vector<Rgb>& texels, bool floats) {
  const std::string png = floats ? "" : bytes_of_png(size, texels);
  const std::string name = numbered(kind);
  return png.empty() ? file(name + ".exr", bytes_of_exr(size, texels)) : file(name + ".png", png);
}

std::string PbrtWriter::wrap_text(const ImageTexture& image) {
  if (image.wrap_u == Wrap::repeat && image.wrap_v == Wrap::repeat) return "";
  if (image.wrap_u == Wrap::clamp && image.wrap_v == Wrap::clamp) return " \"string wrap\" \"clamp\"";
  if (image.wrap_u == Wrap::black && image.wrap_v == Wrap::black) return " \"string wrap\" \"black\"";
  warn("images that end differently along u and v, or are mirrored: pbrt has none; taken as repeated");
  return "";
}

std::string PbrtWriter::texture_name(std::uint32_t texture, const char* kind) {
  const auto [entry, is_new] = textures_.try_emplace(texture);
  if (!is_new) return entry->second;
  entry->second = fmt::format("texture-{}", textures_.size() - 1);
  const bool is_float = std::string_view(kind) == "float";
  std::string text = "Texture " + in_quotes(entry->second) + " " + in_quotes(kind) + " ";
  if (const auto* image = std::get_if<ImageTexture>(&scene_.textures[texture])) {
    text += "\"imagemap\" \"string filename\" " + image_file("texture", image->size, image->texels, is_float) +
            mapping_text(image->uv_scale, image->uv_offset) + wrap_text(*image);
    if (image->gain != 1) text += " \"float scale\" " + bracketed({image->gain});
  } else {
    const auto& checker = std::get<CheckerTexture>(scene_.textures[texture]);
    const auto value = [&](const char* name, const Rgb& c) {
      return is_float ? fmt::format(" \"float {}\" {}", name, bracketed({mean_component(c)})) : rgb_text(name, c);
    };
    text += "\"checkerboard\"" + value("tex1", checker.even) + value("tex2", checker.odd) +
            mapping_text(checker.uv_scale, checker.uv_offset);
  }
  looks_ += text + "\n";
  return entry->second;
}

// A mask of one value is a number.
std::string PbrtWriter::mask_text(std::uint32_t mask) {
  if (mask == no_id) return "";
  if (const auto* image = std::get_if<ImageTexture>(&scene_.textures[mask]); image && image->size == ivec2(1))
    return " \"float alpha\" " + bracketed({mean_component(image->gain * image->texels[0])});
  return " \"texture alpha\" [ " + in_quotes(texture_name(mask, "float")) + " ]";
}

std::string PbrtWriter::colour_text(const char* name, const TexturedRgb& colour) {
  if (colour.is_constant()) return rgb_text(name, colour.constant);
  return fmt::format(" \"texture {}\" [ {} ]", name, in_quotes(texture_name(colour.texture)));
}

float PbrtWriter::within(float value, float low, float high, const char* what) {
  if (value >= low && value <= high) return value;
  warn(fmt::format("{} of {:.4g}: pbrt scenes are read with {:g} to {:g}; taken as the nearest of these", what, value, low,
                   high));
  return std::clamp(value, low, high);
}

std::string PbrtWriter::roughness_text(const vec2& alpha, NormalDistribution distribution) {
  if (alpha == vec2(0)) return "";
  if (distribution != NormalDistribution::ggx)
    warn("Beckmann's distribution of normals: pbrt has none; taken as GGX of the same roughness");
  const float u = within(alpha.x, 1e-3f, 1, "a roughness"), v = within(alpha.y, 1e-3f, 1, "a roughness");
  return (u == v ? " \"float roughness\" " + bracketed({u})
                 : " \"float uroughness\" " + bracketed({u}) + " \"float vroughness\" " + bracketed({v})) +
         " \"bool remaproughness\" [ false ]";
}

std::string PbrtWriter::material_text(const Diffuse& diffuse) {
  return "\"diffuse\"" + colour_text("reflectance", diffuse.reflectance);
}

std::string PbrtWriter::material_text(const Conductor& conductor) {
  if (conductor.ideal && conductor.alpha == vec2(0)) {
    warn("mirrors: pbrt-v4 has none; written as version 3's \"mirror\"");
    return "\"mirror\"" + rgb_text("Kr", conductor.tint);
  }
  if (conductor.ideal || conductor.tint != Rgb(1)) {
    warn(
        "metals whose reflection is tinted, or the same at all angles: pbrt has none that are so and rough, or have an index; "
        "taken as metals of the same reflectance straight on");
    return material_text(plain_conductor(normal_reflectance(conductor), conductor.alpha));
  }
  return "\"conductor\"" + rgb_text("eta", conductor.eta) + rgb_text("k", conductor.k) +
         roughness_text(conductor.alpha, conductor.distribution);
}

std::string PbrtWriter::material_text(const Dielectric& dielectric) {
  const float eta = within(dielectric.eta, 0.1f, 10, "glass with an index");
  const bool tinted = dielectric.reflect_tint != Rgb(1) || dielectric.transmit_tint != Rgb(1);
  if (dielectric.thin) {
    if (tinted) warn("tinted panes: pbrt-v4 has none; written without their tint");
    return "\"thindielectric\" \"float eta\" " + bracketed({eta});
  }
  const std::string surface =
      " \"float eta\" " + bracketed({eta}) + roughness_text(vec2(dielectric.alpha), dielectric.distribution);
  if (!tinted) return "\"dielectric\"" + surface;
  warn("tinted glass: pbrt-v4 has none; written as version 3's \"glass\"");
  return "\"glass\"" + rgb_text("Kr", dielectric.reflect_tint) + rgb_text("Kt", dielectric.transmit_tint) + surface;
}

std::string PbrtWriter::material_text(const Plastic& plastic) {
  return "\"coateddiffuse\"" + colour_text("reflectance", plastic.reflectance) + " \"float eta\" " +
         bracketed({within(plastic.coat.eta(), 1.0001f, 10, "a coat with an index")}) + " \"float thickness\" " +
         bracketed({plastic.coat.depth()}) + roughness_text(vec2(plastic.alpha), plastic.distribution);
}

std::string PbrtWriter::material_text(const DiffuseTransmission& sheet) {
  return "\"diffusetransmission\"" + colour_text("reflectance", sheet.reflectance) +
         colour_text("transmittance", sheet.transmittance);
}

std::string PbrtWriter::material_name(std::uint32_t material) {
  const auto [entry, is_new] = materials_.try_emplace(material);
  if (is_new) {
    entry->second = fmt::format("material-{}", materials_.size() - 1);
    const std::string text = std::visit([this](const auto& m) { return material_text(m); }, scene_.materials[material]);
    looks_ += "MakeNamedMaterial " + in_quotes(entry->second) + " \"string type\" " + text + "\n";
  }
  return entry->second;
}

}  // namespace etendue
