#include "framework/io/mitsuba/reader.h"

#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

namespace etendue {

namespace {

constexpr std::string_view before_0_4 =
    "files of Mitsuba before 0.4 are not read: its upgrade to 0.4 mirrors cameras and gives them the field of view of the "
    "shorter side, and renames luminaires, their intensity to radiance or irradiance, intensityScale and focusDepth";

bool is_sensor(const XmlElement& element) { return element.tag == "sensor" || element.tag == "camera"; }

// The latest time at which a sensor in an element sees the scene, and infinity where one sees it for a while.
float latest_view(const XmlElement& element) {
  float open = 0, close = 0, latest = 0;
  for (const XmlElement& child : element.children) {
    latest = std::max(latest, latest_view(child));
    const std::string name = is_sensor(element) ? snake_case(child.value("name")) : "";
    if (name == "shutter_open" || name == "shutter_close")
      (name == "shutter_open" ? open : close) = read_number(child, "value");
  }
  return close > open ? infinity : std::max(latest, open);
}

// Up to its first time Mitsuba takes an animation for its first transform.
bool stands_still(const XmlElement& animation, float until) {
  return std::ranges::all_of(animation.children, [&](const XmlElement& key) {
    return animation.children.size() == 1 || (key.find("time") && read_number(key, "time") >= until);
  });
}

// Throws Error where an element stands in it that only versions before 0.4 have.
void refuse_old_elements(const XmlElement& element) {
  if (element.tag == "camera" || element.tag == "luminaire")
    throw Error(element.where(), fmt::format("{}: the file states no version, and {}", element.tag, before_0_4));
  for (const XmlElement& child : element.children) refuse_old_elements(child);
}

}  // namespace

Scene MitsubaReader::read() {
  read_version();
  tell_of_transforms(tree_.root(), latest_view(tree_.root()));
  properties(tree_.root());  // every element and reference is known
  find_camera();
  for (const XmlElement& child : tree_.root().children) read_child(child);
  finish();
  return std::move(scene_);
}

void MitsubaReader::read_version() {
  const XmlElement& root = tree_.root();
  const std::string version = root.value("version");
  if (version.empty()) return refuse_old_elements(root);
  const std::string told = fmt::format("scene: version {}; expected 0.4 to 3", quote(version));
  if (version[0] < '0' || version[0] > '9') throw Error(root.where("version"), told);
  version_ = std::atoi(version.c_str());
  if (version_ > 3) throw Error(root.where("version"), told);
  const std::size_t point = version.find('.');
  const int minor = point == std::string::npos ? 0 : std::atoi(version.c_str() + point + 1);
  if (version_ == 0 && minor < 4) throw Error(root.where("version"), fmt::format("{}; {}", told, before_0_4));
}

// The camera is the first sensor, and before version 2 the last.
void MitsubaReader::find_camera() {
  for (const XmlElement& child : tree_.root().children) {
    const XmlElement& meant = child.tag == "ref" ? ids_.find(child) : child;
    if (is_sensor(meant) && (!camera_ || version0())) camera_ = &meant;
  }
}

void MitsubaReader::read_child(const XmlElement& child) {
  const Nesting nesting(*this, child);
  if (child.tag == "ref") {
    read_child(ids_.find(child));
  } else if (child.tag == "shape") {
    shape(child, world_);
  } else if (child.tag == "emitter" || child.tag == "luminaire") {
    emitter(child);
  } else if (is_sensor(child)) {
    sensor(child);
  } else if (child.tag == "integrator") {
    only_integrator(child, has_integrator_);
  }
  // Others are read where something refers to them.
}

void MitsubaReader::finish() {
  const Location whole{files_.first_file()};
  std::vector<Emission> emissions;
  scene_.objects[0] = world_.parts[0].builder.take(&emissions);
  if (!camera_) default_sensor(whole);
  if (version0() && !has_integrator_) {
    warn(whole, "the scene has no integrator: direct light alone, as in Mitsuba 0.x");
    scene_.max_depth = 1;
  }
  if (scene_.objects[0].shapes.empty() && !scene_.has_instances()) warn(whole, "the scene has no shapes");
  if (emissions.empty() && scene_.lights.empty()) warn(whole, "the scene has no lights");
  check_hidden_emitters(!emissions.empty());
  warn_of_clipping();
  if (one_sided_ > 0)
    warn(*first_one_sided_, fmt::format("{} a bsdf without twosided, which is black from behind in Mitsuba; here "
                                        "both sides are alike",
                                        one_sided_ == 1 ? "one shape has" : fmt::format("{} shapes have", one_sided_)));
  for (std::string& warning : files_.warnings()) scene_.warnings.push_back(std::move(warning));
  for (std::string& warning : left_out_.warnings()) scene_.warnings.push_back(std::move(warning));
  if (const Bounds bounds = scene_.bounds();
      scene_.has_instances() && !bounds.empty() && !(within_reach(bounds.lower) && within_reach(bounds.upper)))
    throw Error(whole, fmt::format("an instance lies beyond {:g} m", farthest));
  finish_scene(scene_, emissions);
}

void MitsubaReader::have_no_effect(const Properties& of, std::initializer_list<std::string_view> names, std::string_view why) {
  for (const std::string_view name : names)
    if (of.has(name)) warn(of.where(name), fmt::format("{}: '{}' has no effect, {}", of.title(), name, why));
}

void MitsubaReader::approximate(const Location& where, const std::string& what, const std::string& taken) {
  files_.approximations().take(where, what, taken);
}

void MitsubaReader::leave_out_media(const Properties& of) {
  of.ignore({"interior", "exterior"});
  auto media = of.objects({"medium", "subsurface"});
  for (const std::string_view name : {"interior", "exterior"})
    if (const XmlElement* medium = of.element(name)) media.push_back(medium);
  for (const XmlElement* medium : media)
    approximate(medium->where(), fmt::format("a {} is not supported: there are no participating media", medium->tag),
                "nothing: what it would absorb and scatter goes straight on");
}

void MitsubaReader::tell_of_transforms(const XmlElement& element, float until) {
  if (element.tag == "animation" && !stands_still(element, until))
    approximate(element.where(), "an animation is not supported: nothing moves", "its earliest transform, without blur");
  if (element.tag == "lookat" && !element.find("up") && version0())
    warn(element.where(), "lookat: without 'up' it is rolled about the view as in Mitsuba 3, not as in earlier versions");
  for (const XmlElement& child : element.children) tell_of_transforms(child, until);
}

std::string MitsubaReader::file_name(const Properties& of) {
  const std::string name = of.string("filename", "");
  if (name.empty()) throw Error(of.where(), fmt::format("{}: 'filename' is missing", of.title()));
  return name;
}

SceneFiles::File MitsubaReader::read_file_of(const Properties& of) {
  const std::string name = file_name(of);
  return files_.read(name, tree_.looked_for_beside(name, *of.element().file), of.where("filename"));
}

RgbImage MitsubaReader::read_image_of(const Properties& of, Encoding encoding) {
  const std::string name = file_name(of);
  RgbImage image = files_.image(name, tree_.looked_for_beside(name, *of.element().file), of.where("filename"), encoding);
  if (image.not_finite > 0)
    warn(of.where("filename"),
         fmt::format("'{}' holds NaN or infinity in {} texels, which are taken as 0", name, image.not_finite));
  return image;
}

std::vector<MitsubaSupport> mitsuba_support() {
  std::vector<MitsubaSupport> all;
  const auto add = [&](std::string_view element, const auto& types) {
    for (const auto& type : types) all.push_back({element, type.name, type.how});
  };
  add("shape", MitsubaReader::shape_types());
  add("bsdf", MitsubaReader::bsdf_types());
  add("texture", MitsubaReader::texture_types());
  add("emitter", MitsubaReader::emitter_types());
  add("sensor", MitsubaReader::sensor_types());
  return all;
}

Scene parse_mitsuba(std::string text, const std::string& path, const SceneReading& reading) {
  return MitsubaReader(std::move(text), path, reading).read();
}

Scene read_mitsuba(const std::string& path, const SceneReading& reading) {
  return parse_mitsuba(read_file(path), path, reading);
}

}  // namespace etendue
