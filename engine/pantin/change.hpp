#pragma once
/// What a program changes in a World that runs: motors, limits, springs, masses, what collides;
/// blows; what sleeps; where things are.
///
///   set_motor(simulation.world, hinge, {MotorKind::velocity, .target = 2, .gain = 50});
///   set_limits(simulation.world, knee, Interval{0, 0.3});
///   impulse(simulation.world, ball, {0, 3, 0}, place);
///
/// A change counts from the next step on; made by a system at before_update or earlier, in the
/// substep that runs. Bodies keep their motion, joints their zero and the turns that they have
/// counted; what is concerned wakes, all else goes on as it was. Numbers are checked as `add`
/// checks them: where something is wrong the errors say what, and nothing is changed.
///
/// Everything is changed in the Simulation's World: it has taken over the one that it was given.
#include <optional>
#include <pantin/joints.hpp>
#include <span>

namespace pantin {

// ---- Joints ----
// `along`: of a joint that turns and slides, which is meant; none: its angle, or the travel of a
// joint that only slides.

/// A motor; MotorKind::none takes it away.
Result<Done> set_motor(World& world, Entity joint, const JointMotor& motor,
                       std::optional<JointCoordinate> along = {});
Result<Done> set_spring(World& world, Entity joint, const SpringDamper& spring,
                        std::optional<JointCoordinate> along = {});
Result<Done> set_friction(World& world, Entity joint, const JointFriction& friction,
                          std::optional<JointCoordinate> along = {});
/// What acts now; what does nothing where there is none.
JointMotor motor_of(const World& world, Entity joint, std::optional<JointCoordinate> along = {});
SpringDamper spring_of(const World& world, Entity joint, std::optional<JointCoordinate> along = {});
JointFriction friction_of(const World& world, Entity joint,
                          std::optional<JointCoordinate> along = {});

/// The range of an angle (rad; ball joints: of the twist; universal joints: about axis_a) or travel
/// (m), or none. A joint outside of it is brought back.
Result<Done> set_limits(World& world, Entity joint, std::optional<Interval> limits,
                        std::optional<JointCoordinate> along = {});
std::optional<Interval> limits_of(const World& world, Entity joint,
                                  std::optional<JointCoordinate> along = {});
/// Of universal joints: about axis_b.
Result<Done> set_second_limits(World& world, Entity joint, std::optional<Interval> limits);
/// Of ball joints: how far the axis may swing.
Result<Done> set_cone(World& world, Entity joint, std::optional<ConeLimit> cone);
Result<Done> set_soft_stop(World& world, Entity joint, std::optional<SoftStop> soft_stop);
/// The joint drive, or none. The World has it as `world.joint_drives.find(joint)`, whose target may
/// be written at any time.
Result<Done> set_drive(World& world, Entity joint, std::optional<JointDrive> drive);

/// How a body is turned in a pose: the frame that it was placed by, against any frame that is the
/// same for all bodies of the pose.
struct BodyTurn {
  Entity body = {};
  Quat rotation{1, 0, 0, 0};
};

/// Has joints follow a pose: each gets a joint drive like `muscles`, towards how its bodies are
/// turned to one another in the pose. A joint whose bodies are not both named is left alone. Called
/// again as the pose moves; with a strength that grows from 0 and falls back to it a figure blends
/// into an animation and out of it:
///
///   follow(world, doll.joints(), pose, {.stiffness = part * 300, .damping = part * 30});
Result<Done> follow(World& world, std::span<const Entity> joints, std::span<const BodyTurn> pose,
                    const JointDrive& muscles);

/// m, above 0: a winch that turns at once.
Result<Done> set_cable_length(World& world, Entity cable, Real length);
/// m; NaN of what is no cable.
Real cable_length(const World& world, Entity cable);

// ---- Bodies ----

/// kg; the moments of inertia change with it, as by another density.
Result<Done> set_mass(World& world, Entity body, Real mass);
Result<Done> set_gravity_scale(World& world, Entity body, Real scale);
/// 1/s
Result<Done> set_drag(World& world, Entity body, Real drag);
/// How a body collides, or that it does not. What lay on it wakes.
Result<Done> set_collision(World& world, Entity body, const std::optional<Collision>& collision);

/// A blow: N s, world axes, at a point of the world. It acts on a dynamic body, and through its
/// joints and contacts on others, within the next substep.
Result<Done> impulse(World& world, Entity body, Vec3 impulse, Vec3 point);

/// Wakes a body and all that rests with it; false if it did not sleep.
bool wake(World& world, Entity body);

/// Two bodies do not collide for so long, s; for good: infinity. From the call on; a second call
/// for the same bodies replaces the first one, and 0 ends it.
Result<Done> ignore(World& world, Entity a, Entity b, Real seconds);

/// Moves bodies as one, at once: the frame of the first comes to `to`, velocities turn along.
/// Nothing is drawn on the way. An error if a joint or pin to what stays would be torn.
///
///   teleport(world, doll.bodies(), {{0, 1, 4}, rotation});
Result<Done> teleport(World& world, std::span<const Entity> bodies, const Pose& to);

}  // namespace pantin
