#pragma once
/// Joint equations for solvers with constraint forces.
///
///   C(q) = 0        residual, metres or (sines of) radians
///   J V = dC/dt     V = (velocity, angular velocity) of both bodies, world axes
///   J a = gamma     gamma = -(dJ/dt) V
///
/// [Nelson & Cohen; every row derived for angular velocities, world axes]
#include "engine/base/math.hpp"
#include "engine/joints/joint.hpp"

namespace pantin::detail {

/// State of one body for joint equations: mass-centre pose and motion, world axes.
struct BodyState {
  Vec3 position{0};
  Quat rotation{1, 0, 0, 0};
  Mat3 rotation_matrix{1};  // of `rotation`
  Vec3 velocity{0}, angular_velocity{0};
};

/// A joint and the states of its two bodies.
struct JointState {
  const Joint& joint;
  const BodyState& a;
  const BodyState& b;
  Real before = 0;  // rad: the angle after the last step, so that whole revolutions are counted
};

/// Destination of a block of rows; null pointers are skipped.
///
/// Row i has C at c[i], gamma at gamma[i] and its Jacobian in four vectors from j[4 * i]: velocity
/// and angular velocity of body a, velocity and angular velocity of body b. Kinds that share a
/// point have a compact form in `point`: the arms of a and b, then for each row from 3 on the k of
/// J = (0, k, 0, -k).
struct RowsOut {
  Real* c = nullptr;
  Vec3* j = nullptr;
  Real* gamma = nullptr;
  Vec3* point = nullptr;
};

/// Rows of a joint: ball 3, hinge 5, universal 4, fixed 6, cylindrical 4, prismatic 5, screw 5,
/// planar 3, distance 1, spring 0, custom its own.
int row_count(const Joint& joint);

/// The equations of a joint. A screw needs its angle about x before.
void write_rows(const JointState& at, RowsOut out);

/// A joint coordinate as one row: value at c[0], Jacobian in j[0..3], gamma.
enum class Coordinate : std::uint8_t {
  angle,   // rad, about x: of b relative to a; the value nearest to `before`
  second,  // rad, universal: about z of b
  travel,  // m, along x of a from anchor to anchor; kinds distance and spring: the length
  swing    // ball: 1 minus the elliptic measure of SwingLimit, at least 0 within the cone
};
void write_coordinate(const JointState& at, Coordinate which, RowsOut out);

/// False at a spurious solution of the joint equations (an axis antiparallel to the one it should
/// coincide with).
bool on_right_branch(const Joint& joint, Quat a, Quat b);

}  // namespace pantin::detail
