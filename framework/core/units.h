// Numbers with units as people type them: "60s", "1.5min", "200k", "512MiB".
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace etendue {

double parse_seconds(std::string_view text);      // ms s min h; plain numbers are seconds; throws Error naming the units
std::int64_t parse_count(std::string_view text);  // k M G (powers of 1000); whole numbers only
std::int64_t parse_bytes(std::string_view text);  // B KB MB GB KiB MiB GiB

std::string format_seconds(double seconds);  // "1.2 ms", "3.4 s", "2 min 05 s"
std::string format_count(double count);      // "1.2 k", "3.4 M"
std::string format_bytes(double bytes);      // "1.2 MiB"
std::string format_percent(double share);    // "1.2 %", "34 %"

}  // namespace etendue
