#pragma once
/// The description of a joint kind. A kind is a struct of static members in a file of its own,
/// named in kinds.hpp; solvers, scene reader, marks and tests read nothing else. `Kind` has the
/// defaults; a kind derives from it and from one of Turns... below.
///
/// A kind needs: name, rows, degrees_of_freedom, write().
#include <span>
#include <string_view>

#include "engine/joints/coordinates.hpp"

namespace pantin::detail {

/// Which relative rotations Q a kind leaves free.
enum class Turns : std::uint8_t {
  freely,     // all
  about_x,    // about x
  about_two,  // about y of a, then about z of b
  nowhere,    // Q = 1
  own         // as the kind's own allowed() and on_right_branch() say
};

/// Who uses a free coordinate besides its limits.
enum CoordinateUse : std::uint8_t {
  kUnused = 0,
  kActuated = 1,  // springs, friction and motors of scene files act along it
  kGeared = 2     // a gear may couple it
};

struct FreeCoordinate {
  Coordinate which;
  std::string_view limit = "";  // key of its limit in scene files, if it has one; a swing has
                                // "swing" too
  int use = kUnused;            // CoordinateUse, or-ed
};

enum class ParameterRange : std::uint8_t { any, not_negative, size };

/// A number that a joint of a kind has, by its key in scene files.
struct Parameter {
  std::string_view key;
  std::string_view needed = "";      // the parameter's meaning, where a file has to give it
  std::string_view about = "";       // its meaning, where it has a default
  std::string_view never_zero = "";  // why, if it must not be 0
  ParameterRange range = ParameterRange::any;
  bool as_placed = false;  // default: the distance of the anchors at the start; one per kind
  Real& (*value)(JointParameters&) = nullptr;
};

/// What the debug view draws at a joint.
enum class Mark : std::uint8_t {
  axis_x,
  axis_y,
  axis_z,          // lines: x of a, y of a, z of b
  angle,           // sector of the angle's limit, or a square where it is locked
  two_angles,      // likewise, of a universal joint
  cone_and_twist,  // likewise, of a ball joint
  lock,            // a square
  translation,     // the line that b's anchor slides along, with its ends
  rod,
  zigzag,  // from anchor to anchor
  slip     // a line at b's anchor, along the direction in which it does not slip
};

inline constexpr int kOwnRows = -1;

struct SlipPoint;

/// The whole description of a kind, by JointKind.
struct JointKindInfo {
  std::string_view name, alias;
  int rows;  // kOwnRows: as own_rows says
  int degrees_of_freedom;
  Turns rotations;
  bool holds_point;
  bool is_line;
  bool uses_axes;
  bool in_files;
  bool counts_turns;
  std::span<const FreeCoordinate> coordinates;
  std::span<const Parameter> parameters;
  std::span<const Mark> marks;
  int (*own_rows)(const Joint&);
  const char* (*fault)(const Joint&);
  Real (*slide_per_turn)(const Joint&);
  Real (*gap)(const Joint&, const Pose& a, const Pose& b);
  void (*complete)(JointParameters&);
  Quat (*allowed)(const JointLimits&, Quat);
  bool (*on_right_branch)(const Mat3&);
  SlipPoint (*slip_point)(const Joint&, const BodyState& a, const BodyState& b);  // see slip.hpp

