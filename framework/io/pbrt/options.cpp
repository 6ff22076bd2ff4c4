// Camera, film and options.

#include "framework/core/elementary.h"
#include "framework/core/lists.h"
#include "framework/io/pbrt/reader.h"
#include "framework/io/spectra.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace etendue {

namespace {

[[noreturn]] void fail_unknown(const Location& where, std::string_view kind, const std::string& name,
                               const std::vector<std::string>& known) {
  throw Error(where, unknown_name(kind, name, known));
}

bool differs(float a, float b) { return std::abs(a - b) > 1e-3f * std::abs(b); }

struct KnownOption {
  std::string_view name;
  bool is_boolean;
};
constexpr KnownOption known_options[] = {{"disablepixeljitter", true},
                                         {"disabletexturefiltering", true},
                                         {"disablewavelengthjitter", true},
                                         {"forcediffuse", true},
                                         {"pixelstats", true},
                                         {"wavefront", true},
                                         {"rendercoordsys", false},
                                         {"displacementedgescale", false},
                                         {"msereferenceimage", false},
                                         {"msereferenceout", false},
                                         {"seed", false}};

}  // namespace

void PbrtReader::camera(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string type = expect_string(lexer, "Camera");
  const bool spherical = type == "spherical" || type == "environment";
  require_known("Camera", "camera", type, where);
  const PbrtParams params(lexer, titled(token.text, type), lexer.where(token), version3_);
  Camera& camera = scene_.camera;
  camera.to_world = ctm().inverse();
  if (!within_reach(camera.to_world.point(vec3(0))))
    throw Error(params.where(), fmt::format("Camera: lies beyond {:g} m", farthest));
  const std::string what = fmt::format("Camera \"{}\" is not supported", type);
  if (spherical) {
    approximate(where, what, "a perspective of 120 degrees around the middle of its image: the rest is not seen");
    // The middle of the image looks along -x of the camera, and its right side lies along -z.
    camera.to_world = camera.to_world * Transform::rotate(-pi / 2, {0, 1, 0}) * Transform::scale({-1, 1, 1});
  }
  if (type == "realistic") {
    approximate(where, what, "a pinhole with the view of a lens of 50 mm: nothing is out of focus or distorted");
    params.ignore({"lensfile", "aperturediameter", "focusdistance", "aperture", "simpleweighting"});
  }
  params.ignore({"mapping"});
  float degrees = params.number("fov", spherical ? 120.0f : type == "realistic" ? 27.0f : 90.0f, 1e-3f, 179.9f);
  degrees = 2 * params.number("halffov", 0.5f * degrees, 5e-4f, 89.95f);
  camera.fov = degrees * (pi / 180);
  camera.lens_radius = params.number("lensradius", 0, 0);
  camera.focal_distance = params.number("focaldistance", 1e6f, 1e-6f);
  camera_ = CameraEntry{params.where(), std::nullopt, params.numbers("screenwindow"), std::nullopt};
  if (type == "orthographic") camera_->kind = CameraEntry::Kind::orthographic;
  if (spherical) camera_->kind = CameraEntry::Kind::spherical;
  if (params.has("frameaspectratio")) camera_->frame_aspect = params.number("frameaspectratio", 1, 1e-6f);
  const float opens = params.number("shutteropen", 0), closes = params.number("shutterclose", 1);
  if (params.has("shutteropen") || params.has("shutterclose")) camera_->open_time = closes - opens;
  params.finish();
  coordinate_systems_.insert_or_assign("camera", CoordinateSystem{{ctm().inverse(), std::nullopt}});
}

// Once the resolution is known.
void PbrtReader::check_camera() {
  if (!camera_) {
    warn({files_.first_file()}, "the scene has no Camera: at the origin, looking along +z, with a field of view of 90 degrees");
    scene_.camera.fov = pi / 2;
    return;
  }
  if (camera_->open_time) take_open_time(*camera_->open_time);
  const float aspect = static_cast<float>(scene_.resolution.x) / static_cast<float>(scene_.resolution.y);
  if (camera_->frame_aspect && differs(*camera_->frame_aspect, aspect))
    approximate(camera_->where,
                fmt::format("Camera: 'frameaspectratio' is {}; only that of the film is supported, {:.6g}",
                            *camera_->frame_aspect, aspect),
                "that of the film: the image is not stretched");
  if (camera_->kind == CameraEntry::Kind::orthographic || !camera_->screen_window.empty()) check_window(aspect);
  if (camera_->kind != CameraEntry::Kind::orthographic) unscale_camera();
}

// Version 4 scales the image by the time for which the shutter is open.
void PbrtReader::take_open_time(float seconds) {
  if (version3_) return warn(camera_->where, "shutter times have no effect: nothing moves");
  if (!(seconds > 0)) throw Error(camera_->where, "Camera: 'shutterclose' is not after 'shutteropen': the image is black");
  warn(camera_->where, fmt::format("shutter times: nothing moves, and the image is scaled by {:g}, as in pbrt-v4", seconds));
  exposure_ *= seconds;
}

