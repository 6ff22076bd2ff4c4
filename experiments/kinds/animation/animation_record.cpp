#include "experiments/kinds/animation/animation_record.h"

#include "experiments/log/fields.h"

namespace etendue {

void list_fields(auto& f, FieldsOf<PolicyRecord> auto& r) {
  f("policy", r.policy);
  f("update_s", r.update_s);
  f("trace_s", r.trace_s);
  f("sah_cost", r.sah_cost);
  f("rebuilt", r.rebuilt);
  f("disagreements", r.disagreements);
}

void list_fields(auto& f, FieldsOf<AnimationRecord> auto& r) {
  f.cell(r.cell, "accel", "motion");
  list_ending(f, r);
  f("primitives", r.primitives);
  f("rays", r.rays);
  f("changed", r.changed);
  f("rebuilt_sah_cost", r.rebuilt_sah_cost);
  f("policies", r.policies);
}

std::string AnimationRecord::line() const { return line_of("animation", *this); }
AnimationRecord read_animation_record(const Json& json) { return read_value<AnimationRecord>(json); }

}  // namespace etendue
