// Contacts of this solver's bodies, by time stepping. [Moreau 1988; Jean 1999]
//
// Each island has taken its step without contacts. Then coupled islands are solved together. First,
// restitution: pair by pair, at the time of collision within the step. Second, impulses at the end
// of the step: closed contacts neither approach nor pull, and friction obeys Coulomb's cone. Joints
// take part through the response of the island's factor. Positions follow the impulses like forces;
// remaining overlaps are opened.
#include "engine/solvers/lagrangian/contacts.hpp"

#include <algorithm>
#include <optional>

#include "engine/base/rotation.hpp"
#include "engine/contact/contact_axes.hpp"
#include "engine/contact/memory.hpp"
#include "engine/solvers/lagrangian/integrator.hpp"

namespace pantin::detail::lagrangian {
namespace {

constexpr int kOpenings = 4;
/// m/s or rad/s: a limit that opens faster is released.
constexpr Real kLeaves = 1e-6;
/// m: overlaps that rounding may leave.
constexpr Real kOpenEnough = 1e-12;
/// Of a body's radius of gyration: smaller overlaps contradict no joint. kOpens: the fraction of an
/// overlap, or of the travel at the speed of pushing, that a contact opens at least unless a joint
/// holds it.
constexpr Real kPressed = 1e-3, kOpens = 0.1;
/// Cosine of normals that count as parallel, and the distance beside the joint's point, of the
/// radius of gyration, within which a contact counts as being there.
constexpr Real kParallel = 0.99, kBeside = 0.25;
/// rad: displacements that rotate a body on a surface joint by more are left out. The joint nearly
/// holds the contact shut, so that its response, which is linear, says nothing of such a rotation.
constexpr Real kMostTurned = 0.3;

void clear_forces(Island& m) {
  std::fill(m.scratch.momenta.begin(), m.scratch.momenta.end(), Vec3(0));
  std::fill(m.scratch.right.begin(), m.scratch.right.end(), 0.0);
}

/// Applies one kind of impulse of all points of a member through its joints: motions into
/// scratch.solution, joint impulses into scratch.lambda.
void respond(const ContactScratch& r, Island& m, const GroupMember& member,
             Vec3 ContactPoint::*what) {
  PANTIN_ASSERT(is_part(member.first_end, member.ends, r.ends.size()));
  clear_forces(m);
  for (std::uint32_t i = member.first_end; i < member.first_end + member.ends; ++i)
    add_end_force(r, r.ends[i], r.points[r.ends[i].point].*what, m.scratch.momenta);
  solve(m, {m.scratch.momenta, m.scratch.right}, {m.scratch.solution, m.scratch.lambda});
}

/// Changes velocities by one kind of impulse of all points of a member.
void change_velocities(World& world, const Couplings& with, const GroupMember& member,
                       Vec3 ContactPoint::*what) {
  Island& m = islands_of(world)[member.island];
  PANTIN_ASSERT(with.group.h > 0 && m.forces.size() == m.rows);
  respond(with.scratch, m, member, what);
  for (std::size_t b = 0; b < m.count(); ++b) {
    m.scratch.state.v[b] += m.scratch.solution[2 * b];
    m.scratch.state.w[b] += m.scratch.solution[2 * b + 1];
  }
  for (std::size_t row = 0; row < m.rows; ++row)
    m.forces[row] += m.scratch.lambda[row] / with.group.h;
}

/// Closes the joints of an island after contacts displaced it. False: they stay open, or a surface
/// joint lost its contact.
bool close_joints(const World& world, Island& m, Real h) {
  m.scratch.springs_active = false;
  update_kinematics(m);
  m.scratch.projection_work = 0, m.scratch.lost_touch = UINT32_MAX;
  std::fill(m.scratch.impulses.begin(), m.scratch.impulses.end(), 0.0);
  if (m.blocks.empty()) return true;
  write_all_rows(world, m, {true, false});
  if (m.settings.stabilisation != Stabilisation::projection) return true;
  const bool closed = project(world, m, 1, h) && m.scratch.lost_touch == UINT32_MAX;
  m.scratch.lost_touch = UINT32_MAX;
  return closed;
}

/// rad: the largest rotation of a body in scratch.solution.
Real largest_turn(const Island& m) {
  Real most = 0;
  for (std::size_t b = 0; b < m.count(); ++b)
    most = std::max(most, glm::length(m.scratch.solution[2 * b + 1]));
  return most;
}

/// Displaces an island by the shifts of its points and closes its joints; by a quarter of that, or
/// not at all, where they do not close. Returns the work of its forces, J.
Real change_poses(const World& world, Island& m, const GroupMember& member, Real h) {
  Motions& s = m.scratch.state;
  m.scratch.begin = s;
  for (const Real part : {1.0, 0.25}) {
    // The factor belongs to the current poses.
    respond(world.memory.of<Islands>().contacts, m, member, &ContactPoint::shift);
    if (!m.touch_blocks.empty() && part * largest_turn(m) > kMostTurned) continue;
    Real work = 0;
    for (std::size_t b = 0; b < m.count(); ++b) {
      const Vec3 way = part * m.scratch.solution[2 * b],
                 turn = part * m.scratch.solution[2 * b + 1];
      work += glm::dot(m.scratch.force[2 * b], way) + glm::dot(m.scratch.force[2 * b + 1], turn);
      const Vec3 momentum = s.q[b] * (m.inertia[b] * (glm::conjugate(s.q[b]) * s.w[b]));
      s.x[b] += way, s.q[b] = glm::normalize(from_rotation_vector(turn) * s.q[b]);
      // A loose body keeps its angular momentum, so its angular velocity rotates.
      if (m.blocks.empty()) s.w[b] = s.q[b] * ((glm::conjugate(s.q[b]) * momentum) / m.inertia[b]);
    }
    if (close_joints(world, m, h)) {
      for (std::size_t row = 0; row < m.rows; ++row) m.forces[row] += m.scratch.impulses[row] / h;
      return work + m.scratch.projection_work;
    }
    s = m.scratch.begin;
    update_kinematics(m);
    if (m.blocks.empty()) continue;
    write_all_rows(world, m, {true, false});
    m.residual = worst_residual(m);
    factor(m);
  }
  return 0;
}

/// The work of an island's forces during the step, J.
Real work_of_step(const Island& m) {
  const Motions &from = m.scratch.entry, &to = m.scratch.state;
  Real work = 0;
  for (std::size_t b = 0; b < m.count(); ++b)
    work +=
        glm::dot(m.scratch.force[2 * b], to.x[b] - from.x[b]) +
        glm::dot(m.scratch.force[2 * b + 1], rotation_vector(to.q[b] * glm::conjugate(from.q[b])));
  return work;
}

/// Removes energy that the islands of a group gained by their contacts, unless a moving obstacle
/// may have supplied it, or springs and motors, whose work depends on the contacts.
void bound_energy(World& world, const ContactGroup& g, Real work) {
  const bool rest = std::all_of(g.points.begin(), g.points.end(), [&](const ContactPoint& p) {
    const bool is_belt =
        p.is_contact() && contacts_of(world)[p.contact].surface_velocity != Vec3(0);
    return !is_belt && !p.obstacle[0].moves() && !p.obstacle[1].moves();
  });
  if (!rest) return;
  Real before = 0, at_start = 0, now = 0;
  for (const GroupMember& member : g.members) {
    const Island& m = islands_of(world)[member.island];
    if (m.scratch.in_parts || !frames_rest(world, m, {0, g.h, g.h})) return;
    before += member.kinetic, now += kinetic_energy(m, m.scratch.state);
    at_start += kinetic_energy(m, m.scratch.entry) + work_of_step(m);
  }
  // Euler's step may have dissipated what its contacts restore.
  const Real due = std::max(before + work, at_start);
  if (!(now > due)) return;
  const Real part = due > 0 ? std::sqrt(due / now) : 0;
  for (const GroupMember& member : g.members) {
    Motions& s = islands_of(world)[member.island].scratch.state;
    for (Vec3& v : s.v) v *= part;
    for (Vec3& w : s.w) w *= part;
  }
}

/// Whether a closed contact is at the rim of a body.
bool touches_with_rims(const ContactGroup& g) {
  return std::any_of(g.points.begin(), g.points.end(), [](const ContactPoint& p) {
    const auto is_rim = [&](int side) { return p.end[side] != kNoIndex && p.on[side].circle > 0; };
    return p.closed && (is_rim(0) || is_rim(1));
  });
}

/// Solves again at the displaced poses: the contact point of a rim depends on the pose.
bool hold_where_placed(World& world, const Couplings& with) {
  find_speeds(world, with.group);
  for (GroupMember& member : with.group.members) find_responses(world, member);
  find_own_responses(world, with.group);
  for (ContactPoint& p : with.group.points) p.more = p.impulse;
  const bool solved = hold_on(with);
  for (ContactPoint& p : with.group.points) p.more = p.impulse - p.more;
  for (const GroupMember& member : with.group.members)
    change_velocities(world, with, member, &ContactPoint::more);
  return solved;
}

/// The bilateral surface joint of a body, as a block, or none.
std::optional<std::uint32_t> surface_joint_of(const Island& m, std::uint32_t body) {
  for (const std::uint32_t i : m.touch_blocks) {
    const Block& b = m.blocks[i];
    if (b.lock && is_active(m, i) && (b.body[0] == body || b.body[1] == body)) return i;
  }
  return std::nullopt;
}

/// Whether a step has left an overlap as it was.
bool stays_pressed(const ContactPoint& p, Real h) {
  return p.gap < p.gap_before + kOpens * std::min(-p.gap_before, kPushSpeed * h);
}

/// Whether an obstacle presses a body where its surface joint touches, along the same normal: then
/// no motion opens the contact, although a rotation lifts the points that touched at first.
bool presses_on_joint(const ContactScratch& r, const Island& m, const ContactPoint& p, int side) {
  const ContactEnd& e = r.ends[p.end[side]];
  const auto joint = surface_joint_of(m, e.column);
  if (!joint || p.end[1 - side] != kNoIndex) return false;
  const SurfaceFound& found = m.scratch.touching[m.blocks[*joint].first_place];
  const Vec3 aside = glm::cross(found.normal, m.scratch.state.x[e.column] + e.arm - found.on_b);
  return std::abs(glm::dot(found.normal, p.axes[0])) > kParallel &&
         glm::length(aside) < kBeside * radius_of_gyration(m.inertia[e.column], m.mass[e.column]);
}

/// A surface joint fixes where its bodies are along the normal. Where that is within an obstacle,
/// joint and contact contradict each other: lists the fault and takes the step back.
void find_contradictions(World& world, const ContactGroup& g) {
  const ContactScratch& r = world.memory.of<Islands>().contacts;
  for (const ContactPoint& p : g.points)
    for (int side = 0; side < 2 && p.is_contact(); ++side) {
      if (p.end[side] == kNoIndex) continue;
      const ContactEnd& e = r.ends[p.end[side]];
      Island& m = islands_of(world)[e.island];
      const auto joint = surface_joint_of(m, e.column);
      if (!joint) continue;
      const Real size = radius_of_gyration(m.inertia[e.column], m.mass[e.column]);
      if (!(p.gap_before < -kPressed * size)) continue;
      if (!stays_pressed(p, g.h) && !presses_on_joint(r, m, p, side)) continue;
      const Contact& c = contacts_of(world)[p.contact];
      Fault f;
      f.kind = Fault::inconsistent, f.block = *joint, f.residual = -p.gap_before;
      f.with = world.bodies.owners()[side == 0 ? c.slot_b : c.slot_a];
      m.faults.push_back(f);
      for (const GroupMember& member : g.members) {
        Island& other = islands_of(world)[member.island];
        other.scratch.state = other.scratch.entry, other.fresh = true;
      }
      return;
    }
}

}  // namespace

bool resolve(World& world, const ContactGroup& g) {
  ContactScratch& r = world.memory.of<Islands>().contacts;
  place_points(world, g);
  find_speeds(world, g);
  for (GroupMember& member : g.members) {
    const Island& m = islands_of(world)[member.island];
    member.kinetic = kinetic_energy(m, m.scratch.state);
    find_responses(world, member);
  }
  find_own_responses(world, g);
  const Couplings with{r, g};
  collide(with);
  bool solved = hold(with);
  if (std::all_of(g.points.begin(), g.points.end(), [](const ContactPoint& p) {
        return p.impulse == Vec3(0) && p.shift == Vec3(0);
      })) {
    find_contradictions(world, g);
    return solved;
  }
  Real work = 0;
  for (const GroupMember& member : g.members) {
    Island& m = islands_of(world)[member.island];
    change_velocities(world, with, member, &ContactPoint::impulse);
    m.fresh = m.fresh || row_of(m.settings.integrator).keeps_accelerations;
  }
  for (int n = 0; n < kOpenings; ++n) {
    for (const GroupMember& member : g.members)
      work += change_poses(world, islands_of(world)[member.island], member, g.h);
    place_points(world, g);
    if (n == 0 && touches_with_rims(g)) solved = hold_where_placed(world, with) && solved;
    if (n == 0)
      for (ContactPoint& p : g.points) p.borne = p.closed ? p.lasting : Vec3(0);
    if (n + 1 == kOpenings || open_overlaps(with) <= kOpenEnough) break;
  }
  bound_energy(world, g, work);
  find_contradictions(world, g);
  return solved;
}

namespace {

/// Distributes the torques of two bodies equally over their contacts.
void write_rolling(World& world, const ContactScratch& r, const ContactPoint& p, Real h) {
  const RollingAt& all = r.rollings[p.rolling];
  const Real arm = all.arm / all.count;
  for (const ContactPoint& q : std::span(r.points).subspan(all.first, all.count)) {
    Contact& c = contacts_of(world)[q.contact];
    c.torque = arm / h * contact::in_world(p.axes, p.impulse);
    c.torque_lambda = arm * h * contact::in_world(p.axes, p.borne);
  }
}

void write_contact(World& world, const ContactPoint& p, Real h) {
  PANTIN_ASSERT(p.contact < contacts_of(world).size() && is_unit(p.axes[0]));
  Contact& c = contacts_of(world)[p.contact];
  c.force = contact::in_world(p.axes, p.impulse) / h;
  c.lambda = h * contact::in_world(p.axes, p.borne);
  c.torque = c.torque_lambda = Vec3(0);
  c.active = p.impulse.x > 0, c.rest = 0;
  c.depth = std::max(Real(0), -p.gap);
}

/// Limits that push stay active, and limits at their bounds that do not open. Limits that were
/// active in the step but were opened by contacts are released.
void restore_limits(World& world, ContactScratch& r, Real h) {
  for (const ContactPoint& p : r.points) {
    if (!p.is_limit()) continue;
    PANTIN_ASSERT(p.limit < r.limits.size());
    const LimitRowAt& row = r.limits[p.limit];
    Island& m = islands_of(world)[row.island];
    const bool bears = p.impulse.x > p.least;
    m.memory[row.block].active = bears ? p.speed.x <= kLeaves : row.was_active && p.speed.x <= 0;
    m.forces[m.blocks[row.block].first_row] += p.impulse.x / h;
  }
}

void finish(World& world, std::uint32_t island) {
  Island& m = islands_of(world)[island];
  for (std::size_t i = 0; i < m.frames.size(); ++i) {
    const BodyState& at = m.scratch.body_states[m.count() + i];
    note_end(world, m.frames[i], at);
  }
  if (!all_within_bounds(m)) {
    m.lost = m.bodies.front(), m.fresh = true;
    return;
  }
  write_back(world, m), write_back_touch_forces(world, m);
}

}  // namespace

void resolve_contacts(World& world, Real h) {
  if (contacts_of(world).empty()) return;
  gather_contacts(world, h);
  ContactScratch& r = world.memory.of<Islands>().contacts;
  for (std::size_t i = 0; i < r.groups.size(); ++i) {
    const ContactScratch::Range& range = r.groups[i];
    PANTIN_ASSERT(is_part(range.first_point, range.points, r.points.size()));
    PANTIN_ASSERT(is_part(range.first_member, range.members, r.members.size()) &&
                  range.members > 0);
    const ContactGroup g{std::span(r.points).subspan(range.first_point, range.points),
                         std::span(r.members).subspan(range.first_member, range.members), h};
    const bool solved = resolve_in_parts(world, g);
    if (!solved && r.unsolved++ == 0)
      r.unsolved_at = islands_of(world)[g.members.front().island].bodies.front();
  }
  for (const ContactPoint& p : r.points)
    if (p.is_contact()) write_contact(world, p, h);
  for (const ContactPoint& p : r.points)
    if (p.is_rolling()) write_rolling(world, r, p, h);
  restore_limits(world, r, h);
  for (const GroupMember& member : r.members) finish(world, member.island);
}

}  // namespace pantin::detail::lagrangian
