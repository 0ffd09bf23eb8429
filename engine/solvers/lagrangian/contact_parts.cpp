// Contacts in parts of a step: of rims, whose contact points travel around, and of springs, dampers
// and motors that bear loads through contacts.
//
// The response of an island to an impulse is that of its masses and joints. A spring or a motor
// between them would give way to the load within the step, and more so the lighter what it moves:
// a lift would sink under its load. Groups with such joints therefore take the step in parts by
// Euler's method, with these forces as at the end of the part, and contacts respond through the
// same compliances. At rest the forces of springs and motors are then those of statics.
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/contacts.hpp"
#include "engine/solvers/lagrangian/integrator.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// s: longest part with springs and motors. The most of them.
constexpr Real kLongestPart = 1.0 / 470;
constexpr int kMostParts = 16;
/// Most repetitions of a part, in which motors reach their bounds or leave them.
constexpr int kRepetitions = 4;

/// Whether the step of an island can be taken again in parts.
bool can_repeat(const Island& m) {
  return m.touches.empty() && !m.driven && !m.rubs && m.places.empty() && m.elastic_paths.empty() &&
         m.elastic_cables.empty() &&
         std::none_of(m.blocks.begin(), m.blocks.end(),
                      [](const Block& b) { return b.kind == BlockKind::belt; });
}

/// Parts that springs and motors need in contact; 0: there are none, or none that can be repeated.
int parts_of_springs(World& world, const ContactGroup& g) {
  bool springs = false;
  for (const GroupMember& member : g.members) {
    const Island& m = islands_of(world)[member.island];
    if (!can_repeat(m)) return 0;
    springs = springs || !m.joint_forces.empty();
  }
  if (!springs) return 0;
  place_points(world, g);
  const bool touches = std::any_of(g.points.begin(), g.points.end(), [](const ContactPoint& p) {
    return p.is_contact() && (p.lasting != Vec3(0) || p.gap <= kNearlyShut);
  });
  if (!touches) return 0;
  return std::clamp(static_cast<int>(std::ceil(g.h / kLongestPart - 1e-9)), 1, kMostParts);
}

/// Moves the obstacles of a group on by their velocities.
void move_obstacles(const ContactGroup& g, Real by) {
  for (ContactPoint& p : g.points)
    for (Obstacle& o : p.obstacle) {
      if (!o.moves()) continue;
      o.pose.position += by * o.velocity;
      o.pose.rotation = glm::normalize(from_rotation_vector(by * o.spin) * o.pose.rotation);
    }
}

/// One of the equal parts of a step.
struct PartOfStep {
  int number, count;
  Real h, whole;  // s
  bool has_springs;
};

/// Moves the islands of a group without contacts. False: failure.
bool advance_group(World& world, const ContactGroup& g, const PartOfStep& part) {
  for (const GroupMember& member : g.members) {
    Island& m = islands_of(world)[member.island];
    StepScratch& scratch = m.scratch;
    scratch.state = scratch.entry;
    if (part.has_springs) std::fill(scratch.impulses.begin(), scratch.impulses.end(), 0.0);
    if (!advance(world, m, {part.number * part.h, part.h, part.whole})) return false;
    update_kinematics(m);
    if (part.has_springs) {
      for (std::size_t r = 0; r < m.rows; ++r) m.forces[r] += scratch.impulses[r] / part.h;
      update_frames(world, m, Real(part.number + 1) / part.count, part.whole);
      add_forces(world, m, Torques::applied);
      scratch.springs_active = true;
      write_all_rows(world, m, {true, false});
      factor(m);
      continue;
    }
    factor(m), add_forces(world, m, Torques::applied);
  }
  return true;
}

/// After a part: whether a motor reached its bound in it, or left it.
bool motors_change(World& world, const ContactGroup& g) {
  bool change = false;
  for (const GroupMember& member : g.members) {
    Island& m = islands_of(world)[member.island];
    if (m.joint_forces.empty()) continue;
    update_kinematics(m);
    m.scratch.springs_active = true;
    write_all_rows(world, m, {true, false});
    change = hold_motors(world, m) || change;
    m.scratch.springs_active = false;
  }
  return change;
}

/// Takes a part with its contacts, until motors are where they were thought to be.
bool take_part(World& world, const ContactGroup& g, const PartOfStep& part, bool& solved) {
  std::vector<ContactPoint>& again = world.memory.of<Islands>().contacts.again;
  for (const GroupMember& member : g.members) {
    Island& m = islands_of(world)[member.island];
    m.scratch.entry = m.scratch.state;
    if (part.has_springs) m.scratch.forces_before = m.forces;
  }
  if (part.has_springs) again.assign(g.points.begin(), g.points.end());
  for (int n = 0;; ++n) {
    if (!advance_group(world, g, part)) return false;
    const bool good = resolve(world, g);
    if (!part.has_springs || n == kRepetitions || !motors_change(world, g)) {
      solved = solved && good;
      return true;
    }
    std::copy(again.begin(), again.end(), g.points.begin());
    for (const GroupMember& member : g.members) {
      Island& m = islands_of(world)[member.island];
      m.forces = m.scratch.forces_before;
    }
  }
}

/// Before and after a step in parts with springs.
void begin_springs(World& world, const ContactGroup& g) {
  for (const GroupMember& member : g.members) {
    Island& m = islands_of(world)[member.island];
    m.scratch.in_parts = true;
    std::fill(m.forces.begin(), m.forces.end(), 0.0);
    m.scratch.held.assign(m.rows, std::numeric_limits<Real>::quiet_NaN());
  }
  // All bodies move by their velocities at the end of the part, and limits act there.
  for (ContactPoint& p : g.points) p.share = 1, p.least = 0;
}
void end_springs(World& world, const ContactGroup& g, int parts) {
  for (const GroupMember& member : g.members) {
    Island& m = islands_of(world)[member.island];
    m.scratch.in_parts = m.scratch.springs_active = false;
    std::fill(m.scratch.weights.begin(), m.scratch.weights.end(), 0.0);
    for (Real& force : m.forces) force /= parts;
    m.fresh = true, m.rescues = 0;  // the step without contacts does not count
  }
}

}  // namespace

bool resolve_in_parts(World& world, ContactGroup g) {
  const int of_springs = parts_of_springs(world, g);
  const int parts = of_springs > 0 ? of_springs : parts_of(world, g);
  if (parts == 1 && of_springs == 0) return resolve(world, g);
  PartOfStep part{0, parts, g.h / parts, g.h, of_springs > 0};
  g.h = part.h;
  for (const GroupMember& member : g.members) {
    StepScratch& scratch = islands_of(world)[member.island].scratch;
    scratch.state = scratch.entry;
  }
  if (part.has_springs)
    begin_springs(world, g);
  else
    join_rims(g);
  move_obstacles(g, part.h - part.whole);
  for (ContactPoint& p : g.points) p.lasting /= parts;
  bool solved = true, good = true;
  for (; part.number < parts && good; ++part.number) {
    good = take_part(world, g, part, solved);
    for (ContactPoint& p : g.points) {
      p.whole += p.impulse, p.gap_before = p.gap;
      if (part.number + 1 == parts) continue;
      p.lasting = p.borne, p.closed = false;
      p.impulse = p.borne = p.shift = p.held = Vec3(0);
    }
    if (part.number + 1 < parts) move_obstacles(g, part.h);
  }
  for (ContactPoint& p : g.points) p.impulse = p.whole, p.borne *= parts;
  if (part.has_springs) end_springs(world, g, parts);
  return good && solved;
}

}  // namespace pantin::detail::lagrangian
