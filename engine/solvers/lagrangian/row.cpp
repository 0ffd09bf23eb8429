// The Lagrangian solver's row in the table of solvers.
#include <algorithm>

#include "engine/base/invariants.hpp"
#include "engine/base/rotation.hpp"
#include "engine/contact/detect.hpp"
#include "engine/solvers/lagrangian/contacts.hpp"
#include "engine/solvers/lagrangian/internal.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/world/joint_coordinate.hpp"
#include "engine/world/surface_start.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// Takes whole steps.
void predict(World& world, const StepTask& task) {
  ContactScratch& contacts = world.memory.of<Islands>().contacts;
  contacts.unsolved = 0, contacts.unsolved_at = Entity{};
  std::vector<Island>& all = islands_of(world);
  for_each_island(all.size(), task, [&](std::size_t i) { step(world, all[i], task.h); });
}

/// Whether nothing moves or was moved.
bool asleep(const World& world) {
  for (const Island& m : islands_of(world))
    for (std::size_t b = 0; b < m.count(); ++b) {
      if (m.driven) return false;
      const Body& body = world.bodies.values()[m.slots[b]];
      if (contact::moves(body) || body.restart || body.teleport) return false;
      if (m.scratch.stepped && m.scratch.entry.x[b] != body.pose.position) return false;
    }
  return true;
}

/// Bound on the displacement of a body's surface in the step: that of the last step and that of its
/// velocity, with a margin for contacts.
Real reach_of(const World& world, const Island& m, std::size_t b, Real h) {
  const Shapes* shapes = world.shapes.find(m.bodies[b]);
  if (!shapes) return 0;
  const Real extent = contact::extent_of(*shapes);
  const Body& body = world.bodies.values()[m.slots[b]];
  const Real margin = 0.02 * extent + glm::length(world.gravity) * h * h;
  Real way = h * glm::length(body.velocity), turn = h * glm::length(body.angular_velocity);
  if (m.scratch.stepped) {
    const Quat turned = body.pose.rotation * glm::conjugate(m.scratch.entry.q[b]);
    way = std::max(way, glm::length(body.pose.position - m.scratch.entry.x[b]));
    turn = std::max(turn, glm::length(rotation_vector(turned)));
  }
  const Real reach = contact::kReachFactor * (way + extent * turn) + margin;
  return std::isfinite(reach) ? reach : 0;
}

contact::Displacement displacement_of(const World& world, const Island& m, std::size_t b, Real h) {
  const Body& body = world.bodies.values()[m.slots[b]];
  if (!m.scratch.stepped) return {h * body.velocity, h * body.angular_velocity};
  const Quat turned = body.pose.rotation * glm::conjugate(m.scratch.entry.q[b]);
  return {body.pose.position - m.scratch.entry.x[b], rotation_vector(turned)};
}

bool is_solid(const World& world, Entity body) {
  const Collision* collision = world.collisions.find(body);
  return collision && !collision->sensor;
}

void find_reaches(const World& world, Real h, const contact::Reaches& out) {
  for (const Island& m : islands_of(world))
    for (std::size_t b = 0; b < m.count(); ++b)
      if (is_solid(world, m.bodies[b])) {
        out.reach[m.slots[b]] = reach_of(world, m, b, h);
        out.displacement[m.slots[b]] = displacement_of(world, m, b, h);
      }
}

void find_starts(const World& world, std::vector<contact::StartPose>& out) {
  for (const Island& m : islands_of(world))
    for (std::size_t b = 0; b < m.count() && m.scratch.stepped; ++b)
      if (is_solid(world, m.bodies[b]))
        out.push_back({m.slots[b], {m.scratch.entry.x[b], m.scratch.entry.q[b]}});
}

bool is_own(const World& world, std::uint32_t slot) {
  const Owner owner = owner_of(partition_of(world), slot);
  return owner && owner.solver == kLagrangian;
}

/// Takes the contacts of this solver's bodies; those that stay unresolved have no force.
void take_contacts(World& world, Real) {
  for (Contact& c : contacts_of(world))
    if (is_own(world, c.slot_a)) c.active = false, c.force = Vec3(0), c.depth = 0;
}

void adjust(World& world, const StepTask& task) {
  std::vector<Island>& all = islands_of(world);
  for (Island& m : all)
    if (m.driven && !m.lost) release_drives(world, m);
  resolve_contacts(world, task.h);
  for (Island& m : all)
    if (m.driven && !m.lost) note_drives(world, m);
}

void note_failure(const World& world, StepReport& report) {
  for (const Island& m : islands_of(world))
    if (m.lost && m.lost_contact) {
      report.status = Status::contact_lost, report.body = m.lost, report.contact = m.lost_contact;
      report.contact_fault = nurbs::word_of(m.lost_how);
    } else if (m.lost && !m.cannot_close && report.status != Status::diverged)
      report.status = Status::diverged, report.body = m.lost, report.residual = m.residual;
}

