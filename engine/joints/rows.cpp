#include "engine/joints/rows.hpp"

#include "engine/base/invariants.hpp"
#include "engine/joints/kinds.hpp"

namespace pantin::detail {

int row_count(const Joint& joint) {
  const JointKindInfo& info = info_of(joint.kind);
  return info.rows == kOwnRows ? info.own_rows(joint) : info.rows;
}

void write_rows(const JointState& at, RowsOut out) {
#define PANTIN_CASE(kind) \
  case JointKind::kind:   \
    return joint_kinds::write<joint_kinds::kind>(at, out);
  switch (at.joint.kind) { PANTIN_JOINT_KINDS(PANTIN_CASE) }
#undef PANTIN_CASE
}

void write_axis_coordinate(const JointState& at, Coordinate which, RowsOut out) {
  const auto& [joint, a, b, before] = at;
  switch (which) {
    case Coordinate::angle:
      return write_row(0, twist_row(joint, a, b, before), out);
    case Coordinate::second:
      return write_row(0, universal_second(joint, a, b, before), out);
    case Coordinate::swing:
      return write_row(0, swing_row(joint, a, b), out);
    case Coordinate::travel:
      break;
  }
  write_along(0, axes_on_a(joint, a).x(), span_of(joint, a, b, out), out);
}

void write_coordinate(const JointState& at, Coordinate which, RowsOut out) {
#define PANTIN_CASE(kind) \
  case JointKind::kind:   \
    return joint_kinds::kind::write_coordinate(at, which, out);
  switch (at.joint.kind) { PANTIN_JOINT_KINDS(PANTIN_CASE) }
#undef PANTIN_CASE
}

bool on_right_branch(const Joint& joint, Quat a, Quat b) {
  PANTIN_ASSERT(is_unit(a) && is_unit(b));
  return info_of(joint.kind).on_right_branch(glm::mat3_cast(relative_rotation(joint, a, b)));
}

}  // namespace pantin::detail
