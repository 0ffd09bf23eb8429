// Springs, friction and motors along joint coordinates: as explicit forces, or as compliant rows.
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/solvers/lagrangian/integrator.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// A row with a smaller relative effect on its rate per step is treated as a plain force.
constexpr Real kMinRelativeStiffness = 1e-10;

/// J M^-1 J^T of a row.
Real mobility(const Island& m, const Block& b, std::size_t row = 0) {
  Real sum = 0;
  for (std::size_t k = 0; k < b.count; ++k) {
    if (b.body[k] >= m.count()) continue;
    const RowVectors j = row_of(b, jacobian_of(m, b), row, k);
    sum += glm::dot(j.v, j.v) / m.mass[b.body[k]] +
           glm::dot(j.w, m.scratch.inverse_inertia[b.body[k]] * j.w);
  }
  return sum;
}

const Dof& dof_of(const World& world, std::uint32_t link, Coordinate which) {
  const JointParameters& parameters = *world.links.values()[link].joint.parameters;
  return which == Coordinate::angle ? parameters.rotation : parameters.translation;
}

}  // namespace

namespace {

/// The motor alone.
Dof motor_of(const Dof& dof) {
  Dof motor;
  motor.motor = dof.motor;
  return motor;
}
bool is_at_bound(const LinearisedForce& motor) {
  return motor.stiffness == 0 && motor.damping == 0;
}

/// Slopes of a spring row over a collocation step. A motor at its bound has none; one that leaves
/// its bound within the step has its slopes there.
LinearisedForce linearise_over_step(const World& world, const Island& m, const Block& b) {
  PANTIN_ASSERT(b.kind == BlockKind::spring);
  const Dof& dof = dof_of(world, b.source, b.coordinate);
  const Real coordinate = m.scratch.c[b.first_row], rate = rate_of(m, b, 0);
  LinearisedForce p = linearise(dof, coordinate, rate, Slope::tangent);
  Dof motor = motor_of(dof);
  const Real h = m.scratch.collocation.h, end = rate + h * mobility(m, b) * p.force;
  const LinearisedForce now = linearise(motor, coordinate, rate, Slope::tangent);
  if (!is_at_bound(now) ||
      linearise(motor, coordinate + h * end, end, Slope::tangent).force == now.force)
    return p;
  motor.motor.cap = 1e300;
  const LinearisedForce then = linearise(motor, coordinate, rate, Slope::tangent);
  p.stiffness += then.stiffness, p.damping += then.damping;
  return p;
}

/// The same for the three rows of a torque.
void find_torque_slopes(const World& world, const Island& m, const Block& b,
                        const ForceSlopes& slopes) {
  const JointTorque of = torque_of(world, m, {b.source, {b.body[0], b.body[1]}});
  for (std::size_t r = 0; r < b.rows; ++r) {
    const std::size_t row = b.first_row + r;
    slopes.stiffness[row] = glm::dot(of.axes[r], of.stiffness * of.axes[r]);
    slopes.damping[row] = glm::dot(of.axes[r], of.damping * of.axes[r]);
    slopes.mobility[row] = mobility(m, b, r);
  }
}

}  // namespace

void find_force_slopes(const World& world, Island& m, const ForceSlopes& slopes) {
  for (const Block& b : m.blocks) {
    if (!is_compliant(b.kind)) continue;
    PANTIN_ASSERT(slopes.stiffness.size() == m.rows && slopes.damping.size() == m.rows &&
                  slopes.mobility.size() == m.rows);
    LinearisedForce p;
    if (b.kind == BlockKind::spring) {
      p = linearise_over_step(world, m, b);
    } else if (b.kind == BlockKind::elastic_cable) {
      const CableParameters& s = world.cables.values()[b.source].joint;
      if (m.scratch.c[b.first_row] > s.length) p.stiffness = stiffness_of(s);
    } else if (b.kind == BlockKind::elastic_pin) {
      const Pin& pin = world.pins.values()[b.source];
      p.stiffness = pin.stiffness, p.damping = pin.damping;
    }
    if (b.kind == BlockKind::joint_torque) {
      find_torque_slopes(world, m, b, slopes);
      continue;
    }
    for (std::size_t r = 0; r < b.rows; ++r) {
      const std::size_t row = b.first_row + r;
      slopes.stiffness[row] = p.stiffness, slopes.damping[row] = p.damping;
      slopes.mobility[row] = mobility(m, b, r);
    }
  }
}

CoordinateRow coordinate_row(const World& world, const Island& m, const JointForce& of) {
  CoordinateRow row;
  const BodyState &at_a = m.scratch.body_states[of.body[0]],
                  &at_b = m.scratch.body_states[of.body[1]];
  PANTIN_ASSERT(of.body[0] < m.scratch.body_states.size() &&
                of.body[1] < m.scratch.body_states.size());
  write_coordinate({world.links.values()[of.link].joint, at_a, at_b, of.before}, of.coordinate,
                   {&row.value, row.j, &row.gamma});
  row.rate = glm::dot(row.j[0], at_a.velocity) + glm::dot(row.j[1], at_a.angular_velocity) +
             glm::dot(row.j[2], at_b.velocity) + glm::dot(row.j[3], at_b.angular_velocity);
  return row;
}

