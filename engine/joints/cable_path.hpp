#pragma once
/// The way of a taut cable from its first end through rings and round pulleys to its last.
///
/// Between two places the cable is straight and touches their circles; where it lies on a pulley it
/// follows the circle. Without friction its length is a function of the places alone:
///
///   L = sum sqrt(|d|^2 - s^2)  +  sum R phi
///
/// over the straight parts, d from centre to centre, s = R - R' (R + R' where the cable crosses
/// from one side to the other), and over the pulleys, phi the angle of wrap. The tension of a cable
/// acts along the gradient of L, so it is the same everywhere and no work is lost. Where a pulley
/// does not turn the cable, phi would be negative: the cable passes by it until its ends come back
/// the way they went. This is exact while the places next to a pulley lie in its plane; near it, it
/// is a conservative approximation. Poses tell phi but for whole turns; of those it has what is
/// nearest to the angle before, so the length never jumps while a body is whirled round a pulley.
///
/// Internal (pantin::detail).
#include <optional>
#include <span>
#include <vector>

#include "engine/joints/cable.hpp"
#include "engine/joints/rows.hpp"

namespace pantin::detail {

inline constexpr std::size_t kMostPathPoints = 16;

/// A place of a path and its motion by the velocities of its body alone; world axes, m and s.
struct PathPoint {
  Vec3 centre{0}, velocity{0}, acceleration{0};
  Vec3 axis{0, 0, 1}, axis_rate{0}, axis_acceleration{0};  // the cable runs round it anticlockwise
  Real radius = 0;                                         // m; 0: an end or a ring
  Real wrap = kFirstWrap;  // rad, angle of wrap before: this one is within half a turn of it
};

/// A point of a body and an axis in its mass-centre frame.
PathPoint path_point(const BodyState& body, Vec3 anchor, Vec3 axis, Real radius);

/// How the length changes as one place moves: by its centre, and by turns about the centre.
struct PathGradient {
  Vec3 by_centre{0}, by_turn{0};
};

/// Length of a path, m, and its second time derivative without accelerations of the bodies, m/s^2.
struct PathLength {
  Real length = 0, second_rate = 0;
};

/// The length of a path of 2 to kMostPathPoints places; gradients are written where there is room
/// for all of them.
PathLength path_length(std::span<const PathPoint> path, std::span<PathGradient> gradients);

/// Writes the angles of wrap as they are now, rad, below 0 where the cable passes by, 0 of ends and
/// rings. Returns how far the end of a straight part runs up on its pulley, or through its ring,
/// within `time` at the velocities of the places, m: that is not modelled. Less than a thousandth
/// of a pulley's radius counts as nothing left. 0: nowhere.
Real follow_path(std::span<const PathPoint> path, Real time, std::span<Real> wraps);

/// Two places that follow one another and cannot: within one another, or pulleys askew.
struct PathFault {
  std::size_t place = 0;  // of the first, from the cable's end a
  bool askew = false;
  Real distance = 0, least = 0;  // m, of the centres; where they would touch
};
std::optional<PathFault> fault_of(std::span<const PathPoint> path);

/// Appends the points of the taut cable, m, arcs in steps of no more than `turn` rad.
void trace_path(std::span<const PathPoint> path, Real turn, std::vector<Vec3>& to);

}  // namespace pantin::detail
