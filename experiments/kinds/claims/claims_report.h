// What a report says of textbook statements: the verdict on each, and every figure behind it.
#pragma once

#include "experiments/kinds/claims/claim_record.h"
#include "experiments/report/kind_report.h"

#include <string>
#include <vector>

namespace etendue {

// The cells of one claim that are done, in order of the log.
struct ClaimFindings {
  int id = 0;
  std::vector<const ClaimRecord*> records;
  Verdict verdict = Verdict::depends;
  std::string on_what;                // of "depends": which figures say what
  std::vector<std::string> measured;  // a line for each quantity

  const ClaimRecord& stated() const { return *records.front(); }
};

// Claims come by id, and keep pointers into `log`. Claims of which no judged figure is there are left out.
std::vector<ClaimFindings> arrange_claims(const RunLog& log);

// Its columns are claim, source, claimed, measured and verdict.
Table claims_table(const RunLog& log);

KindReport claims_report(const RunLog& log);
std::string claims_summary(const RunLog& log);  // what `etendue run` prints at its end

}  // namespace etendue
