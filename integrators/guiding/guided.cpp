#include "integrators/guiding/guided.h"

#include "framework/core/parallel.h"
#include "integrators/guiding/guided_paths.h"

#include <optional>

namespace etendue {

namespace {

constexpr std::size_t tiles_a_band = 256;  // whose records are kept at once

class Guided final : public Integrator {
 public:
  explicit Guided(const GuidedParams& params) : params_(params) {}

  void prepare(RenderContext& context) override {
    if (has_signed_filter(context) && params_.combination == BlockCombination::last)
      throw Error(
          "guided: combination = last: a pixel's last samples may weigh nothing under a filter with negative parts; "
          "expected mean or inverse-variance, or another filter than mitchell, sinc and their kin");
    context.choose_lights_by(params_.lights);
    settings_ = {context.max_depth(params_.max_depth), params_.roulette_depth, parse_mis(params_.mis)};
    tree_.emplace(context.bounds, SdTreeOptions{.split = static_cast<float>(params_.split),
                                                        .rho = params_.flux,
                                                        .stochastic = params_.spatial_filter == SpatialFilter::stochastic,
                                                        .learn_share = params_.fraction == BsdfFraction::learnt,
                                                        .bsdf_share = params_.bsdf_fraction});
    blocks_.emplace(context.resolution, params_.combination, has_signed_filter(context));
  }

  void iteration(RenderContext& context, std::uint32_t index, Film& film) override;

  Expectation expectation() const override {
    return {Bias::unbiased, -1, 0, "blocks have weights from the samples of other pixels [Mueller2019]"};
  }

 private:
  void trace_tile(const RenderContext& context, const Tile& tile, std::uint32_t index, Film& film,
                  std::vector<GuideRecord>& records);

  GuidedParams params_;
  PathSettings settings_;
  std::optional<SdTree> tree_;
  std::optional<ImageBlocks> blocks_;
  std::vector<std::vector<GuideRecord>> records_ = std::vector<std::vector<GuideRecord>>(tiles_a_band);  // per tile of a band
};

void Guided::iteration(RenderContext& context, std::uint32_t index, Film& film) {
  if (index > 0 && ImageBlocks::begins_block(index)) {
    const auto timed = context.phases.measure("learn");
    tree_->refine(ImageBlocks::block_samples(ImageBlocks::block_of(index - 1)));
  }
  const std::size_t count = path_tile_count(context.resolution);
  for (std::size_t first = 0; first < count; first += tiles_a_band) {
    const std::size_t some = std::min(tiles_a_band, count - first);
    {
      const auto timed = context.phases.measure("trace");
      parallel_for(some, 1, [&](std::size_t i) {
        records_[i].clear();
        trace_tile(context, path_tile(context.resolution, first + i), index, film, records_[i]);
      });
    }
    const auto timed = context.phases.measure("learn");
    tree_->learn(std::span(records_).first(some));
  }
  blocks_->end_sample(index, film);
}

void Guided::trace_tile(const RenderContext& context, const Tile& tile, std::uint32_t index, Film& film,
                        std::vector<GuideRecord>& records) {
  static thread_local std::vector<PathSample> paths;
  camera_paths(context, tile, params_.sampler, index, paths);
  trace_guided_paths(context, paths, settings_, *tree_, records);
  auto path = paths.begin();
  for_pixels(tile, [&](ivec2 pixel) {
    film.add(pixel, path->radiance, index);  // counts what is not finite
    blocks_->add(pixel, (path++)->radiance, sample_weight(context, pixel, index));
  });
}

}  // namespace

IntegratorEntry guided_entry() {
  return integrator_entry<Guided, GuidedParams>("guided", "path guiding by a spatio-directional tree", 300);
}

}  // namespace etendue
