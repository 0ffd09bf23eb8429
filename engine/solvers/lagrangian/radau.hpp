#pragma once
/// Shared by the implicit method of three stages and the linear systems of its steps.
#include <array>

#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {

/// Vectors of a body in a state or a rate: displacement, rotation, velocity, angular velocity.
inline constexpr std::size_t kStageVectors = 4;

/// Allocates the scratch of a method of three stages.
void allocate_collocation(Island& m);

/// The systems of a step of `h`: for each eigenvalue z of the inverse of its coefficients,
///
///   (1 - g F') d = residual,   g = h / z
///
/// where F' is the Jacobian of the rates at the start of the step, from springs, motors, friction,
/// drag and compliant elements. Where none of them is stiff for a step of this length, F' is only
/// d(displacement)/dt = velocity.
///
/// Prepares both, real and complex, at the current state. Overwrites scratch.values.
void prepare_stage_systems(const World& world, Island& m, Real h);

/// Solve in place, after prepare_stage_systems().
void solve_real_system(Island& m, std::vector<Vec3>& residual);
void solve_complex_system(Island& m, std::vector<Vec3>& real, std::vector<Vec3>& imaginary);

/// Eigenvalues of the inverse of Radau IIA's coefficients. [Hairer & Wanner II, sec. IV.8]
inline constexpr Real kRealEigenvalue = 3.6378342527444957;
inline constexpr Complex kComplexEigenvalue{2.6810828736277521, 3.0504301992474106};

}  // namespace pantin::detail::lagrangian
