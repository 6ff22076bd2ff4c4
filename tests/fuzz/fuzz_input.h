// Shared by every driver of tests/fuzz/. A driver defines LLVMFuzzerTestOneInput for one format: whatever the bytes are, the
// reader either accepts them or throws Error. Any other exception, a failed CHECK, a finding of a sanitizer or a crash is a
// finding.
//
// Built by clang with -DETENDUE_FUZZ=ON the drivers are libFuzzer's, to search for findings; otherwise replay.cpp feeds them
// the corpus in every run of the tests.
#pragma once

#include "framework/core/error.h"

#include <cstddef>
#include <cstdint>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace etendue::fuzz {

inline std::string text_of(const std::uint8_t* data, std::size_t size) { return {reinterpret_cast<const char*>(data), size}; }

template <class Read>
int expect_read_or_refused(const Read& read) {
  try {
    read();
  } catch (const Error&) {
  }
  return 0;
}

}  // namespace etendue::fuzz
