// Tables and charts of throughput_record.h: the newest commit's figures, and what each commit before it had.
#pragma once

#include "experiments/report/kind_report.h"

namespace etendue {

KindReport throughput_report(const RunLog& log);
std::string throughput_summary(const RunLog& log);

}  // namespace etendue
