#pragma once
/// Limits of a joint's angles as signed distances with gradients, for the hard limits of `auto` and
/// for the law of a soft stop.
#include "engine/joints/rows.hpp"

namespace pantin::detail {

/// The rotation axes, in world axes, of a kind that rotates about one or two axes; otherwise zero.
/// `a` and `b` are the rotations of the joint axes on both bodies.
struct FreeAxes {
  Vec3 first{0}, second{0};
};
FreeAxes free_axes(JointKind kind, Quat a, Quat b);

/// One side of a limited angle.
struct JointStop {
  Real beyond = 0;  // rad; negative: clearance
  Vec3 along{0};    // its derivative by a rotation of b relative to a, world axes
  bool is_watched = false;
};
/// The low and the high side of the angle at 0 and 1, of the second angle at 2 and 3; a cone at 2,
/// its distance to first order. At the centre of a cone the gradient is undefined: the cone is not
/// watched there.
void find_stops(const JointState& at, JointStop (&out)[4]);
/// The low and the high side of an angle whose gradient is `along`.
void find_sides(const AngleLimit& limit, Real angle, Vec3 along, JointStop* out);

/// Torque of the soft zones of a joint's limits on b, the opposite on a:
///
///   -(stiffness (zone + beyond) + damping rate) along      within the zone of each side
struct SoftStopLoad {
  Vec3 torque{0};      // N m, world axes
  Vec3 along[2] = {};  // gradients of active sides: of the angle, and of the limit at 2
  bool acts[2] = {};
};
SoftStopLoad soft_stop_load(const JointState& at);
/// Energy stored in the zones, J.
Real soft_stop_energy(const JointState& at);

}  // namespace pantin::detail
