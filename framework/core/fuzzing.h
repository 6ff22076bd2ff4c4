// What a build for libFuzzer makes smaller, so that it reads thousands of scenes a second: sizes of what is made from a few
// words of a scene, such as baked textures. The code is the same.
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
