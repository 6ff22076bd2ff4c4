// Tables and chart of ledger_record.h: each component over all scenes, and each decision with its verdict.
#pragma once

#include "experiments/report/kind_report.h"

namespace etendue {

KindReport ledger_report(const RunLog& log);
std::string ledger_summary(const RunLog& log);

}  // namespace etendue
