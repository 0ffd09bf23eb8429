#pragma once
/// Places joints: from points and directions in the world to frames in two bodies. Not installed.
#include <pantin/joints.hpp>

#include "engine/pantin/detail/checks.hpp"
#include "engine/world/solver_list.hpp"
#include "engine/world/ties.hpp"

namespace pantin::detail {

/// The frame of a joint in world space, as each of its bodies carries it.
struct WorldFrames {
  Pose a, b;
};

/// The two bodies of a joint.
struct JointEnds {
  Entity a, b;
};

/// The rotation whose x and y axes are these perpendicular unit vectors.
Quat axes_of(Vec3 x, Vec3 y);

/// Joint axes with x along `axis` and y as near to `across` as that allows.
Quat axes_along(Findings& findings, const char* member, Vec3 axis, Vec3 across);

/// Both sides at the same anchor and axes.
WorldFrames at_place(Findings& findings, Vec3 anchor, Quat axes);

/// Both sides, from frames in the bodies to world space.
WorldFrames from_local(Findings& findings, const JointEnds& ends, const LocalFrames& local);

/// A joint between two bodies at their present poses.
Joint make_joint(const World& world, JointKind kind, const JointEnds& ends, const WorldFrames& at);

/// The last step, if the description has no errors: checks that the solver supports all of it.
template <class T>
Result<Entity> link(World& world, Findings& findings, const T& described, const Joint& joint) {
  std::vector<Feature> features = features_of(joint);
  if constexpr (requires { described.drive; })
    if (described.drive) features.push_back(feature_of(*described.drive));
  if constexpr (requires { described.drive; })
    if (described.drive) check_drive(findings, *described.drive, joint.kind);
  findings.known(features, {described.a, described.b});
  if (!findings.ok()) return findings.take();
  const Entity e = add_link(world, {described.a, described.b, joint}, described.name);
  if constexpr (requires { described.drive; })
    if (described.drive) fit_spline(world.joint_drives.add(e, *described.drive).motion);
  return e;
}

}  // namespace pantin::detail
