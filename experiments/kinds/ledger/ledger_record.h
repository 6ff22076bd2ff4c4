// A decision of the program held against its opposite on one scene: a component as it is, on or off, and switched, under each
// seed. The cell is (scene, method or structure, component, 1).
#pragma once

#include "experiments/log/log.h"
#include "experiments/report/kind_report.h"

#include <cstdint>
#include <string>
#include <vector>

namespace etendue {

// One seed. Errors are relMSE; times are of the processor, preparation included.
struct LedgerTrial {
  std::uint64_t seed = 0;
  double error = 0, switched_error = 0;
  double cpu_s = 0, switched_cpu_s = 0;
  bool same_image = false;  // to the last bit
};

struct LedgerRecord final : KindRecord {
  static constexpr const char* type = "ledger";

  bool on = false;           // as the program decides
  std::string why;           // it does
  std::string switched;      // the method, structure or scene with the component switched
  std::string kept;          // why the decision stands where it is contradicted; "": nothing was said
  std::string inapplicable;  // why it cannot be switched here; "": it was
  std::string reference;     // what errors are measured against
  std::uint64_t iterations = 0;
  std::string bias;         // of the method: "unbiased", "consistent" or "biased",
  double mse_exponent = 0;  // and the power of the iterations at which its MSE falls
  std::vector<LedgerTrial> trials;

  std::string line() const override;
};

// Tables and chart: each component over all scenes, and each decision with its verdict.
KindReport ledger_report(const RunLog& log);
std::string ledger_summary(const RunLog& log);

}  // namespace etendue
