// Lights other than those of shapes.

#include "framework/core/elementary.h"
#include "framework/io/pbrt/writer.h"

namespace etendue {

using namespace pbrt_text;

namespace {

constexpr float degree = pi / 180;

std::string direction_text(const vec3& direction) {
  const vec3 to = direction_read_as(direction, [](const vec3& v) {
    const dvec3 exact(v);
    return vec3(exact / glm::length(exact));
  });
  return " \"point3 from\" [ 0 0 0 ] \"point3 to\" " + vector_text(to);
}

}  // namespace

std::string PbrtWriter::light_text(const PointLight& light) {
  return "LightSource \"point\" \"point3 from\" " + vector_text(light.position + scene_.origin) +
         rgb_text("I", light.intensity) + "\n";
}

std::string PbrtWriter::light_text(const SpotLight& light) {
  if (light.fade == SpotFade::linear)
    warn(
        "spots that fade evenly in the angle: pbrt's fade smoothly in its cosine; taken as such, which are brighter inside the "
        "rim and dimmer towards it");
  if (light.fade == SpotFade::quartic)
    warn(
        "spots that fade as in pbrt-v3: written as pbrt-v4's, which are up to 0.5 times their intensity brighter towards the "
        "rim");
  const float cone = number_read_as(
      light.cos_outer, [](float angle) { return math::cos(angle * degree); },
      [](float cosine) { return math::acos(cosine) / degree; });
  const float fading = number_read_as(
      light.cos_inner, [cone](float delta) { return math::cos((cone - delta) * degree); },
      [cone](float cosine) { return cone - math::acos(cosine) / degree; });
  const vec3 at = light.position + scene_.origin;
  return fmt::format("AttributeBegin\n  Translate {} {} {}\n  LightSource \"spot\"", number_text(at.x), number_text(at.y),
                     number_text(at.z)) +
         direction_text(light.direction) + rgb_text("I", light.intensity) + " \"float coneangle\" " + bracketed({cone}) +
         " \"float conedeltaangle\" " + bracketed({std::clamp(fading, 0.0f, cone)}) + "\nAttributeEnd\n";
}

std::string PbrtWriter::light_text(const DirectionalLight& light) {
  return "LightSource \"distant\"" + direction_text(light.direction) + rgb_text("L", light.irradiance) + "\n";
}

std::string PbrtWriter::light_text(const EnvironmentLight& light) {
  if (light.texels.empty()) return "LightSource \"infinite\"" + rgb_text("L", light.scale) + "\n";
  warn("environments with an equirectangular image: pbrt-v4 has none; written as version 3's \"mapname\"");
  return "AttributeBegin\n  " + transform_text(light.light_to_world) + "  LightSource \"infinite\" \"string mapname\" " +
         image_file("environment", light.size, light.texels, true) + rgb_text("L", light.scale) + "\nAttributeEnd\n";
}

// Those of shapes stand with their shapes; black ones emit nothing.
void PbrtWriter::add_light(const Light& light) {
  struct Text {
    PbrtWriter& writer;
    std::string operator()(const AreaLight&) const { return ""; }
    std::string operator()(const PointLight& l) const { return is_black(l.intensity) ? "" : writer.light_text(l); }
    std::string operator()(const SpotLight& l) const { return is_black(l.intensity) ? "" : writer.light_text(l); }
    std::string operator()(const DirectionalLight& l) const { return is_black(l.irradiance) ? "" : writer.light_text(l); }
    std::string operator()(const EnvironmentLight& l) const { return is_black(l.scale) ? "" : writer.light_text(l); }
  };
  looks_ += std::visit(Text{*this}, light);
}

}  // namespace etendue
