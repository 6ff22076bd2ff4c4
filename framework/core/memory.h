// How much memory there is to take: what is too large is refused before it is begun, not when the system runs out.
#pragma once

#include "framework/core/error.h"

#include <cstdint>

namespace etendue {

// Keeps freed memory for the next request, in the whole process (glibc). Builders, photon passes and films free arrays of
// megabytes and soon ask for as many; giving them back to the system and mapping them anew takes part of a build.
void keep_freed_memory();

// Gives back what is kept.
void release_freed_memory();

// The most that this process may have in memory; 0, as it begins: no limit of its own.
void set_memory_limit(std::uint64_t bytes);
std::uint64_t memory_limit();
// The bytes that it has in memory now, once freed memory is released. It is 0 but on Linux.
std::uint64_t resident_memory_bytes();

// Bytes this process may still take: the least of what the system has (swap included), its control group (version 2), its
// limit on address space (ulimit -v) and that of its own leave, once freed memory is released. Linux; elsewhere, and where
// nothing is known, 2^63.
std::uint64_t available_memory_bytes();

// Throws an Error at `where`, "`what` needs about 20 GiB, and 3.1 GiB are free; expected `expectation`", where that is more
// than is available.
void require_memory(double bytes, const Location& where, const std::string& what, const std::string& expectation);

}  // namespace etendue
