#include "framework/core/check.h"

#include <cstdio>
#include <cstdlib>

namespace etendue::detail {

void check_failed(const char* file, int line, const char* expression, const std::string& operands) {
  std::fprintf(stderr, "%s:%d: CHECK failed: %s%s%s%s\n", file, line, expression, operands.empty() ? "" : " (",
               operands.c_str(), operands.empty() ? "" : ")");
  std::abort();
}

}  // namespace etendue::detail
