// Scenes that no one would model, by every integrator: numbers of a scene file replaced by extremes, scenes without light or
// without anything in view, images of one pixel. What a reader accepts is rendered without a crash, without a non-finite
// sample, and to the same bits at any number of threads.
#include "framework/core/sampler.h"
#include "framework/transport/area_light.h"
#include "framework/transport/light_sampling.h"
#include "tests/render_scene.h"
#include "tests/unit/io_pbrt_helpers.h"

#include <map>

namespace etendue {
namespace {

using testing::render;
using testing::Rendered;
using testing::RenderOptions;

ParamMap quick_params(const IntegratorEntry& entry) {
  const std::map<std::string, std::int64_t> fewer{{"photons", 500}, {"caustic_photons", 200}, {"samples", 32}};
  ParamMap params;
  for (const ParamInfo& info : entry.params)
    if (const auto found = fewer.find(info.name); found != fewer.end()) params[info.name] = {found->second, {}};
  return params;
}

void expect_sound(const Scene& scene, const IntegratorEntry& entry, ivec2 resolution, const std::string& what) {
  RenderOptions options{.params = quick_params(entry), .iterations = 2, .resolution = resolution, .threads = 1};
  const Rendered one = render(scene, entry.name, options);
  options.threads = 3;
  const Rendered three = render(scene, entry.name, options);
  EXPECT_EQ(one.hash, three.hash) << entry.name << what;
  EXPECT_EQ(one.non_finite, 0u) << entry.name << what;
  for (const dvec3& pixel : one.image.pixels) ASSERT_TRUE(std::isfinite(pixel.x + pixel.y + pixel.z)) << entry.name << what;
}

const std::string seen_from = "LookAt 0 -3 1  0 0 0.6  0 0 1\nCamera \"perspective\" \"float fov\" 50\nWorldBegin\n";

// Lights of every kind, and shapes of most materials; each is one part.
const std::vector<std::string> lights{
    "LightSource \"point\" \"point3 from\" [0 0 1.8] \"rgb I\" [3 3 3]\n",
    "LightSource \"spot\" \"point3 from\" [0 0 1.9] \"point3 to\" [0.1 0.2 0] \"rgb I\" [5 5 5] \"float coneangle\" 40\n",
    "LightSource \"distant\" \"point3 from\" [0.3 0.2 1] \"point3 to\" [0 0 0] \"rgb L\" [2 2 2]\n",
    "LightSource \"infinite\" \"rgb L\" [0.5 0.6 0.7] \"float scale\" 1\n",
    "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [8 7 6] Translate 0.4 0.3 1.5\n"
    "Shape \"sphere\" \"float radius\" 0.15 AttributeEnd\n",
    "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [4 4 4] \"bool twosided\" true Translate -0.6 0.3 1.2 Rotate 40 1 0 "
    "0\n"
    "Shape \"disk\" \"float radius\" 0.3 \"float innerradius\" 0.1 AttributeEnd\n"};
const std::vector<std::string> hostile_shapes{
    "Material \"diffuse\" \"rgb reflectance\" [0.7 0.2 0.2] Shape \"trianglemesh\" \"point3 P\" [-1 1 0 1 1 0 1 1 2 -1 1 2]\n"
    "\"integer indices\" [0 1 2 0 2 3] \"normal3 N\" [0 -1 0 0 -1 0.1 0.1 -1 0 0 -1 0]\n",
    "AttributeBegin Translate 0.4 0 0.35 Material \"dielectric\" \"float eta\" 1.5 Shape \"sphere\" \"float radius\" 0.3\n"
    "AttributeEnd\n",
    "AttributeBegin Translate -0.4 0 0.35 Material \"conductor\" \"rgb eta\" [0.2 0.9 1.1] \"rgb k\" [3.9 2.4 2.2]\n"
    "\"float roughness\" 0.2 Shape \"sphere\" \"float radius\" 0.3 AttributeEnd\n",
    "AttributeBegin Translate 0.1 -0.5 0.9 Scale 1 0.5 1 Material \"coateddiffuse\" \"rgb reflectance\" [0.4 0.5 0.6]\n"
    "\"float roughness\" 0.1 Shape \"cylinder\" \"float radius\" 0.15 \"float zmin\" 0 \"float zmax\" 0.4 AttributeEnd\n",
    "ObjectBegin \"o\" Shape \"trianglemesh\" \"point3 P\" [0 0 0 0.2 0 0 0 0.2 0 0 0 0.2] \"integer indices\" [0 1 2 0 3 1]\n"
    "ObjectEnd AttributeBegin Translate 0.2 0.5 0.8 Rotate 30 0 1 0 Scale 2 1 1 ObjectInstance \"o\" AttributeEnd\n",
    "AttributeBegin Translate 0 0 1 Material \"mirror\" Shape \"disk\" \"float radius\" 0.2 AttributeEnd\n"};
const std::string floor_of_scene =
    "Shape \"trianglemesh\" \"point3 P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] \"integer indices\" [0 1 2 0 2 3]\n";

class Hostile {
 public:
  explicit Hostile(std::uint64_t seed) : rng_(seed, 17) {}

  std::string scene() {
    std::string text = seen_from + any(lights) + any(lights) + floor_of_scene + any(hostile_shapes) + any(hostile_shapes);
    for (std::uint32_t changes = rng_.next() % 3 + 1; changes > 0; --changes) change_number(text);
    return text;
  }

