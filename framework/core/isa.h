// The instruction sets that kernels are compiled for, and which of them runs: the machine's best, or a narrower one that a
// person chose (`--isa`). Answers are the same bits with each; only the time differs. wide_bvh.cpp and runs.h pick by it.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace etendue {

enum class Isa : std::uint8_t { scalar, sse, avx2, avx512 };

std::string_view isa_name(Isa isa);          // "AVX2", as people write it
std::string_view isa_option(Isa isa);        // "avx2", as --isa takes it
Isa isa_of_option(std::string_view option);  // one of isa_options
inline constexpr std::string_view isa_options[] = {"sse", "avx2", "avx512"};
bool is_supported(Isa isa);
std::span<const Isa> supported_isas();  // by this machine, narrowest first

Isa chosen_isa();          // of every structure built from now on
void choose_isa(Isa isa);  // one that is supported; before threads begin

}  // namespace etendue
