#include "experiments/kinds/ledger/ledger_decisions.h"

#include "accel/registry.h"
#include "experiments/kinds/second_level.h"
#include "experiments/kinds/structures/stage.h"
#include "integrators/paths/path_choices.h"
#include "integrators/pilot/caustic_need.h"

#include <array>

namespace etendue {

namespace {

std::string reason(const DecisionPlace& place, const char* what) {
  for (const SceneNeeds::Line& line : place.needs.lines(place.scene))
    if (line.what == what) return line.why;
  return "";
}

MadeDecision light_tree(const DecisionPlace& place) {
  LightSampler lights(place.scene);
  lights.choose_by(LightChoice::by_need, DirectSamples::of_both);
  return {lights.choice() == LightChoice::tree, reason(place, "choice of lights")};
}

// Answers what `decide` makes of the scene's context.
template <class Decide>
auto on_stage(const DecisionPlace& place, const Decide& decide) {
  const auto rays = find_ray_structure("auto", {}).make(place.scene, {});
  Stage stage(place.scene, *rays, place.resolution, 0);
  return decide(stage.context());
}

MadeDecision caustic_map(const DecisionPlace& place, double enough_hits) {
  CausticParams params;
  on_stage(place, [&](RenderContext& context) { decide_caustic_map(context, params, enough_hits); });
  const bool on = params.caustic_map == CausticMap::on;
  const bool met = !on && place.needs.caustic_map;
  return {on, met ? "paths meet the light behind specular surfaces" : reason(place, "caustic photon map")};
}

MisChoice mis_of(const DecisionPlace& place) {
  return on_stage(place, [](RenderContext& context) {
    context.lights.choose_by(LightChoice::by_need, DirectSamples::of_both);
    return choose_mis(context);
  });
}

MadeDecision both_samples(const DecisionPlace& place) {
  const MisChoice choice = mis_of(place);
  return {choice.mode == MisMode::power, choice.why};
}

MadeDecision light_samples(const DecisionPlace& place) {
  const MisChoice choice = mis_of(place);
  return {choice.mode != MisMode::bsdf, choice.why};
}

MadeDecision second_level(const DecisionPlace& place) { return {place.needs.two_levels, reason(place, "two-level structure")}; }

MadeDecision structure(const DecisionPlace& place, const char* name) {
  const MethodChoice choice = structure_for(place.scene, place.resolution, {.iterations = place.samples});
  return {choice.name == name, choice.why};
}

}  // namespace

std::span<const LedgerDecision> ledger_decisions() {
  static const std::array decisions{
      LedgerDecision{"caustic-map-of-cells", "whether a hash grid's paths take caustics from a map of photons",
                     [](const DecisionPlace& place) { return caustic_map(place, enough_hits_of_cells); }},
      LedgerDecision{"caustic-map-of-records", "whether records and the paths to them take caustics from a map of photons",
                     [](const DecisionPlace& place) { return caustic_map(place, enough_hits_of_records); }},
      LedgerDecision{"light-sampling", "whether paths take light samples of what rays can meet", light_samples},
      LedgerDecision{"light-tree", "whether light samples choose lights by a tree", light_tree},
      LedgerDecision{"multiple-importance-sampling", "whether paths find direct light by light and BSDF samples both",
                     both_samples},
      LedgerDecision{"optimised-tree", "whether the structure `auto` is an optimised tree",
                     [](const DecisionPlace& place) { return structure(place, "sah"); }},
      LedgerDecision{"second-level", "whether there is a tree over instances", second_level},
      LedgerDecision{"sorted-tree", "whether the structure `auto` is a tree that is sorted, not weighed",
                     [](const DecisionPlace& place) { return structure(place, "lbvh"); }},
  };
  return decisions;
}

std::span<const LedgerEdit> ledger_edits() {
  static const std::array edits{LedgerEdit{"second-level", "an instance beneath the scene, or all instances written out",
                                           "second-level", with_second_level, without_second_level}};
  return edits;
}

}  // namespace etendue
