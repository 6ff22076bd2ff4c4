// A build for libFuzzer makes things smaller that a few words of a scene ask for, such as baked textures, so that it reads
// thousands of scenes a second. The code is the same.
#pragma once

namespace etendue {

template <class Value>
constexpr Value unless_fuzzed([[maybe_unused]] Value value, [[maybe_unused]] Value fuzzed) {
#ifdef ETENDUE_FUZZ
  return fuzzed;
#else
  return value;
#endif
}

}  // namespace etendue
