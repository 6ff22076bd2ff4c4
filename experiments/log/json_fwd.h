// The JSON of logs, for headers that only name it.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace etendue {

// Converts as nlohmann's own does, but whole numbers only from whole numbers that they hold (json_line.h).
template <class T, class SFINAE = void>
struct CheckedNumber;

// Keeps keys in the order they are written in, "type" first.
using Json = nlohmann::basic_json<nlohmann::ordered_map, std::vector, std::string, bool, std::int64_t, std::uint64_t, double,
                                  std::allocator, CheckedNumber>;

}  // namespace etendue
