#pragma once
/// Outlines of machine parts in the plane z = 0: involute gears and racks, Geneva drives, cams; and
/// helices. Lengths in metres, angles in radians.
///
/// Internal (pantin::detail).
#include <span>

#include "engine/base/result.hpp"
#include "engine/nurbs/spline.hpp"

namespace pantin::detail::nurbs {

/// Involute teeth. The pitch radius is teeth module / 2; teeth reach a module above it and 1.25
/// modules below, and are half a pitch thick on it, less half the backlash (m).
struct Teeth {
  int count = 20;
  Real module = 0.01, pressure_angle = kPi / 9, backlash = 0;
};
/// An external gear about the origin, anticlockwise, with a tooth along x. Flanks are involutes of
/// the base circle, by degree 5 to about 1e-12 of their size, from 1.0008 base radii up; below they
/// are straight. Corners at tip and root are rounded. The root is not undercut.
Result<Curve> involute_gear(const Teeth& teeth);
/// A bar with teeth along y: the pitch line is the x axis, a tooth is at the origin, and the back
/// is `back` (m) below the pitch line. Straight lines and arcs, exact.
Result<Curve> involute_rack(const Teeth& teeth, Real back);

/// A Geneva drive: a pin on a crank enters a slot of the wheel along it, turns the wheel by one
/// slot, and leaves along it. The crank's arm is distance sin(pi / slots).
struct GenevaDrive {
  int slots = 4;
  Real distance = 0.24, pin_radius = 0.012;  // m; distance of the two axes
  Real lip = 0.004, clearance = 2e-5;        // m; rounding of the slots' ends, play of the disc
  Real arm() const;
};
/// The wheel about the origin, with a slot along x; lines and arcs, exact.
Result<Curve> geneva_wheel(const GenevaDrive& drive);
/// The disc of the crank, which holds the wheel while the pin is outside: about the origin, with a
/// recess along x, where the pin is.
Result<Curve> geneva_disc(const GenevaDrive& drive);

/// The law of one rise or return of a cam, as a share of it by a share of the angle.
enum class CamLaw {
  cycloidal,       // x - sin(2 pi x) / (2 pi)
  polynomial_345,  // 10 x^3 - 15 x^4 + 6 x^5
};
/// A disc cam about the origin, which lifts a follower in line with its centre.
struct Cam {
  Real base = 0.05;  // m, its least radius
  // m, radius of the follower's roller; below 0: a flat face across the direction of the lift.
  Real roller = -1;
  CamLaw law = CamLaw::cycloidal;
  // Angles in order and the lift there, m: the follower moves by the law from each to the next, and
  // from the last to the first one turn on.
  std::vector<std::array<Real, 2>> lifts;

  /// Lift with its first two derivatives by the angle at which the follower is, seen from the cam.
  std::array<Real, 3> lift(Real angle) const;
};
/// Its outline, the envelope of the follower, interpolated at every half degree. An error names the
/// angle at which the follower would lose it: a hollow under a flat face, or an undercut.
Result<Curve> cam_outline(const Cam& cam);

/// About z from the radius along x, interpolated by degree 5.
struct Helix {
  Real radius = 0.05, pitch = 0.02, turns = 6;  // m
};
Result<Curve> helix(const Helix& of);

}  // namespace pantin::detail::nurbs
