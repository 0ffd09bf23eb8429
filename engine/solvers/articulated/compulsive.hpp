#pragma once
/// The motions that joints force on one body: turn first, slide the rest.
#include "engine/base/math.hpp"

namespace pantin::articulated {

/// A turn about the mass centre and a slide of it, world axes.
struct CompulsiveMotion {
  Quat turn{1, 0, 0, 0};
  Vec3 slide{0};  // m
};

/// The motion of least mass-weighted displacement that carries an anchor across a gap.
///
/// `arm` runs from the mass centre to the anchor, `gap` from the anchor to its goal: metres, world
/// axes. `inertia` is the world tensor, kg m^2. `stiffness` (beta) sets the split: 0 turns as far
/// as the arm can point, large values only slide. The anchor lands on its goal for every split:
///   R r + T = r + s,  T = (1 - R) r + s
/// The turn lies between 0 and the angle from r to r + s. No gap, no arm, or a gap along the arm
/// give no axis: the body slides. [Lee 2000, sec. 3.2 and Eq. 3; its exponential replaced by theta
/// = atan2(m |r x s|, beta I_a + m r.(r + s)), which is stationary for the displacement, and the
/// sign of T mended]
CompulsiveMotion least_displacement(Vec3 arm, Vec3 gap, Real mass, const Mat3& inertia,
                                    Real stiffness = 1);

/// The rule as printed: axis r x s, angle phi exp(-h / (|r| |s|)) with phi the angle from r to s
/// and `reluctance` the length^2 h. A control for charts. [Lee 2000, sec. 3.2]
CompulsiveMotion literal_rule(Vec3 arm, Vec3 gap, Real reluctance);

/// Moment of inertia about the axis r x s, kg m^2; that about x where there is no axis.
Real inertia_about_turn(Vec3 arm, Vec3 gap, const Mat3& inertia);

/// Where two free anchors meet: on the line between them, m_a |c - c_a| = m_b |c_b - c|.
/// [Lee 2000, sec. 3.3]
inline Vec3 meeting_point(Real mass_a, Vec3 a, Real mass_b, Vec3 b) {
  return (mass_a * a + mass_b * b) / (mass_a + mass_b);
}

/// Damped Verlet, `keep` = exp(-c h): the next position from the last two. [Lee 2000, sec. 3.1]
inline Vec3 verlet_position(Vec3 before, Vec3 now, Vec3 acceleration, Real h, Real keep) {
  return now + keep * (now - before) + h * h * acceleration;
}

/// The same for rotations: the last turn, damped, once more.
Quat verlet_rotation(Quat before, Quat now, Real keep);

}  // namespace pantin::articulated
