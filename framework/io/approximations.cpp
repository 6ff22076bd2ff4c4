#include "framework/io/approximations.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {

void Approximations::take(const Location& where, const std::string& what, const std::string& instead) {
  if (!allowed_) throw Error(where, fmt::format("{}; --approximate takes {}", what, instead));
  const auto same =
      std::find_if(taken_.begin(), taken_.end(), [&](const Taken& t) { return t.what == what && t.instead == instead; });
  if (same == taken_.end())
    taken_.push_back({where, what, instead});
  else
    ++same->more;
}

std::vector<std::string> Approximations::warnings() const {
  std::vector<std::string> warnings;
  for (const Taken& t : taken_)
    warnings.push_back(fmt::format("{}: {}: taken as {}{}", t.where.text(), t.what, t.instead,
                                   t.more == 0 ? "" : fmt::format(" (and in {} more places)", t.more)));
  return warnings;
}

}  // namespace etendue
