#pragma once
/// A stiff mechanism, and what accuracy costs there.
#include <cstdio>

#include "tools/study/problems.hpp"

namespace pantin::study {

/// A governor as in the libraries of benchmarks of multibody dynamics: an axis that turns once a
/// second, two rods with balls hinged to it, a slider on it that springs with dampers hold to the
/// rods, N/m and N s/m.
World governor(Real stiffness, Real damping);

/// Error and CPU time of the integrators that may serve there, comma separated.
void measure_stiff(std::FILE* out, bool small);

}  // namespace pantin::study
