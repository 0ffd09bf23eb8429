#pragma once
/// What the narrow phase costs for two shapes of each kind, and how far its gaps are off.
#include <cstdio>

namespace pantin::study {

/// Poses for each pair of kinds: a few for a look, or enough for figures.
enum class PairSample { few, many };

/// Prints a table, or comma separated values where `out` is not the standard output.
void measure_pairs(std::FILE* out, PairSample sample);

}  // namespace pantin::study
