// `etendue list`: every name there is, with every parameter, default, range and unit.
#include "accel/ray/change_policy.h"
#include "accel/registry.h"
#include "experiments/claims/claim.h"
#include "experiments/claims/claim_scenes.h"
#include "experiments/stress/stress_figures.h"
#include "experiments/command/commands.h"
#include "framework/image/metrics.h"
#include "framework/io/load_scene.h"
#include "framework/scene/motion.h"
#include "integrators/registry.h"

#include <fmt/format.h>
#include <functional>

namespace etendue {

namespace {

void print_name(const std::string& name, const std::string& summary) { fmt::print("  {:<34} {}\n", name, summary); }

void print_params(const std::vector<ParamInfo>& params) {
  for (const ParamInfo& info : params)
    fmt::print("      {:<24} {:<14} {}{}{}: {}\n", info.name, info.default_value.empty() ? "\"\"" : info.default_value,
               info.range, info.unit.empty() ? "" : " ", info.unit, info.help);
}

void list_scenes() {
  for (const BuiltinScene& scene : builtin_scenes()) {
    print_name("builtin:" + scene.name, scene.summary);
    print_params(scene.params);
  }
  print_name("builtin:NAME?key=value,…", "with parameters");
  print_name("FILE.pbrt", "a scene");
  print_name("FILE.obj, .ply, .smf", "a bare mesh, with a camera and a light of its own");
}

void list_integrators() {
  for (const IntegratorEntry& entry : integrators()) {
    print_name(entry.name, entry.summary);
    print_params(entry.params);
  }
}

void list_accels() {
  for (const RayEntry& entry : ray_structures()) {
    print_name(entry.name, entry.summary + (entry.available ? "" : " (absent: its library was not found when this was built)"));
    print_params(entry.params);
  }
}

void list_metrics() {
  for (const Metric& metric : metrics()) print_name(std::string(metric.name), std::string(metric.formula));
}

void list_points() {
  for (const PointEntry& entry : point_structures()) print_name(entry.name, entry.summary);
}

void list_balls() {
  for (const BallEntry& entry : ball_structures()) print_name(entry.name, entry.summary);
}

void list_motions() {
  for (const MotionEntry& entry : motions()) {
    print_name(entry.name, entry.summary);
    print_params(entry.params);
  }
}

void list_policies() {
  for (const ChangePolicyEntry& entry : change_policies()) {
    print_name(entry.name, entry.summary);
    print_params(entry.params);
  }
}

// With their figures, and the scenes that only claims ask for.
void list_measurements() {
  for (const Measurement& measurement : measurements()) {
    print_name(measurement.name, measurement.summary);
    for (const Quantity& quantity : measurement.quantities) fmt::print("      {:<24} {}\n", quantity.name, quantity.text);
  }
  for (const ClaimScene& scene : claim_scenes()) {
    print_name("claim:" + scene.name, scene.summary);
    print_params(scene.params);
  }
}

void list_figures() {
  for (const StressFigure& figure : stress_figures()) print_name(figure.name, figure.text);
}

struct Section {
  std::string name, title;
  std::function<void()> print;
};

}  // namespace

int list_command(const std::string& what) {
  const Section sections[] = {{"scenes", "scenes", list_scenes},
                              {"integrators", "integrators (with each parameter: default, range, unit)", list_integrators},
                              {"accels", "ray structures (with each parameter: default, range, unit)", list_accels},
                              {"metrics", "metrics (x: image, r: reference)", list_metrics},
                              {"points", "point structures: which photons lie near?", list_points},
                              {"balls", "ball structures: which records cover a point?", list_balls},
                              {"motions", "motions, of experiments on change over time", list_motions},
                              {"policies", "policies: what becomes of a tree when its scene moves", list_policies},
                              {"measurements", "measurements, of experiments on claims (and their scenes)", list_measurements},
                              {"figures", "figures of images, of the catalogue of failures", list_figures}};
  std::vector<std::string> names;
  bool found = false;
  for (const Section& section : sections) {
    names.push_back(section.name);
    if (!what.empty() && what != section.name) continue;
    if (what.empty()) fmt::print("{}{}\n", found ? "\n" : "", section.title);
    section.print();
    found = true;
  }
  if (!found) throw Error(Location{"list"}, unknown_name("list", what, names));
  return 0;
}

}  // namespace etendue