// A scaled camera sees the same as one of the world's scale, whose lens is measured in the world.
void PbrtReader::unscale_camera() {
  Camera& camera = scene_.camera;
  const auto scale = camera.to_world.similarity_scale();
  camera.distorts = !scale;
  if (!scale || std::abs(*scale - 1) <= 1e-4f) return;
  camera.to_world = camera.to_world * Transform::scale(vec3(1 / *scale));
  camera.lens_radius *= *scale;
  camera.focal_distance = std::min(camera.focal_distance * *scale, 1e12f);
}

// A window about the middle with the film's shape narrows or widens the view; a parallel view may be beside the middle, too.
void PbrtReader::check_window(float aspect) {
  const bool parallel = camera_->kind == CameraEntry::Kind::orthographic;
  const float x = std::max(aspect, 1.0f), y = std::max(1 / aspect, 1.0f);
  std::vector<float> window = camera_->screen_window;
  if (window.empty()) window = {-x, x, -y, y};
  if (window.size() != 4 || !(window[0] < window[1] && window[2] < window[3]))
    throw Error(camera_->where, "Camera: 'screenwindow' expects four numbers: x from, x to, y from, y to");
  const float half_x = 0.5f * (window[1] - window[0]), half_y = 0.5f * (window[3] - window[2]);
  const bool centred = !differs(window[1], half_x) && !differs(window[3], half_y);
  if (!(centred || parallel) || differs(half_x * y, half_y * x))
    approximate(
        camera_->where,
        fmt::format("Camera: only the 'screenwindow' [{:.6g} {:.6g} {:.6g} {:.6g}] that fits the film is supported, or a "
                    "multiple of it",
                    -x, x, -y, y),
        "one about the middle, as high: what lies to the side moves in the image");
  if (parallel)
    make_parallel({0.5f * (window[0] + window[1]), 0.5f * (window[2] + window[3])}, half_y / y);
  else
    scene_.camera.fov = 2 * math::atan(math::tan(0.5f * scene_.camera.fov) * half_y / y);
}

void PbrtReader::make_parallel(const vec2& middle, float half_width) {
  Camera& camera = scene_.camera;
  const auto scale = camera.to_world.similarity_scale();
  if (!scale) throw Error(camera_->where, "Camera \"orthographic\": its transform distorts the image; scale it evenly");
  camera.to_world = camera.to_world * Transform::translate({middle, 0}) * Transform::scale(vec3(1 / *scale));
  camera.half_width = *scale * half_width;
  if (!within_reach(camera.to_world.point(vec3(camera.half_width))) || !(camera.half_width > 0))
    throw Error(camera_->where, fmt::format("Camera: lies beyond {:g} m", farthest));
  if (camera.lens_radius > 0)
    approximate(camera_->where, "Camera \"orthographic\": 'lensradius' is not supported", "0: all is in focus");
  camera.lens_radius = 0;
}

void PbrtReader::film(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string type = expect_string(lexer, "Film");
  if (type != "image" && type != "rgb" && type != "gbuffer" && type != "spectral")
    fail_unknown(where, "film", type, {"rgb", "image", "gbuffer", "spectral"});
  version3_ = type == "image";
  const PbrtParams params(lexer, titled(token.text, type), lexer.where(token), version3_);
  scene_.resolution = {params.integer("xresolution", default_resolution.x, 1, 65536),
                       params.integer("yresolution", default_resolution.y, 1, 65536)};
  read_exposure(params);
  scene_.crop.reset();  // of an earlier film
  read_crop(params);
  for (const std::string_view clamp : {"maxcomponentvalue", "maxsampleluminance"})
    if (params.has(clamp)) warn(params.where(clamp), fmt::format("'{}' is not applied: clamping would bias the image", clamp));
  params.ignore({"filename", "diagonal", "savefp16", "maxcomponentvalue", "maxsampleluminance", "coordinatesystem", "lambdamin",
                 "lambdamax", "nbuckets"});
  params.finish();
}

// The file states the part in shares of the image (cropwindow), or in pixels.
void PbrtReader::read_crop(const PbrtParams& params) {
  const vec2 size(scene_.resolution);
  const auto take = [&](const char* name, const std::array<float, 4>& shares) {
    const auto& [x0, x1, y0, y1] = shares;
    if (!(x0 >= 0 && x0 < x1 && x1 <= 1 && y0 >= 0 && y0 < y1 && y1 <= 1))
      params.fail(name, "is empty, or no part of the image; expected x from, x to, y from, y to");
    if (shares == std::array<float, 4>{0, 1, 0, 1}) return;
    scene_.crop = shares;
    warn(params.where(name), fmt::format("'{}': `etendue render` shows that part, experiments the whole image", name));
  };
  if (const auto crop = params.numbers("cropwindow"); !crop.empty()) {
    if (crop.size() != 4) params.fail("cropwindow", "expected four numbers: x from, x to, y from, y to");
    take("cropwindow", {crop[0], crop[1], crop[2], crop[3]});
  }
  if (const auto bounds = params.integers("pixelbounds"); !bounds.empty()) {
    if (bounds.size() != 4) params.fail("pixelbounds", "expected four numbers: x from, x to, y from, y to");
    const auto share = [](int pixel, float of) { return static_cast<float>(pixel) / of; };
    take("pixelbounds",
         {share(bounds[0], size.x), share(bounds[1], size.x), share(bounds[2], size.y), share(bounds[3], size.y)});
  }
}

