// The fields of claims in a log, for records that hold what a claim holds and more.
#pragma once

#include "experiments/kinds/claims/claim_record.h"
#include "experiments/log/fields.h"

namespace etendue {

inline constexpr const char* figure_kinds[] = {"factor", "time", "plain", "share", "exponent"};

void list_fields(auto& f, FieldsOf<ClaimFigure> auto& r) {
  f("quantity", r.quantity);
  f("text", r.text);
  f.choice("kind", r.kind, figure_kinds);
  f("median", r.value.median);
  f("low", r.value.low);
  f("high", r.value.high);
  f("judged", r.judged);
  if (!r.judged) return;
  f.end("expected_low", r.expected.low, -endless);
  f.end("expected_high", r.expected.high, endless);
}

// `Record` is a ClaimRecord, or what derives from one.
void list_claim_fields(auto& f, auto& r) {
  f("id", r.id);
  f.cell(r.cell, "measure", "cell");
  list_ending(f, r);
  f("claim", r.claim);
  f("source", r.source);
  f("claimed", r.claimed);
  f("reading", r.reading);
  f("figures", r.figures);
  f("remarks", r.remarks);
  f("disagreements", r.disagreements);
}

}  // namespace etendue
