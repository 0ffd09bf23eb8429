#pragma once
/// Reads back joints, cables and pins, by entity, after the last step of the World.
///
/// Coordinates are those of the joint's description: angle and travel are zero in the pose in which
/// the joint was added (without `frames`). They grow as body b rotates anticlockwise about the axis
/// or moves along it. A quantity that a joint does not have, or an entity that is not a joint,
/// yields NaN.
#include <optional>
#include <pantin/joints.hpp>

#include "engine/world/sensor.hpp"

namespace pantin {

/// The frames of a joint in its bodies, which define its zero. A joint that is removed and added
/// again with `.frames = joint_frames(world, joint)` keeps its angles, limits and springs; one
/// described by anchor and axes restarts at zero. None for joints without frames: distance and
/// spring joints, custom constraints.
std::optional<LocalFrames> joint_frames(const World& world, Entity joint);

/// rad. Hinge, cylindrical, screw and planar joints: the rotation about the axis; ball joints: the
/// twist; universal joints: about axis_a. From -pi to pi; whole turns are counted where the
/// Lagrangian solver needs them.
Real joint_angle(const World& world, Entity joint);
/// rad, universal joints: about axis_b.
Real joint_second_angle(const World& world, Entity joint);
/// Ball joints: the swing of the twist axis from its zero in a, as a rotation vector (axis times
/// angle, rad) in the joint's axes of a; its x is 0.
Vec3 joint_swing(const World& world, Entity joint);
/// rad/s
Real joint_angular_speed(const World& world, Entity joint);
/// m. Prismatic, cylindrical and screw joints: along the axis; distance and spring joints: the
/// length.
Real joint_travel(const World& world, Entity joint);
/// m/s
Real joint_speed(const World& world, Entity joint);

/// The constraint force and torque of a joint, its stops included, on body b; on a the opposite.
/// Mean over the last step, world axes. Springs, motors, friction, joint drives and soft stops are
/// not included.
///
/// Contacts, cables, pins and pushes on the bodies are accounted for. Under the default solver a
/// joint that closes a loop, or anchors a tree again, constrains its point only: its torque is
/// zero, and the other joints of the loop carry it.
struct JointReaction {
  Vec3 force{0};   // N
  Vec3 torque{0};  // N m, about the anchor
};
/// None before the first step, for a copied World that was not stepped, under the solvers "sweep",
/// "shake2" and "procedural", which have no forces, and for an entity that is not a joint or that
/// its solver leaves out. The cost is linear in the bodies of the island.
std::optional<JointReaction> joint_reaction(const World& world, Entity joint);

/// N m, or N along a travel: what the motor of a joint, or its exact drive, exerts along their
/// coordinate. `along`: which, for a joint that rotates and translates; none: the one that has a
/// drive or a motor. Of a drive: mean over the last step. Of a motor: likewise in free motion under
/// the default solver, elsewhere by its law at the end of the step. Without either: NaN.
Real motor_force(const World& world, Entity joint, std::optional<JointCoordinate> along = {});

/// The value of a sensor: in x alone, or three components; NaN where what it measures is gone.
/// Accelerations are differences of velocity since the last reading of the same sensor, which it
/// keeps: the first one is NaN.
Vec3 read_sensor(const World& world, Sensor& sensor);

/// N, mean over the last step; 0 if slack.
Real cable_tension(const World& world, Entity cable);

/// The force of a pin on its body, N, world axes, mean over the last step. None as for joints.
std::optional<Vec3> pin_force(const World& world, Entity pin);

}  // namespace pantin
