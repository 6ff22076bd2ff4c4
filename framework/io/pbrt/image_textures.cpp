// Textures of image files.

#include "framework/io/gzip.h"
#include "framework/io/image/gamma.h"
#include "framework/io/pbrt/reader.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {

namespace {

// 0: sRGB. Files of floats are linear in any case.
float read_gamma(const PbrtParams& params) {
  const std::string encoding = params.string("encoding", params.boolean("gamma", true) ? "sRGB" : "linear");
  if (encoding == "sRGB") return 0;
  if (encoding == "linear") return 1;
  WordReader words(encoding);
  const bool named = words.word() == "gamma";
  const auto gamma = parse_number(words.word());
  if (!named || !gamma || !(*gamma >= 0.1 && *gamma <= 10))
    params.fail("encoding", fmt::format("is {}; expected sRGB, linear or gamma with a number of 0.1 to 10", quote(encoding)));
  return static_cast<float>(*gamma);
}

// The integers of such files are sRGB's whatever is asked for; version 4 tells formats by their names.
bool is_srgb_in_version4(const std::string& file, std::string_view bytes) {
  return extension_of(file) != ".png" && !holds_floats(bytes);
}

Wrap read_wrap(const PbrtParams& params) {
  const std::string wrap = params.string("wrap", "repeat");
  if (wrap == "repeat") return Wrap::repeat;
  if (wrap == "clamp") return Wrap::clamp;
  if (wrap != "black") params.fail("wrap", fmt::format("is '{}'; expected repeat, clamp or black", wrap));
  return Wrap::black;
}

enum class TexelUse : std::uint8_t { colours, numbers, version3_numbers };

// The texels as they are decoded. Version 4 reads numbers from the alpha of a PNG or EXR that is somewhere transparent, encoded
// like its colours; it drops that of other formats. Version 3 decodes the luminance of the colours as they are encoded.
template <class Read, class Bytes>
RgbImage read_texels(const Read& read, const Bytes& bytes, float gamma, TexelUse use) {
  const auto decode = [&](RgbImage& image) {
    if (gamma != 1 && !holds_floats(bytes())) decode_gamma(image, gamma);
  };
  if (use == TexelUse::numbers && may_have_alpha(bytes())) {
    RgbImage alpha = read(Encoding::alpha);
    if (std::ranges::any_of(alpha.texels, [](const Rgb& texel) { return texel.x != 1; })) {
      decode(alpha);
      return alpha;
    }
  }
  RgbImage image = read(gamma == 0 ? Encoding::srgb : Encoding::linear);
  if (gamma != 0) decode(image);
  const auto is_grey = [](const Rgb& texel) { return texel.x == texel.y && texel.y == texel.z; };
  if (use == TexelUse::version3_numbers && !std::ranges::all_of(image.texels, is_grey)) {
    image = read(Encoding::linear);
    for (Rgb& texel : image.texels) texel = Rgb(luminance(texel));
    decode(image);
  }
  return image;
}

}  // namespace

PbrtReader::TextureEntry PbrtReader::image_texture(PbrtLexer& lexer, const PbrtParams& params, bool of_numbers) {
  const TextureMapping mapping(params, ctm(), version3_);
  const std::string file = params.string("filename", "");
  if (file.empty()) params.fail("filename", "is missing");
  const Wrap wrap = read_wrap(params);
  params.ignore({"trilinear", "maxanisotropy"});
  ImageTexture texture{.size = {},
                       .texels = {},
                       .uv_scale = mapping.scale,
                       .uv_offset = mapping.offset,
                       .gain = params.number("scale", 1, of_numbers ? -1e30f : 0),
                       .wrap_u = wrap,
                       .wrap_v = wrap};
  float gamma = read_gamma(params);
  const Location named = params.where("filename");
  const auto bytes = [&] { return files_.read(file, *lexer.file(), named).bytes; };
  if (!version3_ && params.has("encoding") && gamma != 0 && is_srgb_in_version4(file, bytes())) {
    warn(params.where("encoding"), fmt::format("'encoding' has no effect, as in pbrt-v4, which asks for it of PNG alone: the "
                                               "values of '{}' are those of sRGB",
                                               file));
    gamma = 0;
  }
  RgbImage image =
      read_texels([&](Encoding encoding) { return files_.image(file, *lexer.file(), named, encoding); }, bytes, gamma,
                  !of_numbers ? TexelUse::colours
                  : version3_ ? TexelUse::version3_numbers
                              : TexelUse::numbers);
  if (version3_ && params.boolean("gamma", false) && holds_floats(bytes())) decode_gamma(image, 0);  // as it is told to
  warn_of_texels(image, params.where("filename"), file);
  if (params.string("filter", "bilinear") == "point")
    if (const int times = repeat_texels(image, params.where("filter")); times < 16)
      warn(params.where("filter"), fmt::format("interpolated over 1/{} of a texel at the edges of each", times));
  texture.size = image.size;
  texture.texels = std::move(image.texels);
  const bool inverts = params.boolean("invert", false);
  if (inverts && wrap == Wrap::black)  // which is white then
    return {mapped_field(image_field(std::move(texture), mapping),
                         [](const Rgb& value) { return glm::max(Rgb(1) - value, Rgb(0)); }),
            file};
  if (inverts) {
    for (Rgb& texel : texture.texels) texel = glm::max(Rgb(1) - texture.gain * texel, Rgb(0));
    texture.gain = 1;
  }
  if (!mapping.is_uv()) return {image_field(std::move(texture), mapping), file};
  return {std::move(texture), file};
}

void PbrtReader::warn_of_texels(const RgbImage& image, const Location& where, const std::string& file, bool of_light) {
  if (image.had_own_primaries && (version3_ || !of_light))
    warn(where, fmt::format("'{}' states primaries of its own, by which its texels are converted to linear sRGB; {}", file,
                            version3_ ? "pbrt-v3 takes them as they are"
                                      : "pbrt-v4 keeps the white of reflectances, and numbers and normals as they are"));
  if (image.not_finite == 0) return;
  std::string at;
  for (const ivec2& texel : image.first_not_finite) at += fmt::format("{} ({}, {})", at.empty() ? "" : ",", texel.x, texel.y);
  warn(where, fmt::format("'{}' holds NaN or infinity in {} texels, which are taken as 0: at{} (column, row)", file,
                          image.not_finite, at + (image.not_finite > image.first_not_finite.size() ? ", ..." : "")));
}

}  // namespace etendue