  /// Whether its rows constrain poses, not velocities only.
  bool binds_poses() const { return slip_point == nullptr; }
  const FreeCoordinate* find(Coordinate which) const {
    for (const FreeCoordinate& c : coordinates)
      if (c.which == which) return &c;
    return nullptr;
  }
  bool is_used(Coordinate which, CoordinateUse use) const {
    const FreeCoordinate* c = find(which);
    return c && (c->use & use) != 0;
  }
  const Parameter* measured() const {
    for (const Parameter& p : parameters)
      if (p.as_placed) return &p;
    return nullptr;
  }
};

namespace joint_kinds {

/// x of a, world axes.
inline Vec3 axis_x_of_a(const Joint& joint, const Pose& a) {
  return a.rotation * (joint.frames.a() * Vec3(1, 0, 0));
}

/// The defaults of a kind.
struct Kind {
  /// Another word for it in scene files.
  static constexpr std::string_view alias = "";
  /// Rows 0 to 2 are those of write_point, all others are AngularRows: RowsOut::point is written.
  static constexpr bool holds_point = false;
  /// Only the line between the anchors counts; scene files may give its ends as points.
  static constexpr bool is_line = false;
  /// The orientation of the joint axes counts.
  static constexpr bool uses_axes = true;
  /// Scene files can describe it.
  static constexpr bool in_files = true;
  /// write() gets a JointState with the angle about x of the last step, so that whole turns are
  /// counted.
  static constexpr bool counts_turns = false;
  static constexpr std::span<const FreeCoordinate> coordinates = {};
  static constexpr std::span<const Parameter> parameters = {};
  static constexpr std::span<const Mark> marks = {};

  /// Rows of one joint, where `rows` is kOwnRows.
  static int own_rows(const Joint&) { return 0; }
  /// Why this joint cannot be solved, or null.
  static const char* fault(const Joint&) { return nullptr; }
  /// Travel per angle, m/rad, where the travel determines the angle; otherwise 0.
  static Real slide_per_turn(const Joint&) { return 0; }
  /// Sets derived parameters.
  static void complete(JointParameters&) {}
  static void write_coordinate(const JointState& at, Coordinate which, RowsOut out) {
    write_axis_coordinate(at, which, out);
  }
};

/// The anchors coincide.
struct SharesPoint : Kind {
  static constexpr bool holds_point = true;
  static Real gap(const Joint& joint, const Pose& a, const Pose& b) {
    return glm::length(residual(joint, a, b));
  }
};

/// b's anchor stays on the line x of a.
struct SlidesAlongX : Kind {
  static constexpr Mark marks[] = {Mark::translation};
  static Real gap(const Joint& joint, const Pose& a, const Pose& b) {
    const Vec3 apart = residual(joint, a, b), x = axis_x_of_a(joint, a);
    return glm::length(apart - glm::dot(apart, x) * x);
  }
};

/// Only the distance of the anchors counts: it is the travel.
struct Line : Kind {
  static constexpr bool is_line = true, uses_axes = false;
  static Real& length(JointParameters& own) { return own.length; }
  static void write_coordinate(const JointState& at, Coordinate which, RowsOut out) {
    if (which == Coordinate::travel)
      return write_length(0, span_of(at.joint, at.a, at.b, out), out);
    Kind::write_coordinate(at, which, out);
  }
};

// allowed(): the rotation nearest to `q` that kind and limits allow. on_right_branch(): false where
// Q, as a matrix, is a spurious root of the rows: an axis antiparallel to the one it should
// coincide with. The second root of a universal joint is the first with both angles half a turn on.

struct TurnsFreely {
  static constexpr Turns rotations = Turns::freely;
  static Quat allowed(const JointLimits& limits, Quat q);
  static bool on_right_branch(const Mat3&) { return true; }
};
struct TurnsAboutX {
  static constexpr Turns rotations = Turns::about_x;
  static Quat allowed(const JointLimits& limits, Quat q);
  static bool on_right_branch(const Mat3& q) { return q[0].x > 0; }
};
struct TurnsAboutTwo {
  static constexpr Turns rotations = Turns::about_two;
  static Quat allowed(const JointLimits& limits, Quat q);
  static bool on_right_branch(const Mat3&) { return true; }
};
struct TurnsNowhere {
  static constexpr Turns rotations = Turns::nowhere;
  static Quat allowed(const JointLimits&, Quat) { return kIdentity; }
  static bool on_right_branch(const Mat3& q) { return q[0].x > 0 && q[1].y > 0; }
};

}  // namespace joint_kinds
}  // namespace pantin::detail
