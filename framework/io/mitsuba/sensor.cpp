// The sensor with its film, and what of the integrator changes the image.

#include "framework/core/elementary.h"
#include "framework/core/lists.h"
#include "framework/io/mitsuba/reader.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <tuple>
#include <utility>

namespace etendue {

namespace {

// Integrators of Mitsuba that compute all transport, a part of it, or something else.
constexpr std::string_view all_light[] = {
    "path",           "volpath", "volpathmis", "volpath_simple", "bdpt",     "pssmlt", "mlt", "erpt",  "ptracer",
    "adjointptracer", "ppm",     "sppm",       "photonmapper",   "irrcache", "vpl",    "prb", "stokes"};
constexpr std::string_view wrappers[] = {"moment", "aov", "adaptive", "multichannel", "irrcache", "stokes"};

bool is_one_of(std::span<const std::string_view> names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

constexpr ivec2 mitsuba_resolution{768, 576};
constexpr float mitsuba_stddev = 0.5f;  // of the Gaussian filter, pixels

FilterShape gaussian_filter(float sigma) { return {.kind = FilterKind::gaussian, .radius = vec2(4 * sigma), .sigma = sigma}; }

}  // namespace

std::span<const MitsubaReader::SensorType> MitsubaReader::sensor_types() {
  using R = MitsubaReader;
  static constexpr SensorType table[] = {
      {"perspective", "fov and fov_axis, or focal_length; film size, rfilter, crop", &R::perspective},
      {"perspective_rdist", "the same, its distortion approximated by none", &R::perspective},
      {"thinlens", "the same with aperture_radius and focus_distance", &R::thin_lens},
      {"orthographic", "as it is", &R::orthographic},
      {"telecentric", "like orthographic; an aperture approximated by none", &R::orthographic},
      {"batch", "approximated: a view from the origin", &R::other_sensor},
      {"distant", "approximated: a view along +z of the sensor", &R::other_sensor},
      {"fluencemeter", "approximated: a view from the origin", &R::other_sensor},
      {"irradiancemeter", "approximated: a view from the origin", &R::other_sensor},
      {"radiancemeter", "approximated: a view from the origin", &R::other_sensor},
      {"spherical", "approximated: a view along +z of the sensor", &R::other_sensor},
  };
  return table;
}

// One is the scene's camera. Others are there for whoever asks for them by name, and keep no scene from loading.
void MitsubaReader::sensor(const XmlElement& element) {
  const Camera camera = scene_.camera;
  const auto [resolution, crop, filter] = std::tuple(scene_.resolution, scene_.crop, scene_.filter);
  const bool is_camera = &element == camera_;
  try {
    scene_.camera = {};
    read_sensor(element);
    const std::string id = element.value("id");
    scene_.cameras.push_back({id.empty() ? fmt::format("sensor-{}", scene_.cameras.size() + 1) : id, scene_.camera,
                              scene_.resolution, scene_.crop, scene_.filter});
  } catch (const Error& e) {
    if (is_camera) throw;
    warn(element.where(), std::string("another sensor, which cannot be used: ") + e.what());
  }
  if (is_camera) return;
  std::tie(scene_.resolution, scene_.crop, scene_.filter) = std::tie(resolution, crop, filter);
  scene_.camera = camera;
}

void MitsubaReader::read_sensor(const XmlElement& element) {
  const Properties of = properties(element);
  const SensorType& type = find_type(sensor_types(), of);
  film(of);
  of.objects({"sampler"});
  leave_out_media(of);
  of.ignore({"near_clip", "far_clip", "shutter_open", "shutter_close", "srf"});
  (this->*type.handler)(of);
  keep_clipping(of);
  of.finish();
}

// The angle is across the width unless fov_axis says otherwise; a focal length is that of 35 mm film, across its diagonal.
float MitsubaReader::field_of_view(const Properties& of) const {
  const vec2 size(scene_.resolution);
  std::string axis = in_lower_case(of.string("fov_axis", "x"));
  float angle = of.number("fov", 0, 1e-3f, 179.9f) * degrees;
  if (of.has("fov") && of.has("focal_length")) of.fail("focal_length", "stands beside 'fov'; expected the one or the other");
  if (!of.has("fov")) {
    std::string length = of.string("focal_length", "50mm");
    if (length.ends_with("mm")) length.resize(length.size() - 2);
    const auto number = parse_number(length);
    if (!number || !(*number > 0)) of.fail("focal_length", fmt::format("is {}; expected a length such as 50mm", quote(length)));
    angle = 2 * math::atan(std::sqrt(36.0f * 36 + 24 * 24) / (2 * static_cast<float>(*number)));
    axis = "diagonal";
  }
  const float shorter = std::min(size.x, size.y);
  const auto across = [&] {
    if (axis == "x") return size.x;
    if (axis == "y") return size.y;
    if (axis == "diagonal") return glm::length(size);
    if (axis == "smaller") return shorter;
    if (axis == "larger") return std::max(size.x, size.y);
    throw Error(of.where("fov_axis"),
                fmt::format("{}: {}", of.title(),
                            unknown_name("axis", axis, std::vector<std::string>{"x", "y", "diagonal", "smaller", "larger"})));
  }();
  return 2 * math::atan(math::tan(0.5f * angle) * shorter / across);
}

// Mitsuba's +x is to the left of the image. A scaled camera sees the same as an unscaled one.
void MitsubaReader::place_camera(const Properties& of) {
  Transform t = of.transform("to_world");
  const auto scale = t.similarity_scale();
  if (scale && std::abs(*scale - 1) > 1e-4f) t = t * Transform::scale(vec3(1 / *scale));
  scene_.camera.distorts = !scale;
  scene_.camera.to_world = t * Transform::scale({-1, 1, 1});
  placed_point(of, t, vec3(0));
  for (const std::string_view name : {"principal_point_offset_x", "principal_point_offset_y", "shift_x", "shift_y"})
    if (of.number(name, 0) != 0)
      approximate(of.where(name), fmt::format("{}: '{}' moves the image; only 0 is supported", of.title(), name), "0");
  if (of.has("kc"))
    approximate(of.where("kc"), fmt::format("{}: 'kc' bends straight lines; it is not supported", of.title()), "no distortion");
}

void MitsubaReader::perspective(const Properties& of) {
  scene_.camera.fov = field_of_view(of);
  of.ignore({"focus_distance"});
  place_camera(of);
}

void MitsubaReader::thin_lens(const Properties& of) {
  scene_.camera.lens_radius = of.number("aperture_radius", 0, 0, 1e6f);
  scene_.camera.focal_distance = of.number("focus_distance", of.number("far_clip", 10'000, 1e-6f), 1e-6f);
  for (const std::string_view name : {"blades", "aperture_blades"})
    if (of.has(name))
      approximate(of.where(name), fmt::format("{}: '{}' is not supported", of.title(), name),
                  "a round aperture: what is out of focus has another shape");
  of.ignore({"blade_rotation"});
  scene_.camera.fov = field_of_view(of);
  place_camera(of);
}

// x from -1 to 1 across the film, scaled by to_world.
void MitsubaReader::orthographic(const Properties& of) {
  const Transform t = of.transform("to_world");
  const float half_width = glm::length(t.vector({1, 0, 0})),
              aspect = static_cast<float>(scene_.resolution.y) / static_cast<float>(scene_.resolution.x);
  const auto scale = (t * Transform::scale({1, 1, half_width / glm::length(t.vector({0, 0, 1}))})).similarity_scale();
  if (!scale || !std::isfinite(half_width))
    of.fail("to_world", "distorts the image; expected the same scale along x and y, and no shear");
  scene_.camera.half_width = half_width * std::min(1.0f, aspect);
  const vec3 right = -t.vector({1, 0, 0}) / half_width, up = t.vector({0, 1, 0}) / half_width;
  const vec3 forward = glm::normalize(t.vector({0, 0, 1})), eye = placed_point(of, t, vec3(0));
  const auto placed = Transform::from_matrix(mat4(vec4(right, 0), vec4(up, 0), vec4(forward, 0), vec4(eye, 1)));
  if (!placed) of.fail("to_world", "has no inverse");
  scene_.camera.to_world = *placed;
  if (of.number("aperture_radius", 0, 0) != 0)
    approximate(of.where("aperture_radius"), fmt::format("{}: 'aperture_radius' is not supported", of.title()),
                "0: all is in focus");
  of.ignore({"focus_distance"});
}

void MitsubaReader::other_sensor(const Properties& of) {
  approximate(of.where(), fmt::format("{} is not supported", of.title()),
              "a perspective view of 90 degrees from where it stands");
  place_camera(of);
  scene_.camera.fov = pi / 2;
  of.ignore_all();
}

// Mitsuba's: where there are shapes, from so far before them that all is seen whose widest extent stands at their front.
void MitsubaReader::default_sensor(const Location& whole) {
  scene_.resolution = mitsuba_resolution;
  scene_.filter = make_pixel_filter(gaussian_filter(mitsuba_stddev));
  const vec2 size(mitsuba_resolution);
  const float tan_half = math::tan(22.5f * degrees);  // across the width
  scene_.camera.fov = 2 * math::atan(tan_half * size.y / size.x);
  vec3 eye(0);
  if (const Bounds bounds = scene_.bounds(); !bounds.empty()) {
    const vec3 extent = bounds.diagonal();
    const float widest = std::max(extent.x, extent.y);
    const float distance = (version0() ? widest : std::max(widest, extent.z)) / (2 * tan_half);
    eye = vec3(bounds.centre().x, bounds.centre().y, bounds.lower.z - distance);
  }
  if (!within_reach(eye)) throw Error(whole, fmt::format("the scene has no sensor; Mitsuba's lies beyond {:g} m", farthest));
  scene_.camera.to_world = Transform::translate(eye) * Transform::scale({-1, 1, 1});
  warn(whole, fmt::format("the scene has no sensor: Mitsuba's own, at ({:.4g}, {:.4g}, {:.4g}), looking along +z, with a field "
                          "of view of 45 degrees",
                          eye.x, eye.y, eye.z));
}

void MitsubaReader::film(const Properties& sensor) {
  scene_.resolution = mitsuba_resolution;
  const auto films = sensor.objects({"film"});
  if (films.size() > 1) throw Error(films[1]->where(), "sensor: has two films; expected one");
  FilterShape filter = gaussian_filter(mitsuba_stddev);
  if (!films.empty()) {
    const Properties of = properties(*films[0]);
    scene_.resolution = {of.integer("width", mitsuba_resolution.x, 1, 65536),
                         of.integer("height", mitsuba_resolution.y, 1, 65536)};
    crop(of);
    if (in_lower_case(of.string("pixel_format", "rgb")).starts_with("luminance"))
      warn(of.where("pixel_format"), "film: 'pixel_format' is luminance; here the image has colours");
    for (const XmlElement* element : of.objects({"rfilter"})) filter = filter_of(properties(*element));
    of.ignore({"file_format", "component_format"});  // known names, however near others they are
    of.finish_but_for_others();
  }
  scene_.filter = make_pixel_filter(filter);
}

FilterShape MitsubaReader::filter_of(const Properties& of) const {
  constexpr float least = 0.01f, most = 32;
  const std::string type = of.type();
  FilterShape shape;
  if (type == "box") {
    shape.radius = vec2(of.number("radius", 0.5f, least, most));
  } else if (type == "tent") {
    shape = {.kind = FilterKind::triangle, .radius = vec2(of.number("radius", 1, least, most))};
  } else if (type == "gaussian") {
    shape = gaussian_filter(of.number("stddev", mitsuba_stddev, least, most / 4));
  } else if (type == "mitchell") {
    shape = {.kind = FilterKind::mitchell,
             .radius = vec2(2),
             .b = of.number("b", 1.0f / 3, -10, 10),  // written B and C
             .c = of.number("c", 1.0f / 3, -10, 10)};
  } else if (type == "catmullrom") {
    shape = {.kind = FilterKind::mitchell, .radius = vec2(2), .b = 0, .c = 0.5f};
  } else if (type == "lanczos") {
    const auto lobes = static_cast<float>(of.integer("lobes", 3, 1, 32));
    shape = {.kind = FilterKind::sinc, .radius = vec2(lobes), .tau = lobes};
  } else {
    throw Error(of.where(), fmt::format("film: {}", unknown_name("rfilter", type,
                                                                 std::vector<std::string>{"box", "tent", "gaussian", "mitchell",
                                                                                          "catmullrom", "lanczos"})));
  }
  of.finish();
  return shape;
}

// The window is in shares of the film; the file states it in pixels.
void MitsubaReader::crop(const Properties& of) {
  const ivec2 size = scene_.resolution;
  const int x = of.integer("crop_offset_x", 0, 0, size.x - 1), y = of.integer("crop_offset_y", 0, 0, size.y - 1);
  const int width = of.integer("crop_width", size.x - x, 1, size.x - x),
            height = of.integer("crop_height", size.y - y, 1, size.y - y);
  if (ivec2(width, height) == size) return;
  const auto share = [](int pixel, int all) { return static_cast<float>(pixel) / static_cast<float>(all); };
  scene_.crop = {share(x, size.x), share(x + width, size.x), share(y, size.y), share(y + height, size.y)};
  warn(of.where("crop_width"), "film: `etendue render` shows the part in the crop window, experiments the whole image");
}

// The image is that of one integrator, which says how long paths are.
void MitsubaReader::only_integrator(const XmlElement& element, bool& has_one) {
  if (std::exchange(has_one, true))
    approximate(element.where("type"), "another integrator beside the first", "the first");
  else
    integrator(element);
}

// Mitsuba counts the edges of a path: those of a path with one scattering event are two.
void MitsubaReader::integrator(const XmlElement& element) {
  const Nesting nesting(*this, element);
  const Properties of = properties(element);
  if (of.has("max_depth")) {
    const int edges = of.integer("max_depth", -1, -1, 1 << 20);
    if (edges >= 0) scene_.max_depth = std::max(edges - 1, 0);
  }
  bool has_inner = false;
  for (const XmlElement* inner : of.objects({"integrator"})) {
    if (!std::exchange(has_inner, true))
      integrator(*inner);
    else
      warn(inner->where("type"), "another integrator beside the first, whose image it is");
  }
  if (of.type() == "direct")
    scene_.max_depth = 1;
  else if (!is_one_of(all_light, of.type()) && !is_one_of(wrappers, of.type()))
    warn(element.where("type"),
         fmt::format("integrator '{}' is not one of Mitsuba's light transport; here every method computes all of it",
                     of.type()));
  if (of.boolean("hide_emitters", false)) hides_emitters_ = HiddenEmitters{of.where("hide_emitters"), of.title()};
  of.finish_but_for_others();
}

// Lights of no extent are not seen in any case.
void MitsubaReader::check_hidden_emitters(bool has_area_lights) {
  const auto is_environment = [](const Light& light) { return std::holds_alternative<EnvironmentLight>(light); };
  if (hides_emitters_ && (has_area_lights || std::ranges::any_of(scene_.lights, is_environment)))
    approximate(hides_emitters_->where, fmt::format("{}: 'hide_emitters' is not supported", hides_emitters_->integrator),
                "false: they are seen");
}

}  // namespace etendue
