#pragma once
/// Limits of a joint's angles as distances: how far a joint is beyond each of them, and where to.
/// The hard limits of `auto` and the law of a soft stop take them from here.
#include "engine/joints/rows.hpp"

namespace pantin::detail {

/// The axes about which a kind turns that turns about one or two, in axes of the world where `a`
/// and `b` are the joint axes of its bodies; else zero.
struct FreeAxes {
  Vec3 first{0}, second{0};
};
FreeAxes free_axes(JointKind kind, Quat a, Quat b);

/// One side of a limited angle.
struct JointStop {
  Real beyond = 0;  // rad; negative: what is left
  Vec3 along{0};    // its derivative by a turn of b relative to a, world axes
  bool is_watched = false;
};
/// The low and the high side of the angle at 0 and 1, of the second angle at 2 and 3; a cone at 2,
/// its distance to first order. In the middle of a cone, where no way out is shorter than another,
/// it is not watched.
void find_stops(const JointState& at, JointStop (&out)[4]);
/// Of an angle that grows along `along`: the low side and the high one.
void find_sides(const AngleLimit& limit, Real angle, Vec3 along, JointStop* out);

/// Torque of the soft zones of a joint's limits on b, the opposite on a:
///
///   -(stiffness (zone + beyond) + damping rate) along      within the zone of each side
struct SoftStopLoad {
  Vec3 torque{0};      // N m, world axes
  Vec3 along[2] = {};  // of the sides that act, of the angle and of what is at 2
  bool acts[2] = {};
};
SoftStopLoad soft_stop_load(const JointState& at);
/// What the zones store, J.
Real soft_stop_energy(const JointState& at);

}  // namespace pantin::detail
