#pragma once
/// Where joints are: from points and directions in the world to the frames of two bodies. Not
/// installed.
#include <pantin/joints.hpp>

#include "engine/pantin/detail/checks.hpp"
#include "engine/world/solver_list.hpp"
#include "engine/world/ties.hpp"

namespace pantin::detail {

/// A joint's frame in the world, as either body carries it.
struct WorldFrames {
  Pose a, b;
};

/// The two bodies of a joint.
struct JointEnds {
  Entity a, b;
};

/// Rotation whose x and y these unit vectors are; square to one another.
Quat axes_of(Vec3 x, Vec3 y);

/// Joint axes with x along `axis` and y as near to `across` as that allows.
Quat axes_along(Findings& findings, const char* member, Vec3 axis, Vec3 across);

/// Both sides at one place.
WorldFrames at_place(Findings& findings, Vec3 anchor, Quat axes);

/// Both sides as the bodies see them, in the world.
WorldFrames from_local(Findings& findings, const JointEnds& ends, const LocalFrames& local);

/// A joint between bodies as they stand.
Joint make_joint(const World& world, JointKind kind, const JointEnds& ends, const WorldFrames& at);

/// The last step, once nothing is wrong with the description: whether the solver knows it all.
template <class T>
Result<Entity> link(World& world, Findings& findings, const T& described, const Joint& joint) {
  std::vector<Feature> features = features_of(joint);
  if constexpr (requires { described.drive; })
    if (described.drive) features.push_back(Feature::pose_drive);
  findings.known(features, {described.a, described.b});
  if (!findings.ok()) return findings.take();
  const Entity e = add_link(world, {described.a, described.b, joint}, described.name);
  if constexpr (requires { described.drive; })
    if (described.drive) world.joint_drives.add(e, *described.drive);
  return e;
}

}  // namespace pantin::detail
