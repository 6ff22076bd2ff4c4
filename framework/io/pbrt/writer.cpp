#include "framework/io/pbrt/writer.h"

#include "framework/core/check.h"

#include <algorithm>

namespace etendue {

namespace pbrt_text {

std::string number_text(float value) { return fmt::format("{}", value == 0 ? 0.0f : value); }

std::string bracketed(std::initializer_list<float> values) {
  std::string text = "[";
  for (const float value : values) text += " " + number_text(value);
  return text + " ]";
}

std::string in_quotes(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + '"';
}

std::string transform_text(const Transform& t, const vec3& origin) {
  std::string text = "Transform [";
  for (const vec3& column : {t.vector(vec3(1, 0, 0)), t.vector(vec3(0, 1, 0)), t.vector(vec3(0, 0, 1))})
    text += fmt::format(" {} {} {} 0", number_text(column.x), number_text(column.y), number_text(column.z));
  const vec3 offset = t.point(vec3(0)) + origin;
  return text + fmt::format(" {} {} {} 1 ]\n", number_text(offset.x), number_text(offset.y), number_text(offset.z));
}

}  // namespace pbrt_text

using namespace pbrt_text;

namespace {

// The matrix whose inverse, as Transform::from_matrix makes it, is the camera's linear part: the transpose of a rotation, else
// the inverse at hand.
Transform world_to_camera(const Camera& camera) {
  const vec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mat4 transposed(1), inverted(1);
  const Transform inverse = camera.to_world.inverse();
  for (int c = 0; c < 3; ++c) {
    inverted[c] = vec4(inverse.vector(axes[c]), 0);
    const vec3 column = camera.to_world.vector(axes[c]);
    for (int r = 0; r < 3; ++r) transposed[r][c] = column[r];
  }
  if (const auto turned = Transform::from_matrix(transposed)) {
    const Transform back = turned->inverse();
    if (std::all_of(std::begin(axes), std::end(axes),
                    [&](const vec3& axis) { return back.vector(axis) == camera.to_world.vector(axis); }))
      return *turned;
  }
  const auto other = Transform::from_matrix(inverted);
  CHECK(other.has_value());
  return *other;
}

// The reader takes the scale out of a parallel view: this is one that it leaves as it is, but for the last bit the same.
Camera as_read(Camera camera) {
  for (int round = 0; camera.is_parallel() && round < 8; ++round) {
    const float scale = camera.to_world.similarity_scale().value_or(1);
    if (scale == 1) break;
    camera.to_world = camera.to_world * Transform::scale(vec3(1 / scale));
    camera.half_width *= scale;
  }
  return camera;
}

}  // namespace

void PbrtWriter::warn(const std::string& what) {
  if (std::find(warnings_.begin(), warnings_.end(), what) == warnings_.end()) warnings_.push_back(what);
}

std::string PbrtWriter::file(const std::string& name, std::string_view bytes) {
  const std::string path = folder_ + "/" + name;
  take_(path, bytes);
  return "[ " + in_quotes(path) + " ]";
}

std::string PbrtWriter::camera_text() {
  const Camera camera = as_read(scene_.camera);
  const vec3 eye = camera.to_world.point(vec3(0)) + scene_.origin;
  // The eye stands in a transform of its own: as part of a matrix its place would be rounded.
  std::string text = transform_text(world_to_camera(camera)) +
                     fmt::format("Translate {} {} {}\n", number_text(-eye.x), number_text(-eye.y), number_text(-eye.z));
  const vec2 size(scene_.resolution);
  if (camera.is_parallel()) {
    const float y = std::max(size.y / size.x, 1.0f);
    const float top = number_read_as(
        camera.half_width, [y](float top) { return top / y; }, [y](float width) { return width * y; });
    const float right = camera.half_width * std::max(size.x / size.y, 1.0f);
    return text + "Camera \"orthographic\" \"float screenwindow\" " + bracketed({-right, right, -top, top}) + "\n";
  }
  constexpr float degree = pi / 180;
  text += "Camera \"perspective\" \"float fov\" " +
          bracketed({number_read_as(
              camera.fov, [](float degrees) { return degrees * degree; }, [](float radians) { return radians / degree; })});
  if (camera.lens_radius > 0) text += " \"float lensradius\" " + bracketed({camera.lens_radius});
  return text + " \"float focaldistance\" " + bracketed({camera.focal_distance}) + "\n";
}

void PbrtWriter::add_instances() {
  std::map<std::uint32_t, std::string> names;
  std::string placed;
  for (std::size_t i = 1; i < scene_.instances.size(); ++i) {
    const Instance& instance = scene_.instances[i];
    const Object& object = scene_.objects[instance.object];
    if (object.geometry.primitive_count() == 0) continue;
    const auto [name, is_new] = names.try_emplace(instance.object);
    if (is_new) {
      name->second = numbered("object");
      shapes_ += "ObjectBegin " + in_quotes(name->second) + "\n";
      add_object(object, vec3(0));
      shapes_ += "ObjectEnd\n";
    }
    placed += "AttributeBegin\n  " + transform_text(instance.to_world, scene_.origin) + "  ObjectInstance " +
              in_quotes(name->second) + "\nAttributeEnd\n";
  }
  shapes_ += placed;
}

std::string PbrtWriter::filter_text() const {
  const FilterShape filter = scene_.filter ? scene_.filter->shape() : FilterShape{};
  const auto number = [](const char* name, float value) { return fmt::format(" \"float {}\" {}", name, bracketed({value})); };
  std::string text = "PixelFilter " + in_quotes(names_of(filter.kind)[static_cast<std::size_t>(filter.kind)]) +
                     number("xradius", filter.radius.x) + number("yradius", filter.radius.y);
  if (filter.kind == FilterKind::gaussian) text += number("sigma", filter.sigma);
  if (filter.kind == FilterKind::mitchell) text += number("B", filter.b) + number("C", filter.c);
  if (filter.kind == FilterKind::sinc) text += number("tau", filter.tau);
  return text + "\n";
}

PbrtText PbrtWriter::write() {
  std::string text = "# Written by etendue.\n";
  if (scene_.max_depth) text += fmt::format("Integrator \"path\" \"integer maxdepth\" [ {} ]\n", *scene_.max_depth);
  text += filter_text();
  text += fmt::format("Film \"rgb\" \"integer xresolution\" [ {} ] \"integer yresolution\" [ {} ]\n", scene_.resolution.x,
                      scene_.resolution.y);
  if (const auto& crop = scene_.crop)
    text.insert(text.size() - 1, " \"float cropwindow\" " + bracketed({(*crop)[0], (*crop)[1], (*crop)[2], (*crop)[3]}));
  text += camera_text() + "\nWorldBegin\n";
  for (const Light& light : scene_.lights) add_light(light);
  add_instances();
  add_object(scene_.objects[0], scene_.origin);
  for (const InfinitePlane& plane : scene_.planes) add_plane(plane);
  if (!scene_.reliefs.empty()) warn("bump and normal maps: not written; surfaces are smooth");
  for (const Light& light : scene_.lights)
    if (const auto* area = std::get_if<AreaLight>(&light); area != nullptr && area->texture != no_id)
      warn("images on lights: not written; such lights are even, at the radiance that the image is multiplied by");
  if (scene_.closed_form)
    warn("its closed form (" + scene_.closed_form->source +
         ") is no part of a file: errors are measured against a rendered reference");
  return {text + looks_ + shapes_, std::move(warnings_)};
}

PbrtText write_pbrt(const Scene& scene, const std::string& folder, const TakeFile& take) {
  return PbrtWriter(scene, folder, take).write();
}

}  // namespace etendue