// Reads by what the film scales its image: light is scaled instead, which is the same.
void PbrtReader::read_exposure(const PbrtParams& params) {
  constexpr float most = 1e9f;
  exposure_ = Rgb(params.number("scale", 1, 0, most) * params.number("exposuretime", 1, 0, most) *
                  params.number("iso", 100, 0, most) / 100);
  if (const std::string sensor = params.string("sensor", "cie1931"); sensor != "cie1931")
    approximate(params.where("sensor"), "'sensor': only cie1931 is supported",
                "cie1931: colours are those of the eye, not of a camera");
  if (const float kelvin = params.number("whitebalance", 0, 0, 1e6f); kelvin != 0) {
    approximate(params.where("whitebalance"), "'whitebalance' is not supported",
                "a gain of each channel: saturated colours shift");
    exposure_ *= blackbody_rgb(6504) / glm::max(blackbody_rgb(std::max(kelvin, 1000.0f)), Rgb(1e-3f));
  }
}

void PbrtReader::expose(std::vector<Emission>& emissions) {
  if (exposure_ == Rgb(1)) return;
  struct Scale {
    const Rgb& by;
    Rgb& operator()(AreaLight& l) const { return l.radiance *= by; }
    Rgb& operator()(PointLight& l) const { return l.intensity *= by; }
    Rgb& operator()(SpotLight& l) const { return l.intensity *= by; }
    Rgb& operator()(DirectionalLight& l) const { return l.irradiance *= by; }
    Rgb& operator()(EnvironmentLight& l) const { return l.scale *= by; }
  };
  const auto check = [&](const Rgb& scaled, float most_texel) {
    if (!is_finite(scaled) || max_component(scaled) * most_texel > brightest)
      throw Error(Location{files_.first_file()}, fmt::format("Film: scaled, a light is beyond {:g}", brightest));
  };
  for (Light& light : scene_.lights) {
    float most_texel = 1;
    if (const auto* environment = std::get_if<EnvironmentLight>(&light))
      for (const Rgb& texel : environment->texels) most_texel = std::max(most_texel, max_component(texel));
    check(std::visit(Scale{exposure_}, light), most_texel);
  }
  for (Emission& emission : emissions) check(emission.radiance *= exposure_, 1);
}

void PbrtReader::color_space(PbrtLexer& lexer, const Token&) {
  const Location where = lexer.where(lexer.peek());
  const std::string name = expect_string(lexer, "ColorSpace");
  if (name == "srgb") return;
  if (name != "rec2020" && name != "aces2065-1" && name != "dci-p3")
    fail_unknown(where, "colour space", name, {"srgb", "rec2020", "aces2065-1", "dci-p3"});
  approximate(where, fmt::format("ColorSpace \"{}\" is not supported", name), "srgb: saturated colours are paler");
}

void PbrtReader::option(PbrtLexer& lexer, const Token& token) {
  if (const Token name = lexer.peek(); name.kind == TokenKind::string && name.text.find(' ') == std::string_view::npos)
    return untyped_option(lexer);
  const PbrtParams params(lexer, "Option", lexer.where(token), version3_);
  for (const auto& [name, is_boolean] : known_options)
    if (is_boolean && params.boolean(name, false))
      set_option(name, params.where(name));
    else
      params.ignore({name});
  params.finish();
}

// A name and a value, as version 4 reads options. Capitals, - and _ make no difference in names.
void PbrtReader::untyped_option(PbrtLexer& lexer) {
  const Token written = lexer.next();
  const Location where = lexer.where(written);
  std::string name = in_lower_case(std::string(written.text));
  std::erase_if(name, [](char c) { return c == '-' || c == '_'; });
  const auto* const known = std::ranges::find(known_options, name, &KnownOption::name);
  if (known == std::end(known_options)) {
    std::vector<std::string> names;
    for (const KnownOption& option : known_options) names.emplace_back(option.name);
    throw Error(where, unknown_name("option", name, names));
  }
  const Token value = lexer.next();
  const bool is_true = value.text == "true", is_boolean = value.kind == TokenKind::word && (is_true || value.text == "false"),
             is_value = is_boolean || value.kind == TokenKind::number || value.kind == TokenKind::string;
  if (known->is_boolean ? !is_boolean : !is_value)
    throw Error(lexer.where(value), fmt::format("Option '{}': expected {}, found {}", name,
                                                known->is_boolean ? "true or false" : "a value", lexer.describe(value)));
  if (known->is_boolean && is_true) set_option(name, where);
}

void PbrtReader::set_option(std::string_view name, const Location& where) {
  if (name == "forcediffuse") throw Error(where, "Option: 'forcediffuse' is not supported");
  if (name == "disablepixeljitter")
    warn(where, "Option: 'disablepixeljitter' has no effect here: rays are spread over each pixel");
}

}  // namespace etendue
