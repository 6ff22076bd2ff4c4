// Things that a scene file states and of which this renderer has no exact equal.
//
// By default that is an error, for an image that differs in silence is worse than none. Where the user allows approximations,
// the nearest thing is taken and each kind is told once: where it stands first, what was taken in its place, and what that does
// to the image.
#pragma once

#include "framework/core/error.h"

#include <cstdint>
#include <string>
#include <vector>

namespace etendue {

class Approximations {
 public:
  explicit Approximations(bool allowed) : allowed_(allowed) {}

  // `what` is one sentence's beginning, as 'Material "hair": is not supported'; `instead` says what is taken and its effect, as
  // "a diffuse surface of its colour, without its highlights". Throws Error at `where` unless approximations are allowed.
  void take(const Location& where, const std::string& what, const std::string& instead);
  bool allowed() const { return allowed_; }

  // One warning for each kind, with the number of further places.
  std::vector<std::string> warnings() const;

 private:
  struct Taken {
    Location where;
    std::string what, instead;
    std::uint64_t more = 0;
  };

  bool allowed_;
  std::vector<Taken> taken_;
};

}  // namespace etendue
