// Experiments as texts, for the tests of what reads them.
#pragma once

#include "experiments/config/config.h"
#include "framework/core/error.h"

#include <gtest/gtest.h>

#include <string>

namespace etendue {

// The text with the first occurrence of a piece replaced.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

// The text of the Error with which the experiment is refused.
inline std::string config_error(const std::string& text, const ConfigOptions& options = {}) {
  try {
    parse_experiment(text, "x.toml", options);
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

inline void expect_error(const std::string& text, const std::string& place, const std::string& piece) {
  const std::string what = config_error(text);
  EXPECT_TRUE(what.starts_with(place + ":")) << what;
  EXPECT_NE(what.find(piece), std::string::npos) << what;
}

}  // namespace etendue
