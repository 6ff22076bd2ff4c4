#include "experiments/kinds/claims/claim_record.h"

#include "experiments/kinds/claims/claim_fields.h"

namespace etendue {

void list_fields(auto& f, FieldsOf<ClaimRecord> auto& r) { list_claim_fields(f, r); }

std::string ClaimRecord::line() const { return line_of("claim", *this); }
ClaimRecord read_claim_record(const Json& json) { return read_value<ClaimRecord>(json); }

}  // namespace etendue
