#pragma once
/// A stiff mechanism, and what accuracy costs there.
#include <cstdint>
#include <cstdio>

#include "tools/study/problems.hpp"

namespace pantin::study {

/// A governor as in the libraries of benchmarks of multibody dynamics: an axis that turns once a
/// second, two rods with balls hinged to it, a slider on it that springs with dampers hold to the
/// rods, N/m and N s/m.
World governor(Real stiffness, Real damping);

/// Error and CPU time of the integrators that may serve there, comma separated.
enum class Extent : std::uint8_t { few_points, all };
void measure_stiff(std::FILE* out, Extent extent);

}  // namespace pantin::study
