#include "experiments/kinds/stress/stress_record.h"

#include "experiments/kinds/claims/claim_fields.h"

namespace etendue {

void list_fields(auto& f, FieldsOf<StressRecord> auto& r) {
  list_claim_fields(f, r);
  f("methods", r.methods);
  f("picture", r.picture);
  f.stamp("picture", r.picture_stamp);
  f.end("holds_low", r.holds.low, -endless);
  f.end("holds_high", r.holds.high, endless);
}

std::string StressRecord::line() const { return line_of("stress", *this); }
StressRecord read_stress_record(const Json& json) { return read_value<StressRecord>(json); }

}  // namespace etendue
