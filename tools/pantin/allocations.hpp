#pragma once
/// Counts of operator new, which this program replaces for the purpose.
#include <cstdint>

namespace pantin::program {

/// Since the start, by the calling thread.
std::uint64_t allocations_here();
/// Since the start, by all threads.
std::uint64_t allocations_everywhere();

}  // namespace pantin::program
