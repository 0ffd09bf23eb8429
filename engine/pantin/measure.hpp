#pragma once
/// What joints, cables and pins do, by entity, as the World stands after its last step.
///
/// Coordinates are those of the joint's description: angle and travel are zero in the pose it was
/// added in (frames aside) and grow as body b turns anticlockwise about the axis or moves along it.
/// Asking for what a joint does not have, or asking an entity that is no joint, gives no number:
/// NaN.
#include <optional>
#include <pantin/joints.hpp>

namespace pantin {

/// The frames of a joint in its bodies. They are its zero: a joint that is taken away and added
/// again with `.frames = joint_frames(world, joint)` has the angles, limits and springs that it
/// had, where one described by anchor and axes is at zero as it is added. None of what has no
/// frames: distance and spring joints, custom constraints.
std::optional<LocalFrames> joint_frames(const World& world, Entity joint);

/// rad. Hinge, cylindrical, screw and planar joints: the rotation about the axis; ball joints: the
/// twist; universal joints: about axis_a. From -pi to pi; where the Lagrangian solver needs it,
/// whole turns are counted.
Real joint_angle(const World& world, Entity joint);
/// rad, universal joints: about axis_b.
Real joint_second_angle(const World& world, Entity joint);
/// Ball joints: the swing of the twist axis from its place in a, as a rotation vector (axis times
/// angle, rad) in the joint's axes of a; its x is 0.
Vec3 joint_swing(const World& world, Entity joint);
/// rad/s
Real joint_angular_speed(const World& world, Entity joint);
/// m. Prismatic, cylindrical and screw joints: along the axis; distance and spring joints: the
/// length.
Real joint_travel(const World& world, Entity joint);
/// m/s
Real joint_speed(const World& world, Entity joint);

/// What a joint, its stops included, does to its body b; to a the opposite. Mean over the last
/// step, world axes. Springs, motors, friction, joint drives and soft stops are not in it.
///
/// Contacts, cables, pins and pushes on the bodies are accounted for. Under the default solver a
/// joint that closes a loop, or holds a tree a second time, holds its point only: its torque is
/// zero, and the other joints of the loop bear what it could.
struct JointReaction {
  Vec3 force{0};   // N
  Vec3 torque{0};  // N m, about the anchor
};
/// None before the first step, for a copied World that was not stepped, under the solvers "sweep",
/// "shake2" and "procedural", which know no forces, and for what is no joint or is left out by its
/// solver. A question costs time linear in the bodies of the island.
std::optional<JointReaction> joint_reaction(const World& world, Entity joint);

/// N, mean over the last step; 0 when slack.
Real cable_tension(const World& world, Entity cable);

/// N, world axes: what a pin does to its body, mean over the last step. None as for joints.
std::optional<Vec3> pin_force(const World& world, Entity pin);

}  // namespace pantin
