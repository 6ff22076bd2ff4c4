// A row of the catalogue of failures as it was measured. Its first figure is the failing method's, the others are those of its
// remedies.
#pragma once

#include "experiments/kinds/claims/claim_record.h"

namespace etendue {

// The cell is (scene, figure, "stress-01", 1). `claim` is the failure in words, `claimed` what is measured of the image.
struct StressRecord final : ClaimRecord {
  static constexpr const char* type = "stress";

  Expected holds;                    // the figure of a method that does not fail
  std::vector<std::string> methods;  // of the figures
  std::string picture;               // beside the log: the reference, then each method
  FileStamp picture_stamp;

  std::string line() const override;
  File file() override { return {&picture, &picture_stamp}; }
};

}  // namespace etendue
