#include "engine/solvers/motor_gains.hpp"

#include <algorithm>

#include "engine/joints/kinds.hpp"
#include "engine/solvers/lagrangian/internal.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail {
namespace {

using lagrangian::Block;
using lagrangian::BlockKind;
using lagrangian::CoordinateRow;
using lagrangian::Island;
using lagrangian::JointForce;

/// s: at the present state its length does not matter.
constexpr Real kInspectionStep = 1e-3;
/// A coordinate with less than this fraction of the mobility of its two bodies alone is locked.
constexpr Real kLocked = 1e-9;

bool is_open(const JointMotor& motor) { return motor.kind != MotorKind::none && motor.gain == 0; }

const Dof& dof_of(const Joint& joint, Coordinate which) {
  const JointParameters& own = *joint.parameters;
  return which == Coordinate::angle ? own.rotation : own.translation;
}

bool has_open_motor(const Joint& joint) {
  return joint.parameters.any() && (is_open(joint.parameters->rotation.motor) ||
                                    is_open(joint.parameters->translation.motor));
}

/// A copy whose islands belong to `lagrangian`, with the coordinates of all motors locked.
World locked_copy(const World& world) {
  World w = world;
  w.default_settings.solver = Solver::lagrangian;
  for (SolverSettings& settings : w.settings.values()) settings.solver = Solver::lagrangian;
  const AngleLimit lock{true, 0, 0};
  for (Link& link : w.links.values()) {
    if (!link.joint.parameters.any()) continue;
    JointParameters& own = link.joint.parameters.edit();
    if (own.rotation.motor.kind != MotorKind::none) link.joint.limits.edit().angle = lock;
    if (own.translation.motor.kind != MotorKind::none) own.travel = lock;
  }
  w.mark_dirty();
  compile_if_changed(w);
  return w;
}

/// The lock of a motor's coordinate; null if its kind of joint cannot be locked.
Block* lock_of(Island& m, const JointForce& motor) {
  for (Block& b : m.blocks)
    if (b.kind == BlockKind::limit && b.lock && b.source == motor.link &&
        b.coordinate == motor.coordinate)
      return &b;
  return nullptr;
}

/// Acceleration along a coordinate by a unit force, if its two bodies were free.
Real mobility_alone(const Island& m, const JointForce& along, const CoordinateRow& row) {
  Real sum = 0;
  for (std::size_t k = 0; k < 2; ++k)
    if (const std::uint32_t b = along.body[k]; b < m.count())
      sum += glm::dot(row.j[2 * k], row.j[2 * k]) / m.mass[b] +
             glm::dot(row.j[2 * k + 1], m.scratch.inverse_inertia[b] * row.j[2 * k + 1]);
  return sum;
}

/// kg m^2, or kg.
Real inertia_along(const World& world, Island& m, const JointForce& motor) {
  Block* lock = lock_of(m, motor);
  if (lock) lock->lock = false;
  write_all_rows(world, m, {true, true});
  factor(m);
  if (lock) lock->lock = true;
  const CoordinateRow row = coordinate_row(world, m, motor);
  std::fill(m.scratch.force.begin(), m.scratch.force.end(), Vec3(0));
  std::fill(m.scratch.right.begin(), m.scratch.right.end(), 0.0);
  for (std::size_t k = 0; k < 4; ++k)
    if (const std::uint32_t b = motor.body[k / 2]; b < m.count())
      m.scratch.force[2 * b + k % 2] += row.j[k];
  solve(m, {m.scratch.force, m.scratch.right},
        {std::span(m.scratch.motion).first(2 * m.count()), m.scratch.lambda});
  Real mobility = 0;
  for (std::size_t k = 0; k < 4; ++k)
    if (const std::uint32_t b = motor.body[k / 2]; b < m.count())
      mobility += glm::dot(row.j[k], m.scratch.motion[2 * b + k % 2]);
  const Real alone = mobility_alone(m, motor, row);
  return 1 / (mobility > kLocked * alone ? mobility : alone);
}

void set_gain(JointMotor& motor, Real inertia, Real h) {
  const Real bandwidth = 2 / h;
  if (motor.kind == MotorKind::velocity) {
    motor.gain = inertia * bandwidth;
    return;
  }
  motor.gain = inertia * bandwidth * bandwidth;
  motor.damping = 2 * inertia * bandwidth;
}

}  // namespace

bool has_open_motors(const World& world) {
  return std::any_of(world.links.values().begin(), world.links.values().end(),
                     [](const Link& link) { return has_open_motor(link.joint); });
}

void choose_motor_gains(World& world, Real h) {
  const Partition& now = partition_of(world);
  const bool is_built = now.built_for != 0 && now.built_for == world.structure();
  if (is_built ? !now.has_open_motors : !has_open_motors(world)) return;
  World locked = locked_copy(world);
  for (Island& m : lagrangian::islands_of(locked)) {
    const auto open = [&](const JointForce& f) {
      return is_open(dof_of(locked.links.values()[f.link].joint, f.coordinate).motor);
    };
    if (m.unfit || std::none_of(m.joint_forces.begin(), m.joint_forces.end(), open)) continue;
    lagrangian::place_for_inspection(locked, m, kInspectionStep);
    for (const JointForce& f : m.joint_forces) {
      if (!open(f)) continue;
      const Real inertia = inertia_along(locked, m, f);
      JointParameters& own = world.links[locked.links.owners()[f.link]].joint.parameters.edit();
      if (std::isfinite(inertia) && inertia > 0)
        set_gain(f.coordinate == Coordinate::angle ? own.rotation.motor : own.translation.motor,
                 inertia, h);
    }
  }
  world.memory.of<Partition>().has_open_motors = false;
}

}  // namespace pantin::detail