 private:
  const std::string& any(const std::vector<std::string>& parts) { return parts[rng_.next() % parts.size()]; }

  void change_number(std::string& text) {
    static const std::vector<std::string> extremes{"0",    "-0",    "1e-30", "-1",    "1e-38",    "1e-45",  "1e10", "1e-10",
                                                   "1e12", "1e-15", "0.5",   "2",     "1e5",      "-1e5",   "90",   "180",
                                                   "1e8",  "1e-20", "1e30",  "3e38",  "-3e38",    "-1e9",   "1e6",  "1",
                                                   "1e-6", "1e-3",  "1e3",   "-1e12", "0.999999", "1.00001"};
    std::vector<std::pair<std::size_t, std::size_t>> numbers;  // begin and length
    for (std::size_t i = text.find("WorldBegin"); i < text.size(); ++i) {
      const std::size_t end = text.find_first_of(" ]\n", i);
      const bool begins = text[i - 1] == ' ' || text[i - 1] == '[';
      if (begins && (std::isdigit(text[i]) || text[i] == '-')) numbers.emplace_back(i, end - i);
    }
    const auto [begin, length] = numbers[rng_.next() % numbers.size()];
    text.replace(begin, length, any(extremes));
  }

  Pcg32 rng_;
};

TEST(HostileScenes, WhatIsAcceptedIsRendered) {
  std::uint64_t seed = 0;
  for (const IntegratorEntry& entry : integrators())
    for (int accepted = 0; accepted < 10; ++seed) {
      const std::string text = Hostile(seed).scene();
      Scene scene;
      if (!error_of([&] { scene = parse_pbrt(text, "s.pbrt"); }).empty()) continue;
      ++accepted;
      expect_sound(scene, entry, {5, 5}, ":\n" + text);
    }
}

TEST(HostileScenes, WithoutLightOrWithNothingInViewAreSound) {
  const std::string away = "LookAt 0 -3 1  0 -6 1  0 0 1\nCamera \"perspective\"\nWorldBegin\n";
  const std::string odd[] = {
      seen_from + triangle,       seen_from + lights[0], seen_from + lights[3], seen_from, away + lights[4] + floor_of_scene,
      away + lights[2] + triangle};
  for (const std::string& text : odd)
    for (const IntegratorEntry& entry : integrators()) expect_sound(parse_pbrt(text, "s.pbrt"), entry, {6, 6}, ":\n" + text);
}

TEST(HostileScenes, ImagesOfOnePixelAreSound) {
  for (const char* name : {"builtin:cornell-spheres", "builtin:keyhole"})
    for (const IntegratorEntry& entry : integrators())
      expect_sound(load_scene(name), entry, {1, 1}, std::string(" in ") + name);
}

TEST(HostileScenes, DevicesAreNoFiles) { EXPECT_ERROR(read_pbrt("/dev/zero"), "it is a device"); }

// Areas fit in single precision, but not their squares.
TEST(HostileScenes, LampsThatReachFarHaveAnArea) {
  const Scene scene = parse_pbrt(seen_from + floor_of_scene + "AreaLightSource \"diffuse\"\n" +
                                     "Shape \"trianglemesh\" \"point3 P\" [0 0 1e11 0 1e11 1e11 1e11 0 1e11]\n",
                                 "s.pbrt");
  const AreaLight& lamp = std::get<AreaLight>(scene.lights.at(0));
  EXPECT_FLOAT_EQ(AreaEmitter(scene, lamp).area(), 5e21f);
  const LightSampler lights(scene);
  const auto sample = lights.sample(vec3(0), 0.5f, vec2(0.5f));
  ASSERT_TRUE(sample.has_value());
  EXPECT_TRUE(is_finite(sample->radiance) && sample->pdf_solid_angle > 0 && std::isfinite(sample->pdf_solid_angle));
}

TEST(HostileScenes, BeyondSinglePrecisionAreRefused) {
  EXPECT_ERROR(world("Shape \"trianglemesh\" \"point3 P\" [0 0 0 1e13 0 0 0 1 0]"),
               "s.pbrt:3:1: Shape \"trianglemesh\": placed");
  EXPECT_ERROR(world("Translate 0 0 2e12 Shape \"sphere\""), "beyond 1e+12 m");
  EXPECT_ERROR(world("ObjectBegin \"o\" " + triangle + "ObjectEnd Translate 2e12 0 0 ObjectInstance \"o\""),
               "an instance lies beyond");
  EXPECT_ERROR(world("LightSource \"point\" \"point3 from\" [1e20 0 0]"), "'from' lies, placed, beyond");
  EXPECT_ERROR(world("LightSource \"infinite\" \"rgb L\" [1 2e12 1]"), "expected 1e+12 at most");
  EXPECT_ERROR(world("LightSource \"point\" \"rgb I\" [1e30 1e30 1e30] \"float scale\" 1e8"), "'I' is 1e+38; expected 1e+12");
  EXPECT_ERROR(world("LightSource \"spot\" \"rgb I\" [1 2e12 1]"), "'I' is 2e+12");
  EXPECT_ERROR(world("Material \"conductor\" \"rgb eta\" [1 1 2000]"), "expected 0 to 1000");
  EXPECT_ERROR(parse_pbrt("Translate 1e13 0 0 Camera \"perspective\"\nWorldBegin\n", "s.pbrt"), "s.pbrt:1:20: Camera");
}

}  // namespace
}  // namespace etendue
