#include "experiments/kinds/animation/animation_record.h"

#include "experiments/log/json_line.h"

namespace etendue {

std::string to_json_line(const AnimationRecord& r) {
  Json policies = Json::array();
  for (const PolicyRecord& p : r.policies)
    policies.push_back(Json{{"policy", p.policy},
                            {"update_s", finite(p.update_s)},
                            {"trace_s", finite(p.trace_s)},
                            {"sah_cost", finite(p.sah_cost)},
                            {"rebuilt", finite(p.rebuilt)},
                            {"disagreements", p.disagreements}});
  const Json json{{"type", "animation"},
                  {"scene", r.cell.scene},
                  {"accel", r.cell.accel},
                  {"motion", r.cell.integrator},
                  {"seed", r.cell.seed},
                  {"manifest", r.manifest},
                  {"status", r.status},
                  {"error", r.error},
                  {"primitives", r.primitives},
                  {"rays", finite(r.rays)},
                  {"changed", finite(r.changed)},
                  {"rebuilt_sah_cost", finite(r.rebuilt_sah_cost)},
                  {"policies", std::move(policies)}};
  return dump(json);
}

AnimationRecord read_animation_line(const std::string& line) {
  const Json json = Json::parse(line);
  const auto numbers = [](const Json& j, const char* key) { return j.at(key).get<std::vector<double>>(); };
  AnimationRecord r;
  r.cell = {json.at("scene"), json.at("accel"), json.at("motion"), json.at("seed").get<std::uint64_t>()};
  r.manifest = json.at("manifest");
  r.status = json.at("status");
  r.error = json.at("error");
  r.primitives = json.at("primitives");
  r.rays = numbers(json, "rays");
  r.changed = numbers(json, "changed");
  r.rebuilt_sah_cost = numbers(json, "rebuilt_sah_cost");
  for (const Json& p : json.at("policies"))
    r.policies.push_back({p.at("policy"), numbers(p, "update_s"), numbers(p, "trace_s"), numbers(p, "sah_cost"),
                          numbers(p, "rebuilt"), p.at("disagreements").get<std::uint64_t>()});
  return r;
}

}  // namespace etendue
