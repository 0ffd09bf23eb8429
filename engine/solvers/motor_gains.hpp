#pragma once
/// Gains of motors that have none.
#include "engine/world/world.hpp"

namespace pantin::detail {

/// Whether a motor has no gain yet.
bool has_open_motors(const World& world);

/// Sets the gain and the damping of motors without a gain, for steps of `h` (s), from the inertia I
/// that each sees in the present configuration:
///
///   w = 2 / h                                    bandwidth, rad/s
///   velocity motor: gain = I w                   the rate error falls as exp(-w t)
///   position motor: gain = I w^2, damping 2 I w  critically damped
///
/// I is the resistance of the whole mechanism to acceleration along the motor's coordinate,
/// 1 / (j M^-1 j^T) with all joints closed and the coordinates of all other motors locked. So it
/// includes what lies beyond the joint and before it, gears, and loops. Contacts, taut cables and
/// limits are not included. A bandwidth of 2 / h is the highest that a step of second order
/// resolves.
///
/// Does nothing unless Partition::has_open_motors, or the World was never built.
void choose_motor_gains(World& world, Real h);

}  // namespace pantin::detail
