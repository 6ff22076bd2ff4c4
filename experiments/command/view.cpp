#include "experiments/command/rendering.h"

#include "framework/core/error.h"
#include "framework/io/object_builder.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace etendue {

namespace {

const Location camera_option{"--camera"};
constexpr const char* expected_view =
    "the name of a camera of the file, or \"EYE TARGET [UP] [FOV]\", such as \"0,1,4 0,1,0 40\", with points as "
    "x,y,z and FOV in 0.001 .. 179.9 degrees";

std::optional<vec3> point_of(const std::string& word) {
  const auto numbers = mapped(split(word, ","), parse_number);
  if (numbers.size() != 3 || !numbers[0] || !numbers[1] || !numbers[2]) return std::nullopt;
  const vec3 point(dvec3(*numbers[0], *numbers[1], *numbers[2]));
  return is_finite(point) ? std::optional(point) : std::nullopt;
}

void look_at(Scene& scene, const std::string& text, const std::vector<vec3>& points, std::optional<double> fov) {
  for (int i = 0; i < 2; ++i)
    if (!within_reach(points[i]))
      throw Error(camera_option, fmt::format("'{}': {} lies beyond {:g} m", text, i == 0 ? "the eye" : "the target", farthest));
  const vec3 up = points.size() > 2 ? points[2] : vec3(0, 1, 0);
  const auto view = Transform::look_at(points[0] - scene.origin, points[1] - scene.origin, up);
  if (!view) throw Error(camera_option, fmt::format("'{}': eye and target coincide, or the view is along up", text));
  const bool mirrored = view->swaps_handedness() != scene.camera.to_world.swaps_handedness();
  const float angle = fov ? static_cast<float>(*fov) * pi / 180 : scene.camera.is_parallel() ? pi / 4 : scene.camera.fov;
  scene.crop.reset();  // of the file's own view
  if (scene.closed_form)
    scene.warnings.push_back(
        fmt::format("--camera: the closed form ({}) holds for the scene's own view; no error of this one is "
                    "told, but by --error against a rendered reference",
                    scene.closed_form->source));
  scene.closed_form.reset();
  scene.camera = {.to_world = mirrored ? *view * Transform::scale({-1, 1, 1}) : *view, .fov = angle};
}

Tile window_in_pixels(const std::array<double, 4>& bounds, ivec2 resolution, const Location& where) {
  constexpr double rounding = 1e-4;  // of a pixel: shares of pixels are not exact
  const auto up = [](double x) { return static_cast<int>(std::ceil(x - rounding)); };
  const dvec2 size = std::ranges::any_of(bounds, [](double b) { return b > 1; }) ? dvec2(1) : dvec2(resolution);
  const Tile window{{up(bounds[0] * size.x), up(bounds[2] * size.y)}, {up(bounds[1] * size.x), up(bounds[3] * size.y)}};
  const bool is_part = window.begin.x >= 0 && window.begin.y >= 0 && window.begin.x < window.end.x &&
                       window.begin.y < window.end.y && window.end.x <= resolution.x && window.end.y <= resolution.y;
  if (!is_part)
    throw Error(where, fmt::format("{:g} {:g} {:g} {:g} is no part of {} x {} pixels; expected X0 X1 Y0 Y1 in shares of the "
                                   "image, or in pixels, with X0 < X1 and Y0 < Y1",
                                   bounds[0], bounds[1], bounds[2], bounds[3], resolution.x, resolution.y));
  return window;
}

}  // namespace

void set_camera(Scene& scene, const std::string& text) {
  std::vector<std::string> names;
  for (const NamedCamera& known : scene.cameras) {
    names.push_back(known.name);
    if (known.name != text) continue;
    scene.camera = known.camera;
    scene.resolution = known.resolution;
    scene.crop = known.crop;
    scene.filter = known.filter;
    return;
  }
  std::istringstream words(text);
  std::vector<vec3> points;
  std::optional<double> fov;
  bool is_view = true;
  for (std::string word; words >> word;) {
    const auto point = point_of(word);
    const auto number = parse_number(word);
    is_view = is_view && !fov && (point ? points.size() < 3 : number && *number >= 1e-3 && *number <= 179.9);
    if (point) points.push_back(*point);
    if (!point) fov = number;
  }
  if (is_view && points.size() >= 2) return look_at(scene, text, points, fov);
  if (names.empty() || text.find(',') != std::string::npos)
    throw Error(camera_option, fmt::format("'{}'; expected {}", text, expected_view));
  throw Error(camera_option, unknown_name("camera", text, names));
}

Tile choose_window(const std::vector<double>& crop, const char* needs_all, const Scene& scene, ivec2 resolution) {
  const Location option{"--crop"};
  if (crop.empty()) {
    if (needs_all || !scene.crop) return {};
    const auto& [x0, x1, y0, y1] = *scene.crop;
    return window_in_pixels({x0, x1, y0, y1}, resolution, {scene.name});
  }
  if (needs_all) throw Error(option, fmt::format("{} takes the whole image; expected one of them", needs_all));
  if (crop.size() != 4) throw Error(option, "expected four numbers, X0 X1 Y0 Y1");
  return window_in_pixels({crop[0], crop[1], crop[2], crop[3]}, resolution, option);
}

}  // namespace etendue