/// Surfaces that bear, but nearly fit one another there: rounding decides where they touch.
void note_uncertain(const World& world, const Island& m, StepReport& report) {
  for (std::size_t n = 0; n < m.touches.size(); ++n) {
    if (!m.touches[n].known || !is_active(m, m.touch_blocks[n])) continue;
    const std::uint32_t source = m.touch_sources[n];
    const SurfaceContact& c = world.surface_contacts.values()[source];
    const nurbs::CommonNormal& pair = m.scratch.touching[n].pair;
    if (pair.status == nurbs::ContactStatus::found && is_place_uncertain(c, pair.least_curvature) &&
        report.uncertain++ == 0)
      report.uncertain_at = world.surface_contacts.owners()[source];
  }
}

void report(const World& world, StepReport& report) {
  const ContactScratch& contacts = world.memory.of<Islands>().contacts;
  if (contacts.unsolved > 0)
    report.unsolved += contacts.unsolved, report.unsolved_at = contacts.unsolved_at;
  for (const Island& m : islands_of(world)) {
    report.rows += static_cast<int>(m.equations()), report.rank += static_cast<int>(m.rank);
    report.worst_constraint = std::max(report.worst_constraint, m.residual);
    report.substeps = std::max(report.substeps, m.substeps), report.events += m.events;
    if (m.rescues > 0 && report.rescued++ == 0) report.rescued_at = m.bodies.front();
    report.released += m.released;
    note_uncertain(world, m, report);
    for (const Frame& f : m.frames) report.drives_capped += f.drive != UINT32_MAX && f.lag.limited;
    for (const Fault& f : m.faults) {
      if (f.kind != Fault::inconsistent || report.status != Status::ok) continue;
      report.status = Status::inconsistent;
      report.worst_residual_at = joint_of(world, block_of(m, f)),
      report.worst_residual = f.residual, report.body = f.with;
    }
  }
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
    const JointParameters& parameters = *link.joint.parameters;
    const SpringDamper& s = e.coordinate == Coordinate::angle ? parameters.rotation.spring
                                                              : parameters.translation.spring;
    m.elastic += energy_of(s, coordinate_at(world, link, e.coordinate, e.before).value);
  }
}

bool masses_hold(const Island& m) {
  for (std::size_t i = 0; i < m.count(); ++i)
    if (!is_mass(m.mass[i]) || !is_mass(m.inertia[i])) return false;
  return true;
}

const char* fault(const World& world) {
  for (const Island& m : islands_of(world)) {
    if (m.unfit) continue;
    if (const char* why = settings_fault(m.settings)) return why;
    if (!masses_hold(m)) return "contains a mass that is not positive and finite";
  }
  return nullptr;
}

void measure(const World& world, Measures& m) {
  for (const Island& island : islands_of(world)) measure_island(world, island, m);
}

Real drive_angle(const World& world, Entity joint) {
  const std::uint32_t now = world.links.slot(joint), slot = world.links.slot_then(now);
  for (const Island& m : islands_of(world))
    for (std::size_t i = 0; m.driven && i < m.blocks.size(); ++i)
      if (const Block& b = m.blocks[i];
          b.kind == BlockKind::drive && b.source == slot && m.memory[i].counted)
        if (b.coordinate == Coordinate::angle) return m.memory[i].before[0];
  return std::numeric_limits<Real>::quiet_NaN();
}

void list_turns(const World& world, TurnCounts& counts) {
  const auto add = [&](std::uint32_t source, Coordinate of, Real value) {
    const std::uint32_t link = world.links.slot_now(source);
    const bool turns = of == Coordinate::angle || of == Coordinate::second;
    if (turns && link != kNoSlot) counts.push_back({world.links.owners()[link], of, value});
  };
  for (const Island& m : islands_of(world)) {
    for (const JointForce& e : m.joint_forces) add(e.link, e.coordinate, e.before);
    // A build that ran out of memory leaves islands without it.
    for (std::size_t i = 0; i < m.memory.size(); ++i)
      if (const Block& b = m.blocks[i];
          m.memory[i].counted && (b.kind == BlockKind::spring || b.kind == BlockKind::limit))
        add(b.source, b.coordinate, m.memory[i].before[0]);
  }
}

}  // namespace

const SolverRow kRow{.name = "lagrangian",
                     .feels_contacts = true,
                     .compile = compile,
                     .list_turns = list_turns,
                     .prepare = prepare,
                     .predict = predict,
                     .fault = fault,
                     .asleep = asleep,
                     .find_reaches = find_reaches,
                     .find_starts = find_starts,
                     .take_contacts = take_contacts,
                     .adjust = adjust,
                     .note_failure = note_failure,
                     .report = report,
                     .measure = measure,
                     .drive_angle = drive_angle};

}  // namespace pantin::detail::lagrangian

namespace pantin::detail {
template lagrangian::Islands& Memories::create();
template const lagrangian::Islands& Memories::none();
}  // namespace pantin::detail
