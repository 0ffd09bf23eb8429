#pragma once
/// Motions of one body that close a joint: rotation first, then translation for the remaining gap.
#include "engine/base/math.hpp"

namespace pantin::detail::articulated {

/// A rotation about the mass centre and its translation, world axes.
struct CompulsiveMotion {
  Quat rotation{1, 0, 0, 0};
  Vec3 translation{0};  // m
};

/// Mass, kg, and inertia tensor, world axes, kg m^2, of a body.
struct Inertia {
  Real mass = 0;
  Mat3 tensor{0};
};

/// The motion of least mass-weighted displacement that carries an anchor across a gap.
///
/// `arm` runs from the mass centre to the anchor, `gap` from the anchor to its goal: metres, world
/// axes. `stiffness` (beta) sets the split: 0 rotates as far as the arm can point, large values
/// only translate. The anchor lands on its goal for every split:
///   R r + T = r + s,  T = (1 - R) r + s
/// The rotation lies between 0 and the angle from r to r + s. Without a gap, without an arm, or
/// with a gap along the arm there is no axis: the body translates. [Lee 2000, sec. 3.2 and Eq. 3;
/// its exponential replaced by theta = atan2(m |r x s|, beta I_a + m r.(r + s)), the stationary
/// point of the displacement, and the sign of T corrected]
CompulsiveMotion least_displacement(Vec3 arm, Vec3 gap, const Inertia& of, Real stiffness = 1);

/// The rule as printed: axis r x s, angle phi exp(-h / (|r| |s|)) with phi the angle from r to s
/// and `reluctance` the length^2 h. For comparison in charts. [Lee 2000, sec. 3.2]
CompulsiveMotion literal_rule(Vec3 arm, Vec3 gap, Real reluctance);

/// Moment of inertia about the axis r x s, kg m^2; that about x where there is no axis.
Real inertia_about_turn(Vec3 arm, Vec3 gap, const Mat3& inertia);

/// Where two free anchors meet: on the line between them, m_a |c - c_a| = m_b |c_b - c|.
/// [Lee 2000, sec. 3.3]
inline Vec3 meeting_point(Real mass_a, Vec3 a, Real mass_b, Vec3 b) {
  return (mass_a * a + mass_b * b) / (mass_a + mass_b);
}

/// A step of damped Verlet: its length h, s, and the damping factor of the motion, exp(-c h).
struct VerletStep {
  Real h = 0, keep = 1;
};
/// Damped Verlet: the next position from the last two. [Lee 2000, sec. 3.1]
inline Vec3 verlet_position(Vec3 before, Vec3 now, Vec3 acceleration, const VerletStep& step) {
  return now + step.keep * (now - before) + step.h * step.h * acceleration;
}

/// The same for rotations: repeats the last rotation, damped.
Quat verlet_rotation(Quat before, Quat now, Real keep);

}  // namespace pantin::detail::articulated
