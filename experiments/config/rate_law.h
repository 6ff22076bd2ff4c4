// A law that theory gives for a method's error in a region of a scene, as an experiment states it before it runs:
//
//   [[rates]]
//   method   = "photon-map final_gather=4"  # of this name, with these parameters among those the experiment sets
//   scene    = "builtin:edge"               # default: every scene (that has the region)
//   region   = "smooth"                     # default: the whole image
//   metric   = "mse"                        # mse | rmse | bias2 | variance; the last two need two seeds and their images
//   x        = "iterations"                 # iterations | time | a counter ("records", "photons_emitted", …)
//                                           # "records" are those that lie in the region, where a cache tells where they are
//   points   = "checkpoints"                # of each run; or "configurations": one from each run's end, all methods together
//   from     = 1000, to = 1e5               # the window of x that is fitted; default: all
//   model    = "power"                      # A x^e; or "plateau": A x^e + P
//   exponent = "-2/3"                       # e by theory
//   source   = "[Knaus2011] section 5"      # whose theory
//
// The log keeps the laws, the ratios (ratio_claim.h) and their regions in one line. The last such line counts, so that a window
// can be moved without running anything again.
#pragma once

#include "experiments/config/config_tree.h"
#include "experiments/config/method.h"
#include "experiments/config/ratio_claim.h"
#include "experiments/config/regions.h"

#include <limits>
#include <string>
#include <vector>

namespace etendue {

struct RateLaw {
  enum class Model : std::uint8_t { power, plateau };

  std::string method, scene, region;  // scene empty: every one; region empty: the whole image
  std::string metric = "mse", x = "iterations";
  bool across = false;  // the points are configurations
  double from = 0, to = std::numeric_limits<double>::max();
  Model model = Model::power;
  double exponent = 0;
  std::string exponent_text, source;

  bool needs_images() const { return metric == "bias2" || metric == "variance"; }
  bool operator==(const RateLaw&) const = default;
};

// Whether a method's label has the law's name and all of its parameters.
bool selects(const std::string& method, const std::string& label);

struct RateContext {
  const std::vector<std::string>& scenes;
  const std::vector<Method>& integrators;
  const std::vector<RegionChoice>& regions;
  const std::vector<std::string>& metrics;
};
// Throw Error. A place: "scene" and "region" of the table `owner`.
void read_place(TableReader& reader, const std::string& owner, const RateContext& context, std::string& scene,
                std::string& region);
std::vector<RateLaw> read_rates(const ConfigNode& node, const RateContext& context);

struct RateRecord {
  std::vector<RateLaw> laws;
  std::vector<RegionChoice> regions;
  std::vector<RatioClaim> ratios = {};

  // Whether what is stated of a scene and a region (empty: of all) is of this scene.
  bool concerns(const std::string& stated_scene, const std::string& region, const std::string& scene) const;
  bool empty() const { return laws.empty() && regions.empty() && ratios.empty(); }
  void merge(const RateRecord& other);  // adds what it does not hold
};

}  // namespace etendue
