#pragma once
/// Rows of surface joints by finite differences, for comparison with the closed forms of
/// surfaces.cpp. `"jacobians"` of the solver settings selects them. [Nelson & Cohen, sec. 4 to 6]
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {

/// Central differences with steps of `step` rad, or that fraction of the smaller surface in m.
/// Extrapolated once (Richardson), their error is of order 4 in `step`, otherwise of order 2.
struct DifferenceScheme {
  Real step = 1e-3;
  bool extrapolated = true;
};

/// Derivatives of both contact points by the coordinates of both bodies: displacement and rotation
/// of a, then of b, world axes. [Nelson & Cohen, Eqn 7, with rotation vectors instead of
/// quaternions: their dependent component is removed]
struct ContactSlopes {
  Vec3 on_a[12] = {}, on_b[12] = {};
  nurbs::ContactStatus status = nurbs::ContactStatus::found;  // of the first pair that was lost
};
/// Tracks the pair at two displaced poses a coordinate, four if extrapolated.
ContactSlopes contact_slopes(const World& world, const Island& m, std::size_t block,
                             const DifferenceScheme& scheme);

/// Replaces the rows of gap, rolling and spin, which are written, by those of differences:
///
///   gap      J = n.(dS_a/dq - dS_b/dq)
///   C_p      J = 2 |gap| n.(dS_a/dq - dS_b/dq)    with Jacobians::squared_distance
///   C_roll   J = -t.((dS_a/dq - A_a) - (dS_b/dq - A_b)),   A: of the points fixed in the bodies
///
/// Their rates are linear in the velocities and are differenced once along the motion for gamma.
/// C_tan vanishes at every common normal, hence so does its Jacobian, and it has no row. C_p has
/// the sign of the gap; rows whose gradient is shorter than 1e-6 bind nothing. Joints that may lift
/// off or slip keep the gap, whose multiplier is a force.
///
/// If the pair of a displaced pose is lost, as within a step of a rim, so is that of the contact.
void write_differences(const World& world, Island& m, std::size_t block, Want want);

}  // namespace pantin::detail::lagrangian
