#include "engine/joints/rows.hpp"

#include "engine/joints/ball.hpp"
#include "engine/joints/custom.hpp"
#include "engine/joints/cylindrical.hpp"
#include "engine/joints/distance.hpp"
#include "engine/joints/fixed.hpp"
#include "engine/joints/hinge.hpp"
#include "engine/joints/planar.hpp"
#include "engine/joints/prismatic.hpp"
#include "engine/joints/screw.hpp"
#include "engine/joints/swing.hpp"
#include "engine/joints/universal.hpp"

namespace pantin {
namespace {

TurnRow turn_row(const Joint& joint, const Placed& a, const Placed& b, Real before) {
  if (joint.kind == JointKind::universal) return universal_first(joint, a, b, before);
  return twist_row(axes_on_a(joint, a), axes_on_b(joint, b), a, b, before);
}

}  // namespace

int row_count(const Joint& joint) {
  constexpr int kRows[kJointKinds] = {
      BallRows::rows,        HingeRows::rows,     UniversalRows::rows, FixedRows::rows,
      CylindricalRows::rows, PrismaticRows::rows, ScrewRows::rows,     PlanarRows::rows,
      DistanceRows::rows,    0,                   0};
  if (joint.kind == JointKind::custom) return CustomRows::rows(joint);
  return kRows[static_cast<int>(joint.kind)];
}

void write_rows(const Joint& joint, const Placed& a, const Placed& b, Real angle_before,
                RowsOut out) {
  switch (joint.kind) {
    case JointKind::ball:
      return BallRows::write(joint, a, b, out);
    case JointKind::hinge:
      return HingeRows::write(joint, a, b, out);
    case JointKind::universal:
      return UniversalRows::write(joint, a, b, out);
    case JointKind::fixed:
      return FixedRows::write(joint, a, b, out);
    case JointKind::cylindrical:
      return CylindricalRows::write(joint, a, b, out);
    case JointKind::prismatic:
      return PrismaticRows::write(joint, a, b, out);
    case JointKind::screw:
      return ScrewRows::write(joint, a, b, angle_before, out);
    case JointKind::planar:
      return PlanarRows::write(joint, a, b, out);
    case JointKind::distance:
      return DistanceRows::write(joint, a, b, out);
    case JointKind::spring:
      return;
    case JointKind::custom:
      return CustomRows::write(joint, a, b, out);
  }
}

void write_coordinate(const Joint& joint, Coordinate which, const Placed& a, const Placed& b,
                      Real before, RowsOut out) {
  switch (which) {
    case Coordinate::turn:
      return write_row(0, turn_row(joint, a, b, before), out);
    case Coordinate::second:
      return write_row(0, universal_second(joint, a, b, before), out);
    case Coordinate::swing:
      return write_row(0, swing_row(joint, a, b), out);
    case Coordinate::slide:
      break;
  }
  const AnchorSpan span = span_of(joint, a, b, out.gamma != nullptr);
  if (joint.kind == JointKind::distance || joint.kind == JointKind::spring)
    return write_length(0, span, out);
  write_along(0, axes_on_a(joint, a).x(), span, a, out);
}

bool on_right_branch(const Joint& joint, Quat a, Quat b) {
  // The universal joint's second root is the first one with both angles half a turn on.
  const Mat3 q = glm::mat3_cast(relative_turn(joint, a, b));
  switch (joint.kind) {
    case JointKind::hinge:
    case JointKind::cylindrical:
    case JointKind::screw:
    case JointKind::planar:
      return q[0].x > 0;
    case JointKind::fixed:
    case JointKind::prismatic:
      return q[0].x > 0 && q[1].y > 0;
    default:
      return true;
  }
}

}  // namespace pantin
