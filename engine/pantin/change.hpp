#pragma once
/// Changes to a running World: motors, limits, springs, masses, collision; impulses; sleep; poses.
///
///   set_motor(simulation.world, hinge, {MotorKind::velocity, .target = 2, .gain = 50});
///   set_limits(simulation.world, knee, Interval{0, 0.3});
///   impulse(simulation.world, ball, {0, 3, 0}, place);
///
/// A change applies from the next step on; one made by a system at before_update or earlier applies
/// to the current substep. Bodies keep their motion, joints keep their zero and the whole turns
/// they have counted. The bodies concerned wake; all others continue unchanged. Values are checked
/// as by `add`: on errors, nothing is changed.
///
/// Always change the Simulation's own World: it took over the one that it was given.
#include <optional>
#include <pantin/joints.hpp>
#include <span>

namespace pantin {

// ---- Joints ----
// `along`: the coordinate, for a joint that rotates and translates; none: its angle, or its travel
// if it has no angle.

/// Sets the motor; MotorKind::none removes it.
Result<Done> set_motor(World& world, Entity joint, const JointMotor& motor,
                       std::optional<JointCoordinate> along = {});
Result<Done> set_spring(World& world, Entity joint, const SpringDamper& spring,
                        std::optional<JointCoordinate> along = {});
Result<Done> set_friction(World& world, Entity joint, const JointFriction& friction,
                          std::optional<JointCoordinate> along = {});
/// The present law; a neutral one if there is none.
JointMotor motor_of(const World& world, Entity joint, std::optional<JointCoordinate> along = {});
SpringDamper spring_of(const World& world, Entity joint, std::optional<JointCoordinate> along = {});
JointFriction friction_of(const World& world, Entity joint,
                          std::optional<JointCoordinate> along = {});

/// The range of an angle (rad; ball joints: the twist; universal joints: about axis_a) or travel
/// (m), or none. A joint outside its range is brought back.
Result<Done> set_limits(World& world, Entity joint, std::optional<Interval> limits,
                        std::optional<JointCoordinate> along = {});
std::optional<Interval> limits_of(const World& world, Entity joint,
                                  std::optional<JointCoordinate> along = {});
/// Of universal joints: about axis_b.
Result<Done> set_second_limits(World& world, Entity joint, std::optional<Interval> limits);
/// Of ball joints: the cone that limits the swing.
Result<Done> set_cone(World& world, Entity joint, std::optional<ConeLimit> cone);
Result<Done> set_soft_stop(World& world, Entity joint, std::optional<SoftStop> soft_stop);
/// Sets the joint drive, or removes it. It is `world.joint_drives.find(joint)`, whose target may be
/// written at any time.
Result<Done> set_drive(World& world, Entity joint, std::optional<JointDrive> drive);

/// The rotation of a body in a pose: of the frame that the body was placed by, relative to any
/// frame common to all bodies of the pose.
struct BodyTurn {
  Entity body = {};
  Quat rotation{1, 0, 0, 0};
};

/// Makes joints follow a pose: each gets a joint drive like `muscles`, whose target is the relative
/// rotation of its bodies in the pose. A joint is skipped unless both bodies are in the pose. Call
/// it again as the pose moves. Stiffness that grows from 0 and falls back to 0 blends into an
/// animation and out of it:
///
///   follow(world, doll.joints(), pose, {.stiffness = part * 300, .damping = part * 30});
Result<Done> follow(World& world, std::span<const Entity> joints, std::span<const BodyTurn> pose,
                    const JointDrive& muscles);

/// Sets the length of a cable, m, above 0: a winch without delay.
Result<Done> set_cable_length(World& world, Entity cable, Real length);
/// m; NaN if the entity is not a cable.
Real cable_length(const World& world, Entity cable);

// ---- Bodies ----

/// kg; the moments of inertia are scaled with it, as if the density changed.
Result<Done> set_mass(World& world, Entity body, Real mass);
Result<Done> set_gravity_scale(World& world, Entity body, Real scale);
/// 1/s
Result<Done> set_drag(World& world, Entity body, Real drag);
/// Sets the collision of a body, or removes it. Bodies that rested on it wake.
Result<Done> set_collision(World& world, Entity body, const std::optional<Collision>& collision);

/// Applies an impulse, N s, world axes, at a point of the world. It acts on a dynamic body, and
/// through joints and contacts on others, within the next substep.
Result<Done> impulse(World& world, Entity body, Vec3 impulse, Vec3 point);

/// Wakes a body and its whole island; returns false if it was awake.
bool wake(World& world, Entity body);

/// Two bodies do not collide for this time from now on, s; infinity: for good. A second call for
/// the same bodies replaces the first, and 0 ends it.
Result<Done> ignore(World& world, Entity a, Entity b, Real seconds);

/// Moves bodies together at once: the frame of the first arrives at `to`, velocities rotate along.
/// No poses in between are drawn. An error if a joint or pin to another body would be torn.
///
///   teleport(world, doll.bodies(), {{0, 1, 4}, rotation});
Result<Done> teleport(World& world, std::span<const Entity> bodies, const Pose& to);

}  // namespace pantin
