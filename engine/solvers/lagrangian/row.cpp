// The Lagrangian solver's row in the table of solvers.
#include <algorithm>

#include "engine/base/invariants.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// Contact forces on the bodies from the last step.
void take_pressures(World& world) {
  std::vector<Island>& all = islands_of(world);
  for (Island& m : all) m.contact_loads.assign(2 * m.count(), Vec3(0));
  for (const contact::Pressure& p : world.memory.of<contact::Memory>().pressures) {
    const Owner owner = owner_of(partition_of(world), world.bodies.slot(p.body));
    if (!owner || owner.solver != kLagrangian) continue;
    std::vector<Vec3>& contact_loads = all[owner.island].contact_loads;
    contact_loads[2 * owner.column] += p.force, contact_loads[2 * owner.column + 1] += p.torque;
  }
}

/// Whole steps; islands that lead interfaces take theirs in repeat().
void predict(World& world, const StepTask& task) {
  take_pressures(world);
  std::vector<Island>& all = islands_of(world);
  for (Island& m : all) m.scratch.in_step = true;
  for_each_island(all.size(), task.threads, [&](std::size_t i) {
    if (all[i].interfaces.empty()) step(world, all[i], task.h);
  });
}

/// An island compiled within a step has been stepped in its previous form, if at all.
void catch_up(World&, const StepTask&) {}
bool has_begun(const World& world, std::size_t island) {
  return islands_of(world)[island].scratch.in_step;
}

// Its bodies have no contact response; they are obstacles for others. They count as asleep, since
// contact detection sees them move.
bool asleep(const World&) { return true; }
void find_reaches(const World&, Real, std::span<Real>) {}
void take_contacts(World&, Real) {}
void adjust(World&, const StepTask&) {}
bool never(const World&, std::size_t) { return false; }
void react(World&, std::size_t, Real, std::vector<contact::Reaction>&) {}
void press(const World&, std::vector<contact::Pressure>&) {}

std::size_t count(const World& world) { return islands_of(world).size(); }

std::span<contact::Interface> interfaces(World& world, std::size_t island) {
  return islands_of(world)[island].interfaces;
}

bool repeat(World& world, std::size_t island, Real h) {
  Island& m = restore_island<Islands>(world, island);
  step(world, m, h);
  return !m.lost;
}

void note_failure(const World& world, StepReport& report) {
  for (const Island& m : islands_of(world))
    if (m.lost && !m.cannot_close && report.status != Status::diverged)
      report.status = Status::diverged, report.body = m.lost, report.residual = m.residual;
}

void report(const World& world, StepReport& report) {
  for (const Island& m : islands_of(world)) {
    report.rows += static_cast<int>(m.equations()), report.rank += static_cast<int>(m.rank);
    report.worst_constraint = std::max(report.worst_constraint, m.residual);
    report.substeps = std::max(report.substeps, m.substeps), report.events += m.events;
    report.rescued += m.rescues > 0;
    for (const Fault& f : m.faults) {
      if (f.kind != Fault::inconsistent || report.status != Status::ok) continue;
      report.status = Status::inconsistent;
      report.worst_residual_at = joint_of(world, m.blocks[f.block]),
      report.worst_residual = f.residual;
    }
  }
}

BodyState state_of(const Body& b) {
  return {b.pose.position, b.pose.rotation, glm::mat3_cast(b.pose.rotation), b.velocity,
          b.angular_velocity};
}

void measure_island(const World& world, const Island& island, Measures& m) {
  for (std::size_t i = 0; i < island.blocks.size(); ++i) {
    const Block& block = island.blocks[i];
    if (block.kind != BlockKind::joint) continue;
    const Real gap = joint_gap(world, island, i);
    if (gap > m.worst_gap) m.worst_gap = gap, m.worst_link = world.links.owners()[block.source];
    m.worst_gap_rel = std::max(m.worst_gap_rel, gap / std::max(island.size, Real(1e-3)));
  }
  for (const JointForce& e : island.joint_forces) {
    const Link& link = world.links.values()[e.link];
    Real x = 0;
    write_coordinate(
        {link.joint, state_of(world.bodies[link.a]), state_of(world.bodies[link.b]), e.before},
        e.coordinate, {&x, nullptr, nullptr});
    const JointParameters& parameters = *link.joint.parameters;
    const SpringDamper& s = e.coordinate == Coordinate::angle ? parameters.rotation.spring
                                                              : parameters.translation.spring;
    m.elastic += 0.5 * s.stiffness * (x - s.rest) * (x - s.rest);
  }
}

bool masses_hold(const Island& m) {
  for (std::size_t i = 0; i < m.count(); ++i)
    if (!is_mass(m.mass[i]) || !is_mass(m.inertia[i])) return false;
  return std::all_of(m.interfaces.begin(), m.interfaces.end(),
                     [](const contact::Interface& i) { return is_mass(kSlackMass * i.mass); });
}

const char* fault(const World& world) {
  for (const Island& m : islands_of(world)) {
    if (m.unfit) continue;
    if (const char* why = settings_fault(m.settings)) return why;
    if (!masses_hold(m)) return "holds a mass that is none";
  }
  return nullptr;
}

void measure(const World& world, Measures& m) {
  for (const Island& island : islands_of(world)) measure_island(world, island, m);
}

}  // namespace

const SolverRow kRow{.name = "lagrangian",
                     .feels_contacts = false,
                     .compile = compile,
                     .prepare = prepare,
                     .predict = predict,
                     .catch_up = catch_up,
                     .has_begun = has_begun,
                     .fault = fault,
                     .asleep = asleep,
                     .find_reaches = find_reaches,
                     .take_contacts = take_contacts,
                     .adjust = adjust,
                     .adjust_touching = adjust,
                     .count = count,
                     .interfaces = interfaces,
                     .follows = never,
                     .touches = never,
                     .save = save_island<Islands>,
                     .repeat = repeat,
                     .react = react,
                     .press = press,
                     .note_failure = note_failure,
                     .report = report,
                     .measure = measure};

}  // namespace pantin::detail::lagrangian
