#include "integrators/vcm.h"

#include "framework/core/parallel.h"
#include "integrators/path.h"
#include "integrators/vcm_camera_paths.h"

namespace etendue {

namespace {

// Pixels a side of a tile whose shadow rays are asked for together.
constexpr int tile_of_paths = 8;

class Vcm final : public Integrator {
 public:
  Vcm(const LightTraceParams& params, bool connect) : params_(params) {
    settings_.connect = connect;
    settings_.roulette_depth = params.roulette_depth;
    settings_.sampler = parse_sampler(params.sampler);
  }

  void prepare(RenderContext& context) override {
    settings_.max_depth = context.max_depth(params_.max_depth);
    const auto pixels = static_cast<std::uint32_t>(context.resolution.x * context.resolution.y);
    settings_.paths = params_.paths > 0 ? static_cast<std::uint32_t>(params_.paths) : pixels;
    const Scene& scene = context.scene;
    specular_ = std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& m) { return has_specular(m); });
    hidden_caustics_ = context.needs.caustic_map && std::any_of(scene.lights.begin(), scene.lights.end(), is_delta);
  }

  void iteration(RenderContext& context, std::uint32_t index, Film& film) override {
    {
      const auto timed = context.phases.measure("emit");
      light_paths_.trace(context, settings_, index, settings_.connect);
    }
    splats_.assign(static_cast<std::size_t>(context.resolution.x) * context.resolution.y, dvec3(0));
    light_paths_.add_splats(splats_);
    const auto timed = context.phases.measure("trace");
    parallel_tiles(context.resolution, tile_of_paths, [&](const Tile& tile) {
      CameraPaths paths(context, settings_, light_paths_);
      std::array<Rgb, tile_of_paths * tile_of_paths> radiance{};
      auto value = radiance.begin();
      for_pixels(tile, [&](ivec2 pixel) { paths.trace(pixel, index, *value++); });
      paths.finish();
      value = radiance.begin();
      for_pixels(tile, [&](ivec2 pixel) {
        const dvec3& splat = splats_[static_cast<std::size_t>(pixel.y) * context.resolution.x + pixel.x];
        film.add(pixel, *value++ + Rgb(splat), index);
      });
    });
  }

  Expectation expectation() const override {
    if (!settings_.connect && specular_)
      return {Bias::biased, -1, 1,
              "specular surfaces are black: the method cannot sample paths that end on one before the camera"};
    if (hidden_caustics_)
      return {Bias::biased, -1, 1,
              "caustics of point, spot and directional lights are black where specular surfaces show them"};
    return {Bias::unbiased, -1, 0, ""};
  }

 private:
  static bool is_delta(const Light& light) {
    return !std::holds_alternative<AreaLight>(light) && !std::holds_alternative<EnvironmentLight>(light);
  }

  LightTraceParams params_;
  VcmSettings settings_;
  bool specular_ = false, hidden_caustics_ = false;
  LightPaths light_paths_;
  std::vector<dvec3> splats_;
};

}  // namespace

IntegratorEntry light_trace_entry() {
  return {"light-trace", "particles from the lights joined to the camera", list_params<LightTraceParams>(),
          [](const ParamMap& map) { return std::make_unique<Vcm>(read_params<LightTraceParams>(map, "light-trace"), false); }};
}

IntegratorEntry bdpt_entry() {
  return {"bdpt", "bidirectional path tracing: all ways to join paths from the camera and from the lights",
          list_params<BdptParams>(),
          [](const ParamMap& map) { return std::make_unique<Vcm>(read_params<BdptParams>(map, "bdpt"), true); }};
}

}  // namespace etendue
