// Camera, film and options.

#include "framework/io/pbrt/reader.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <array>

namespace etendue {

namespace {

[[noreturn]] void fail_unknown(const Location& where, std::string_view kind, const std::string& name,
                               const std::vector<std::string>& known) {
  throw Error(where, unknown_name(kind, name, known));
}

}  // namespace

void PbrtReader::camera(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string type = expect_string(lexer, "Camera");
  if (type != "perspective") fail_unknown(where, "camera", type, {"perspective"});
  const PbrtParams params(lexer, titled(token.text, type), lexer.where(token));
  Camera& camera = scene_.camera;
  camera.to_world = attributes_.ctm.inverse();
  if (!within_reach(camera.to_world.point(vec3(0))))
    throw Error(params.where(), fmt::format("Camera: lies beyond {:g} m", farthest));
  float degrees = params.number("fov", 90, 1e-3f, 179.9f);
  degrees = 2 * params.number("halffov", 0.5f * degrees, 5e-4f, 89.95f);
  camera.fov = degrees * (pi / 180);
  camera.lens_radius = params.number("lensradius", 0, 0);
  camera.focal_distance = params.number("focaldistance", 1e6f, 1e-6f);
  camera_ = CameraEntry{params.where(), std::nullopt, params.numbers("screenwindow")};
  if (params.has("frameaspectratio")) camera_->frame_aspect = params.number("frameaspectratio", 1, 1e-6f);
  params.ignore({"shutteropen", "shutterclose"});
  if (params.has("shutteropen") || params.has("shutterclose"))
    warn(params.where(), "shutter times have no effect: nothing moves");
  params.finish();
  coordinate_systems_.insert_or_assign("camera", camera.to_world);
}

// Once the resolution is known: only frames that fit it are supported.
void PbrtReader::check_camera() {
  if (!camera_) {
    warn({files_.first_file()}, "the scene has no Camera: at the origin, looking along +z, with a field of view of 90 degrees");
    scene_.camera.fov = pi / 2;
    return;
  }
  const float aspect = static_cast<float>(scene_.resolution.x) / static_cast<float>(scene_.resolution.y);
  const auto differs = [](float a, float b) { return std::abs(a - b) > 1e-3f * std::abs(b); };
  if (camera_->frame_aspect && differs(*camera_->frame_aspect, aspect))
    throw Error(camera_->where, fmt::format("Camera: 'frameaspectratio' is {}; only that of the film is supported, {:.6g}",
                                            *camera_->frame_aspect, aspect));
  const std::vector<float>& window = camera_->screen_window;
  if (window.empty()) return;
  const float x = std::max(aspect, 1.0f), y = std::max(1 / aspect, 1.0f);
  if (window.size() != 4 || differs(window[0], -x) || differs(window[1], x) || differs(window[2], -y) || differs(window[3], y))
    throw Error(camera_->where,
                fmt::format("Camera: only the 'screenwindow' [{:.6g} {:.6g} {:.6g} {:.6g}] that fits the film is supported", -x,
                            x, -y, y));
}

void PbrtReader::film(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string type = expect_string(lexer, "Film");
  if (type != "image" && type != "rgb") fail_unknown(where, "film", type, {"rgb", "image"});
  const PbrtParams params(lexer, titled(token.text, type), lexer.where(token));
  const ivec2 otherwise = type == "image" ? ivec2(640, 480) : ivec2(1280, 720);  // version 3's and 4's
  scene_.resolution = {params.integer("xresolution", otherwise.x, 1, 65536),
                       params.integer("yresolution", otherwise.y, 1, 65536)};

  if (const float factor = params.number("scale", 1); factor != 1)
    params.fail("scale", fmt::format("is {}; only 1 is supported", factor));
  const float exposure = params.number("exposuretime", 1) * params.number("iso", 100) / 100;
  if (std::abs(exposure - 1) > 1e-6f)
    params.fail(params.has("iso") ? "iso" : "exposuretime",
                fmt::format("scales the image by {:.6g}; only 1 is supported", exposure));
  if (const std::string sensor = params.string("sensor", "cie1931"); sensor != "cie1931")
    params.fail("sensor", fmt::format("is '{}'; only cie1931 is supported", sensor));
  if (params.number("whitebalance", 0) != 0) params.fail("whitebalance", "is not supported");
  const std::array<float, 4> whole{0, 1, 0, 1};
  if (const auto crop = params.numbers("cropwindow");
      !crop.empty() && !std::equal(crop.begin(), crop.end(), whole.begin(), whole.end()))
    params.fail("cropwindow", "is not supported: the whole image is rendered");
  const std::array<int, 4> pixels{0, scene_.resolution.x, 0, scene_.resolution.y};
  if (const auto bounds = params.integers("pixelbounds");
      !bounds.empty() && !std::equal(bounds.begin(), bounds.end(), pixels.begin(), pixels.end()))
    params.fail("pixelbounds", "is not supported: the whole image is rendered");
  for (const std::string_view clamp : {"maxcomponentvalue", "maxsampleluminance"})
    if (params.has(clamp)) warn(params.where(clamp), fmt::format("'{}' is not applied: clamping would bias the image", clamp));
  params.ignore({"filename", "diagonal", "savefp16", "maxcomponentvalue", "maxsampleluminance"});
  params.finish();
}

void PbrtReader::color_space(PbrtLexer& lexer, const Token&) {
  const Location where = lexer.where(lexer.peek());
  const std::string name = expect_string(lexer, "ColorSpace");
  if (name != "srgb") fail_unknown(where, "colour space", name, {"srgb"});
}

void PbrtReader::option(PbrtLexer& lexer, const Token& token) {
  const PbrtParams params(lexer, "Option", lexer.where(token));
  if (params.boolean("forcediffuse", false)) params.fail("forcediffuse", "is not supported");
  params.ignore({"disablepixeljitter", "disabletexturefiltering", "disablewavelengthjitter", "displacementedgescale",
                 "msereferenceimage", "msereferenceout", "pixelstats", "rendercoordsys", "seed", "wavefront"});
  params.finish();
}

}  // namespace etendue
