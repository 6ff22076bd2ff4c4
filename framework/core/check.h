// CHECK for programmer's mistakes: always on, prints its operands, aborts. DCHECK is the same in debug builds only.
#pragma once

#include <fmt/format.h>

#include <string>

namespace etendue::detail {
[[noreturn]] void check_failed(const char* file, int line, const char* expression, const std::string& operands);

template <class A, class B>
std::string operands(const A& a, const B& b) {
  if constexpr (fmt::is_formattable<A>::value && fmt::is_formattable<B>::value) return fmt::format("{} vs {}", a, b);
  return {};
}
}  // namespace etendue::detail

#define ETENDUE_CHECK_OP(a, op, b)                                                                                           \
  do {                                                                                                                       \
    const auto& check_a = (a);                                                                                               \
    const auto& check_b = (b);                                                                                               \
    if (!(check_a op check_b)) [[unlikely]]                                                                                  \
      ::etendue::detail::check_failed(__FILE__, __LINE__, #a " " #op " " #b, ::etendue::detail::operands(check_a, check_b)); \
  } while (false)

#define CHECK(condition)                                                   \
  do {                                                                     \
    if (!(condition)) [[unlikely]]                                         \
      ::etendue::detail::check_failed(__FILE__, __LINE__, #condition, {}); \
  } while (false)
#define CHECK_EQ(a, b) ETENDUE_CHECK_OP(a, ==, b)
#define CHECK_LT(a, b) ETENDUE_CHECK_OP(a, <, b)
#define CHECK_LE(a, b) ETENDUE_CHECK_OP(a, <=, b)
#define CHECK_GT(a, b) ETENDUE_CHECK_OP(a, >, b)

#ifdef NDEBUG
#define DCHECK(condition) \
  do {                    \
  } while (false)
#else
#define DCHECK(condition) CHECK(condition)
#endif
