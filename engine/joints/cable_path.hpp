#pragma once
/// Path of a taut cable from its first end through rings and around pulleys to its last.
///
/// Between two points the cable is straight and tangent to their circles; on a pulley it follows
/// the circle. Without friction its length is a function of the points alone:
///
///   L = sum sqrt(|d|^2 - s^2)  +  sum R phi
///
/// over the straight parts, d from centre to centre, s = R - R' (R + R' where the cable crosses
/// from one side to the other), and over the pulleys, phi the angle of wrap. The tension of a cable
/// acts along the gradient of L, so it is the same everywhere and no work is lost. A pulley whose
/// phi would be negative does not deflect the cable: the cable passes it until its ends return. The
/// length is exact while the points next to a pulley are in its plane; near the plane it is a
/// conservative approximation. Poses give phi up to whole turns. The value nearest to the angle
/// before is used, so the length never jumps while a body circles a pulley.
///
/// Internal (pantin::detail).
#include <optional>
#include <span>
#include <vector>

#include "engine/joints/cable.hpp"
#include "engine/joints/rows.hpp"

namespace pantin::detail {

inline constexpr std::size_t kMostPathPoints = 16;

/// A point of a path and its motion by the velocities of its body alone; world axes, m and s.
struct PathPoint {
  Vec3 centre{0}, velocity{0}, acceleration{0};
  Vec3 axis{0, 0, 1}, axis_rate{0}, axis_acceleration{0};  // the cable runs round it anticlockwise
  Real radius = 0;                                         // m; 0: an end or a ring
  Real wrap = kFirstWrap;  // rad, angle of wrap before; the new one is within half a turn of it
};

/// A point of a body and an axis in its mass-centre frame.
PathPoint path_point(const BodyState& body, Vec3 anchor, Vec3 axis, Real radius);

/// Gradient of the length by one point: by its centre, and by rotations about the centre.
struct PathGradient {
  Vec3 by_centre{0}, by_turn{0};
};

/// Length of a path, m, and its second time derivative without accelerations of the bodies, m/s^2.
struct PathLength {
  Real length = 0, second_rate = 0;
};

/// The length of a path of 2 to kMostPathPoints points; gradients are written if there is room for
/// all of them.
PathLength path_length(std::span<const PathPoint> path, std::span<PathGradient> gradients);

/// Writes the current angles of wrap, rad: below 0 where the cable passes by, 0 at ends and rings.
/// Returns how far, m, the end of a straight part would run up on its pulley, or through its ring,
/// within `time` at the current velocities; 0: nowhere. That is not modelled. A straight part
/// shorter than a thousandth of the shift s counts as used up.
Real follow_path(std::span<const PathPoint> path, Real time, std::span<Real> wraps);

/// Two consecutive points that are impossible: one inside the other, or pulleys askew.
struct PathFault {
  std::size_t place = 0;  // of the first, from the cable's end a
  bool askew = false;
  Real distance = 0, least = 0;  // m, of the centres; where they would touch
};
std::optional<PathFault> fault_of(std::span<const PathPoint> path);

/// Appends the points of the taut cable, m, arcs in steps of no more than `turn` rad.
void trace_path(std::span<const PathPoint> path, Real turn, std::vector<Vec3>& to);

}  // namespace pantin::detail
