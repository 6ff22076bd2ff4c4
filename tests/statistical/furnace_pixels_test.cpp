// White furnaces pixel by pixel: where every pixel has the same known radiance, an error that the mean over the image hides
// (too dark at an edge, too bright in a corner) shows.
//
// Unbiased methods: a z-test per pixel over independent seeds, all pixels of a furnace and method together at one false alarm
// in a thousand runs (Sidak). A pixel's standard error is its own or that of all pixels together, whichever is larger: the
// scatter of few samples of skewed values says little of their error. Others: each pixel is off by no more than the bias that
// the method declares for smooth scenes, and its noise. Where walls meet, a density estimate divides photons by a disc of which
// half is missing at the edge and three quarters at a corner, or makes up for it; in pixels at edges it may be darker by as
// much, never brighter.
#include "tests/sealed_checks.h"

namespace etendue {
namespace {

using testing::sealed_methods;
using testing::SealedMethod;

constexpr int replicates = 8;
constexpr ivec2 size{12, 12};
constexpr double edge_loss = 0.5;  // of a density estimate, in a pixel at an edge; at most half of its photons are lost there

struct Furnace {
  const char* name;
  double radiance;
  bool specular;   // not for light that is traced to the camera alone
  bool has_edges;  // where walls meet
  std::function<Scene()> make;
};

Scene glowing(const char* name, const MeshData& walls, const Material& material = Diffuse{Rgb(0.5f)}) {
  SceneBuilder builder(name);
  builder.mesh(walls, builder.material(material), Rgb(1));
  testing::see_from_inside(builder, {});
  Scene scene = builder.finish();
  for (Light& light : scene.lights) std::get<AreaLight>(light).two_sided = true;
  return scene;
}

std::vector<Furnace> furnaces() {
  return {{"glowing sphere", 2, false, false, [] { return load_scene("builtin:furnace"); }},
          {"glowing box", 2, false, true, [] { return glowing("glowing box", testing::box_walls(2)); }},
          {"glowing icosphere", 2, false, false, [] { return glowing("glowing icosphere", testing::icosphere(1, 2, false)); }},
          {"glowing mirrors", 5, true, false,
           [] { return glowing("glowing mirrors", testing::box_walls(2), Conductor{.tint = Rgb(0.8f), .ideal = true}); }},
          {"lossless objects", 1, true, false, [] { return load_scene("builtin:white-furnace"); }}};
}

struct PixelTest {
  std::vector<double> mean, error;  // of the green channel, over replicates
  Expectation expectation;
};

PixelTest measure(const Scene& scene, const SealedMethod& method, std::uint32_t iterations) {
  std::vector<std::vector<double>> values(static_cast<std::size_t>(size.x) * size.y);
  PixelTest test;
  for (int seed = 1; seed <= replicates; ++seed) {
    testing::RenderOptions options;
    options.params = method.params;
    options.iterations = iterations;
    options.resolution = size;
    options.seed = static_cast<std::uint64_t>(seed);
    const auto rendered = testing::render(scene, method.name, options);
    EXPECT_EQ(rendered.non_finite, 0u) << method.name;
    test.expectation = rendered.expectation;
    for (std::size_t i = 0; i < values.size(); ++i) values[i].push_back(rendered.image.pixels[i].y);
  }
  for (const auto& v : values) {
    test.mean.push_back(mean(v));
    test.error.push_back(sample_sd(v) / std::sqrt(double(replicates)));
  }
  double squares = 0;
  for (const double e : test.error) squares += e * e / static_cast<double>(test.error.size());
  for (double& e : test.error) e = std::max(e, std::sqrt(squares));
  return test;
}

// Does the pixel, or one beside it, see surfaces of which the normals differ by more than 45 degrees?
bool sees_edge(const Scene& scene, const RayQuery& rays, ivec2 pixel) {
  std::optional<vec3> first;
  for (int k = 0; k < 49; ++k) {
    const vec2 film = vec2(pixel - 1) + 0.5f * vec2(k % 7, k / 7);
    const Ray ray = scene.camera.ray(size, film, vec2(0.5f));
    const Hit hit = rays.closest(ray);
    if (!hit) continue;
    const vec3 normal = scene.surface_at(ray, hit).normal;
    if (!first) first = normal;
    if (std::abs(glm::dot(*first, normal)) < 0.7f) return true;
  }
  return false;
}

void expect_even(const Furnace& furnace, const SealedMethod& method, std::uint32_t rounds = 1) {
  const Scene scene = furnace.make();
  const PixelTest test = measure(scene, method, rounds * method.iterations);
  const double level = sidak_level(1e-3, test.mean.size());
  const double limit = student_t_quantile(1 - level / 2, (replicates - 1) * static_cast<double>(test.mean.size()));
  const double allowed = test.expectation.bias == Bias::unbiased ? 0 : test.expectation.bias_bound;
  const auto rays = find_ray_structure("binned-sah", {}).make(scene, {});
  std::size_t failures = 0, worst = 0;
  double worst_excess = 0;
  for (std::size_t i = 0; i < test.mean.size(); ++i) {
    const double off = test.mean[i] / furnace.radiance - 1, noise = limit * test.error[i] / furnace.radiance;
    const ivec2 pixel(i % size.x, i / size.x);
    const double lost = furnace.has_edges && method.of_photons && off < 0 && sees_edge(scene, *rays, pixel) ? edge_loss : 0;
    if (std::abs(off) <= allowed + lost + noise + 1e-5) continue;
    ++failures;
    if (std::abs(off) - noise > worst_excess) {
      worst_excess = std::abs(off) - noise;
      worst = i;
    }
  }
  const std::string subject = std::string(furnace.name) + ", " + method.name + method.variant;
  if (testing::prints_leaks())
    std::printf("%-60s %3zu of %zu pixels off, worst by %.3f beyond its noise, declared %.3f\n", subject.c_str(), failures,
                test.mean.size(), worst_excess, allowed);
  EXPECT_EQ(failures, 0u) << subject << ": pixel (" << worst % size.x << ", " << worst / size.x << ") has " << test.mean[worst]
                          << " +- " << test.error[worst] << ", expected " << furnace.radiance << ", declared bias " << allowed;
}

// By default an iteration has as many light paths as pixels, and so few merge over half of an object.
std::vector<SealedMethod> furnace_methods() {
  std::vector<SealedMethod> methods = sealed_methods();
  for (SealedMethod& method : methods)
    if (method.name == "vcm") method.params = testing::params_of({{"neighbours", "1"}, {"paths", "6000"}});
  return methods;
}

// Whether light that is traced to the camera sees all of it.
bool applies(const Furnace& furnace, const SealedMethod& method) { return !(furnace.specular && method.name == "light-trace"); }

TEST(FurnacePixels, EveryMethodIsEvenWithinWhatItDeclares) {
  for (const Furnace& furnace : furnaces())
    for (const SealedMethod& method : furnace_methods())
      if (applies(furnace, method)) expect_even(furnace, method);
}

// A crate of 16 x 16 cells on the floor of a glowing box, against path tracing: what density estimates lose at so many edges is
// less than they declare, but for a photon map that divides by whole discs. What that loses falls with its radius. (Where the
// cells glow, too, light sampling has no variance, and its mean says little.)
TEST(CrateOfCells, MeanIsWithinWhatEachMethodDeclares) {
  SceneBuilder builder("crate");
  const auto wall = builder.material(Diffuse{Rgb(0.5f)});
  builder.mesh(testing::box_walls(1), wall, Rgb(1));
  constexpr float depth = 2.0f / 16, top = -1 + depth;
  for (int i = 1; i < 16; ++i) {
    const float x = -1 + depth * static_cast<float>(i);
    builder.mesh(quad({x, -1, -1}, {x, 1, -1}, {x, 1, top}, {x, -1, top}), wall);
    builder.mesh(quad({-1, x, -1}, {1, x, -1}, {1, x, top}, {-1, x, top}), wall);
  }
  builder.camera({0.1f, 0.05f, 0.3f}, {0.1f, 0.06f, -1}, 60, {48, 48});
  Scene scene = builder.finish();
  for (Light& light : scene.lights) std::get<AreaLight>(light).two_sided = true;
  const auto render = [&](const char* name, std::uint32_t iterations, const ParamMap& params = {}) {
    testing::RenderOptions options;
    options.params = params;
    options.resolution = {48, 48};
    options.iterations = iterations;
    return testing::render(scene, name, options);
  };
  const Image reference = render("path", 256).image;
  const auto hull = testing::params_of({{"edges", "hull"}}), merging = testing::params_of({{"neighbours", "1"}});
  for (const auto& [name, params] : std::vector<std::pair<const char*, ParamMap>>{
           {"photon-map", hull}, {"photon-cache", {}}, {"sppm", {}}, {"vcm", merging}}) {
    const auto rendered = render(name, 64, params);
    const double off = bias(rendered.image, reference);
    ::testing::Test::RecordProperty(name, std::to_string(off));
    EXPECT_LE(std::abs(off), rendered.expectation.bias_bound) << name;
  }
  const double few = bias(render("photon-map", 12, testing::params_of({{"photons", "50000"}})).image, reference);
  const double many = bias(render("photon-map", 12, testing::params_of({{"photons", "800000"}})).image, reference);
  ::testing::Test::RecordProperty("discs", std::to_string(few) + ", " + std::to_string(many));
  EXPECT_LT(std::abs(many), 0.5 * std::abs(few));
}

// Photons are as many as by default, and noise is low: few caustic photons blur in the gaps between the lossless objects (by 28
// % of the radiance with 5,000 of them).
TEST(LongFurnacePixels, EveryMethodIsEvenWithinWhatItDeclares) {
  for (const Furnace& furnace : furnaces())
    for (SealedMethod method : furnace_methods()) {
      method.params.erase("caustic_photons");
      if (applies(furnace, method)) expect_even(furnace, method, 16);
    }
}

}  // namespace
}  // namespace etendue
