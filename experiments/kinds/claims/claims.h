// Textbook statements, measured: the part of an experiment that names claims, [[claims]] with their measures, and timing
// (docs/experiment-file.md has the keys); the record of a cell, which is one claim as one measurement found it on one scene;
// and what a report says of them, the verdict on each and every figure behind it.
#pragma once

#include "experiments/config/config.h"
#include "experiments/kinds/claims/measurement.h"
#include "experiments/log/log.h"
#include "experiments/report/kind_report.h"

#include <map>

namespace etendue {

struct ClaimStatement {
  int id = 0;
  std::string claim, source, claimed;
  std::string reading = {};  // how the claim's words became intervals, and what else a reader must know
};

struct ClaimFigure {
  std::string quantity, text;
  FigureKind kind = FigureKind::factor;
  Measured value;
  bool judged = false;  // by what is expected; else the figure is only shown
  Expected expected = {};
};

// The cell is (scene, measurement, "claim-01", seed).
struct ClaimRecord final : KindRecord, ClaimStatement {
  static constexpr const char* type = "claim";

  std::vector<ClaimFigure> figures;
  std::vector<std::string> remarks;
  std::uint64_t disagreements = 0;

  std::string line() const override;
};

struct ClaimMeasure {
  const Measurement* measurement = nullptr;
  std::vector<std::string> scenes;
  std::map<std::string, Expected> expect;
  bool large = false;
};

struct Claim : ClaimStatement {
  std::vector<ClaimMeasure> measures = {};
};

struct ClaimsChoice final : KindChoice {
  int resolution = 256;  // about its square of rays of each kind
  int repetitions = 9;   // interleaved
  bool large = true;     // with the measures that take gigabytes and minutes
  std::vector<Claim> rows;
};

// Reads the values of the keys `claims` and `timing` (may be null). Throws Error.
ClaimsChoice read_claims(const ConfigNode& claims, const ConfigNode* timing);

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