void add_joint_forces(const World& world, Island& m) {
  for (const JointForce& e : m.joint_forces) {
    const CoordinateRow row = coordinate_row(world, m, e);
    const Dof& dof = dof_of(world, e.link, e.coordinate);
    const Real force = linearise(dof, row.value, row.rate, Slope::tangent).force;
    for (std::size_t k = 0; k < 2; ++k)
      if (e.body[k] < m.count())
        m.scratch.force[2 * e.body[k]] += force * row.j[2 * k],
            m.scratch.force[2 * e.body[k] + 1] += force * row.j[2 * k + 1];
  }
}

namespace {

/// Stiffness of a force along the coordinate `of` of two bodies.
Stiffness stiffness_of(const Island& m, const CoordinateRow& row, const JointForce& of,
                       const Dof& dof) {
  Real mobile = 0;
  for (std::size_t k = 0; k < 2; ++k)
    if (of.body[k] < m.count())
      mobile +=
          glm::dot(row.j[2 * k], row.j[2 * k]) / m.mass[of.body[k]] +
          glm::dot(row.j[2 * k + 1], m.scratch.inverse_inertia[of.body[k]] * row.j[2 * k + 1]);
  const LinearisedForce p = linearise(dof, row.value, row.rate, Slope::tangent);
  return {mobile * p.stiffness, mobile * p.damping};
}

}  // namespace

Stiffness stiffness_of(const World& world, const Island& m) {
  Stiffness most;
  for (const JointForce& e : m.joint_forces) {
    const Stiffness one =
        stiffness_of(m, coordinate_row(world, m, e), e, dof_of(world, e.link, e.coordinate));
    most.spring = std::max(most.spring, one.spring);
    most.damper = std::max(most.damper, one.damper);
  }
  return most;
}

Entity too_stiff_joint(const World& world, std::size_t number, Real h) {
  const IntegratorRow& by = row_of(islands_of(world)[number].settings.integrator);
  const bool divides = by.step_estimated && islands_of(world)[number].settings.step_tolerance > 0;
  if (!by.efforts_are_forces || divides) return {};
  Island m = islands_of(world)[number];
  place_for_inspection(world, m, h);
  Entity found;
  Real most = 0;
  for (const JointForce& e : m.joint_forces) {
    // A motor at its bound leaves it sooner or later.
    Dof dof = dof_of(world, e.link, e.coordinate);
    dof.motor.cap = 1e300;
    const Stiffness one = stiffness_of(m, coordinate_row(world, m, e), e, dof);
    if (!one.is_long(h / kMostParts)) continue;
    const Real rate = std::max(one.damper, std::sqrt(one.spring));
    if (rate > most) most = rate, found = world.links.owners()[e.link];
  }
  return found;
}

void write_joint_force_rows(const World& world, Island& m, std::span<Real> requested,
                            const ImplicitForce& by) {
  for (const Block& b : m.blocks) {
    if (b.kind != BlockKind::spring) continue;
    const Dof& f = dof_of(world, b.source, b.coordinate);
    const LinearisedForce p = linearise(f, m.scratch.c[b.first_row], rate_of(m, b, 0), by.slope);
    const Real effective_stiffness = p.stiffness * by.by_way + p.damping * by.by_speed;
    m.scratch.weights[b.first_row] =
        1 / std::max(effective_stiffness,
                     kMinRelativeStiffness / std::max(mobility(m, b), Real(1e-300)));
    requested[b.first_row] = p.force;
  }
}

namespace {

/// The force of a motor that contacts hold at its bound.
struct HeldMotor {
  bool is_held = false;
  Real force = 0;  // N or N m
};
HeldMotor held_motor(const Island& m, const Block& b) {
  if (!m.scratch.in_parts || std::isnan(m.scratch.held[b.first_row])) return {};
  return {true, m.scratch.held[b.first_row]};
}

}  // namespace

bool hold_motors(const World& world, Island& m) {
  bool changes = false;
  for (const Block& b : m.blocks) {
    if (b.kind != BlockKind::spring) continue;
    const Dof motor = motor_of(dof_of(world, b.source, b.coordinate));
    if (motor.motor.kind == MotorKind::none) continue;
    const LinearisedForce p =
        linearise(motor, m.scratch.c[b.first_row], rate_of(m, b, 0), Slope::tangent);
    const bool is_bound = is_at_bound(p);
    Real& held = m.scratch.held[b.first_row];
    changes = changes || is_bound == std::isnan(held);
    held = is_bound ? p.force : std::numeric_limits<Real>::quiet_NaN();
  }
  return changes;
}

void write_joint_force_rows_at_end(const World& world, Island& m, std::span<Real> right, Real h) {
  for (const Block& b : m.blocks) {
    if (b.kind != BlockKind::spring) continue;
    const HeldMotor held = held_motor(m, b);
    Dof f = dof_of(world, b.source, b.coordinate);
    if (held.is_held) f.motor = {};
    const Real rate = rate_of(m, b, 0), mobile = std::max(mobility(m, b), Real(1e-300));
    LinearisedForce p = linearise(f, m.scratch.c[b.first_row], rate, Slope::secant);
    // A force that is saturated now and at the end of the step is constant.
    const Real end = rate + h * mobile * p.force;
    if (linearise(f, m.scratch.c[b.first_row] + h * end, end, Slope::secant).force == p.force)
      p.stiffness = p.damping = 0;
    p.force += held.force;
    const Real least = kMinRelativeStiffness / (h * mobile);
    const Real effective_stiffness = std::max(h * p.stiffness + p.damping, least);
    m.scratch.weights[b.first_row] = 1 / (h * effective_stiffness);
    right[b.first_row] +=
        (p.force + (effective_stiffness - h * p.stiffness) * rate) / effective_stiffness;
  }
}

}  // namespace pantin::detail::lagrangian
