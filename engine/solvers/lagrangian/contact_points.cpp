// Contact points of this solver's bodies, and the response of their islands to impulses there.
#include <algorithm>
#include <tuple>

#include "engine/base/rotation.hpp"
#include "engine/contact/contact_axes.hpp"
#include "engine/contact/detect.hpp"
#include "engine/solvers/lagrangian/contacts.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// Fraction of the response that the two bodies would have without joints: below it the contact is
/// left to the joints.
constexpr Real kLeastResponse = 1e-9;
/// Limits this near to their bounds join the contacts: the travel at the fastest speed, in steps,
/// plus a margin, m or rad.
constexpr Real kNearInSteps = 2, kAtBound = 1e-9;
/// Largest travel, rad, of a rim's contact point around the rim in a substep; the most substeps;
/// and the most points of a group that is divided into substeps.
constexpr Real kMostAround = 0.15;
constexpr int kMostRimParts = 32;
constexpr std::size_t kMostRimPoints = 16;
/// m: bodies with a smaller gap at the start roll on their rims.
constexpr Real kOnRim = 1e-6;

/// The island of a body; null for a body of another solver, or of none.
const Island* lagrangian_island(const World& world, const Owner& owner) {
  return owner && owner.solver == kLagrangian ? &islands_of(world)[owner.island] : nullptr;
}

/// The island of a body, if it takes part in contacts of this step, or none.
std::uint32_t taking_part(const World& world, const Owner& owner) {
  const Island* m = lagrangian_island(world, owner);
  if (!m || !m->scratch.stepped || m->lost || m->unfit) return kNoIndex;
  return owner.island;
}

/// State of a body outside the group at the end of the step.
Obstacle obstacle_at(const World& world, std::uint32_t slot, Real h) {
  const Body& b = world.bodies.values()[slot];
  const Owner owner = owner_of(partition_of(world), slot);
  if (!owner) {
    if (!contact::moves(b)) return {b.pose};
    return {b.pose, b.velocity, b.angular_velocity};
  }
  // Planar solvers have moved their bodies before; other solvers move theirs after this one.
  const Island* m = lagrangian_island(world, owner);
  if (owner.solver < kLagrangian || (m && m->scratch.stepped))
    return {b.pose, b.velocity, b.angular_velocity};
  if (m && (m->lost || m->unfit)) return {b.pose};
  return {{b.pose.position + h * b.velocity,
           glm::normalize(from_rotation_vector(h * b.angular_velocity) * b.pose.rotation)},
          b.velocity,
          b.angular_velocity};
}

/// Euler moves jointed bodies by their velocities at the end of the step. All others, and loose
/// bodies, move by mean velocities.
Real lasting_share(const Island& m) {
  return m.settings.integrator == Integrator::euler && !m.blocks.empty() ? 1 : 0.5;
}

ContactPoint make_point(const World& world, std::uint32_t number, Real h) {
  const Contact& c = contacts_of(world)[number];
  ContactPoint p;
  p.contact = number;
  PANTIN_ASSERT(is_unit(c.normal));
  contact::set_axes(p.axes, c.normal);
  const std::uint32_t slot[2] = {c.slot_a, c.slot_b};
  using Side = contact::BodyOfContact::Side;
  for (int s = 0; s < 2; ++s) {
    // The normal is that at the start of the step.
    const Owner owner = owner_of(partition_of(world), slot[s]);
    const Body& b = world.bodies.values()[slot[s]];
    Quat rotation = b.pose.rotation;
    if (const Island* m = lagrangian_island(world, owner); m && m->scratch.stepped)
      rotation = m->scratch.entry.q[owner.column];
    else if (!owner && contact::moves(b))
      rotation = contact::pose_before(b, h).rotation;
    p.on[s] = contact::touched_place(world, c, {s == 0 ? Side::a : Side::b, rotation});
  }
  // The normal rotates with the body of the face.
  const Body& b = world.bodies.values()[c.slot_b];
  if (!owner_of(partition_of(world), c.slot_b) && contact::moves(b))
    contact::set_axes(p.axes,
                      glm::normalize(from_rotation_vector(h * b.angular_velocity) * c.normal));
  p.friction = c.friction, p.restitution = c.restitution, p.gap_before = c.gap;
  p.lasting = contact::along_axes(p.axes, c.lambda) / h;
  if (!is_finite(p.lasting) || !(p.lasting.x > 0)) p.lasting = Vec3(0);
  return p;
}

/// Lists the contacts of these islands, unsorted.
void list_points(const World& world, ContactScratch& r, Real h) {
  const Partition& partition = partition_of(world);
  const std::vector<Contact>& contacts = contacts_of(world);
  for (std::uint32_t i = 0; i < contacts.size(); ++i) {
    const Owner a = owner_of(partition, contacts[i].slot_a);
    const Owner b = owner_of(partition, contacts[i].slot_b);
    if (a.solver != kLagrangian) continue;
    const std::uint32_t in[2] = {taking_part(world, a), taking_part(world, b)};
    if (in[0] == kNoIndex && in[1] == kNoIndex) continue;
    ContactPoint p = make_point(world, i, h);
    p.column[0] = a.column, p.column[1] = b.column;
    for (int s = 0; s < 2; ++s) {
      p.owner[s] = in[s];
      if (in[s] != kNoIndex)
        r.touched[in[s]] = 1, p.share = lasting_share(islands_of(world)[in[s]]);
      else
        p.obstacle[s] = obstacle_at(world, s == 0 ? contacts[i].slot_a : contacts[i].slot_b, h);
    }
    if (in[0] != kNoIndex && in[1] != kNoIndex) r.sets.join(in[0], in[1]);
    r.points.push_back(p);
  }
  list_rolling(world, r, h);
}

/// The largest speed of any body, m/s and rad/s, at the start or the end of the step.
struct Fastest {
  Real speed = 0, spin = 0;
};
Fastest fastest_of(const Island& m) {
  Fastest most;
  for (const Motions* s : {&m.scratch.entry, &m.scratch.state})
    for (std::size_t b = 0; b < m.count(); ++b) {
      most.speed = std::max(most.speed, glm::length(s->v[b]));
      most.spin = std::max(most.spin, glm::length(s->w[b]));
    }
  return most;
}

/// Activates limits and slack cables that contacts may bring to their bounds within the step.
void wake_near_limits(const World& world, Island& m, Real h) {
  PANTIN_ASSERT(m.scratch.blow.was_active.size() == m.blocks.size());
  const Fastest most = fastest_of(m);
  const auto is_other = [&](std::size_t i) { return is_one_sided(m, i) && !m.memory[i].active; };
  std::vector<std::uint32_t>& near = m.scratch.blow.blocks;
  near.clear();
  for (std::uint32_t i = 0; i < m.blocks.size(); ++i)
    m.scratch.blow.was_active[i] = m.memory[i].active;
  for (std::uint32_t i = 0; i < m.blocks.size(); ++i)
    if (is_other(i) && m.blocks[i].kind != BlockKind::surface) near.push_back(i);
  if (near.empty()) return;
  for (const std::uint32_t i : near) m.memory[i].active = true;
  write_all_rows(world, m, {true, false});
  for (const std::uint32_t i : near) {
    const Block& b = m.blocks[i];
    Real rate = 0;
    for (std::size_t k = 0; k < b.count; ++k) {
      const RowVectors j = row_of(b, jacobian_of(m, b), 0, k);
      rate += glm::length(j.v) * most.speed + glm::length(j.w) * most.spin;
    }
    m.memory[i].active = m.scratch.c[b.first_row] <= kNearInSteps * h * rate + kAtBound;
  }
}

/// Turns active limits from rows of the island into contact points, which can only push.
void list_limits(ContactScratch& r, Island& m, std::uint32_t island) {
  for (std::uint32_t i = 0; i < m.blocks.size(); ++i) {
    if (!is_one_sided(m, i) || !m.memory[i].active) continue;
    const Block& b = m.blocks[i];
    LimitRowAt row;
    row.island = island, row.block = i, row.gap = m.scratch.c[b.first_row];
    row.was_active = m.scratch.blow.was_active[i] != 0;
    for (std::size_t k = 0; k < b.count; ++k) {
      const RowVectors j = row_of(b, jacobian_of(m, b), 0, k);
      if (b.body[k] >= m.count()) {
        const BodyState& at = m.scratch.body_states[b.body[k]];
        row.frame_rate += glm::dot(j.v, at.velocity) + glm::dot(j.w, at.angular_velocity);
        continue;
      }
      PANTIN_ASSERT(row.count < std::size(row.body));
      row.j[2 * row.count] = j.v, row.j[2 * row.count + 1] = j.w;
      row.body[row.count++] = b.body[k];
    }
    ContactPoint p;
    p.limit = static_cast<std::uint32_t>(r.limits.size());
    p.owner[0] = island, p.share = lasting_share(m);
    p.gap_before = m.scratch.blow.gap_before[i];
    // Contacts may reduce the impulse that it gave in the step without them.
    const Real given = m.scratch.impulses[b.first_row] + m.scratch.blow.at_start[b.first_row];
    p.least = -std::max(Real(0), given);
    r.limits.push_back(row), r.points.push_back(p);
    m.memory[i].active = false;
  }
}

/// Loads an island at the end of its step, adds its limits, and factors.
void take_up(World& world, ContactScratch& r, std::uint32_t island, Real h) {
  Island& m = islands_of(world)[island];
  PANTIN_ASSERT(m.scratch.stepped && m.scratch.ready);
  Motions& s = m.scratch.state;
  for (std::size_t b = 0; b < m.count(); ++b) {
    const Body& body = world.bodies.values()[m.slots[b]];
    s.x[b] = body.pose.position, s.q[b] = body.pose.rotation;
    s.v[b] = body.velocity, s.w[b] = body.angular_velocity;
  }
  update_kinematics(m), update_frames(world, m, 1, h);
  write_all_rows(world, m, {true, false});
  if (m.unilateral) {
    wake_near_limits(world, m, h);
    list_limits(r, m, island);
    write_all_rows(world, m, {true, false});
  }
  factor(m);
  add_forces(world, m, Torques::applied);
}

/// Rate at which the contact point of a rim travels around the contact's normal, rad/s.
Real rate_around(const World& world, const ContactScratch& r, const ContactPoint& p, int side) {
  if (p.end[side] == kNoIndex || p.on[side].circle == 0) return 0;
  const ContactEnd& e = r.ends[p.end[side]];
  const Motions& from = islands_of(world)[e.island].scratch.entry;
  return std::abs(p.on[side].rate_around(from.q[e.column], from.w[e.column], p.axes[0]));
}

bool has_same_bodies(const ContactPoint& p, const ContactPoint& q) {
  for (const int side : {0, 1}) {
    if ((p.end[side] == kNoIndex) != (q.end[side] == kNoIndex)) return false;
    if (p.owner[side] != q.owner[side] || p.column[side] != q.column[side]) return false;
  }
  return true;
}

void sort_points(ContactScratch& r) {
  for (ContactPoint& p : r.points)
    p.group = r.sets.root(p.owner[0] != kNoIndex ? p.owner[0] : p.owner[1]);
  std::sort(r.points.begin(), r.points.end(), [](const ContactPoint& p, const ContactPoint& q) {
    const auto order = [](const ContactPoint& x) {
      return std::tie(x.group, x.contact, x.limit, x.rolling);
    };
    return order(p) < order(q);
  });
  for (std::uint32_t i = 0; i < r.points.size(); ++i)
    for (int s = 0; s < 2; ++s) {
      const ContactPoint& p = r.points[i];
      if (p.owner[s] == kNoIndex) continue;
      ContactEnd end;
      end.island = p.owner[s], end.point = i, end.column = p.column[s], end.sign = s == 0 ? 1 : -1;
      r.ends.push_back(end);
    }
  std::sort(r.ends.begin(), r.ends.end(), [&](const ContactEnd& e, const ContactEnd& f) {
    const auto order = [&](const ContactEnd& x) {
      return std::tuple(r.points[x.point].group, x.island, x.point, -x.sign);
    };
    return order(e) < order(f);
  });
}

void list_members(ContactScratch& r) {
  for (std::uint32_t i = 0; i < r.ends.size(); ++i) {
    ContactEnd& e = r.ends[i];
    if (r.members.empty() || r.members.back().island != e.island) {
      GroupMember m;
      m.group = r.points[e.point].group, m.island = e.island, m.first_end = i;
      r.members.push_back(m);
    }
    PANTIN_ASSERT(e.point < r.points.size());
    e.member = static_cast<std::uint32_t>(r.members.size() - 1);
    ++r.members.back().ends;
    r.points[e.point].end[e.sign > 0 ? 0 : 1] = i;
  }
  std::size_t numbers = 0;
  for (GroupMember& m : r.members)
    m.first_response = numbers, numbers += std::size_t(9) * m.ends * m.ends;
  r.responses.resize(numbers);
  std::size_t member = 0;
  for (std::size_t i = 0; i < r.points.size(); ++i) {
    if (r.groups.empty() || r.points[i].group != r.points[i - 1].group) {
      ContactScratch::Range range;
      range.first_point = i, range.first_member = member;
      while (member < r.members.size() && r.members[member].group == r.points[i].group) ++member;
      range.members = member - range.first_member;
      r.groups.push_back(range);
    }
    ++r.groups.back().points;
  }
}

/// Rates of an end along its axes, from two vectors a body.
Vec3 end_rates(const ContactScratch& r, const ContactEnd& end, std::span<const Vec3> motion) {
  const ContactPoint& p = r.points[end.point];
  if (p.is_limit()) {
    const LimitRowAt& row = r.limits[p.limit];
    Real rate = 0;
    for (std::size_t k = 0; k < row.count; ++k)
      rate += glm::dot(row.j[2 * k], motion[2 * row.body[k]]) +
              glm::dot(row.j[2 * k + 1], motion[2 * row.body[k] + 1]);
    return {rate, 0, 0};
  }
  const Vec3 turn = motion[2 * end.column + 1];
  const Vec3 v = p.is_rolling() ? r.rollings[p.rolling].arm * turn
                                : motion[2 * end.column] + glm::cross(turn, end.arm);
  return contact::along_axes(p.axes, end.sign * v);
}

/// The speed of a body's point.
Vec3 speed_at(const Motions& s, const ContactEnd& e) {
  return s.v[e.column] + glm::cross(s.w[e.column], e.lead);
}

Real limit_rate(const LimitRowAt& row, const Motions& s) {
  Real rate = row.frame_rate;
  for (std::size_t k = 0; k < row.count; ++k)
    rate += glm::dot(row.j[2 * k], s.v[row.body[k]]) + glm::dot(row.j[2 * k + 1], s.w[row.body[k]]);
  return rate;
}

}  // namespace

void add_end_force(const ContactScratch& r, const ContactEnd& end, Vec3 along,
                   std::span<Vec3> force) {
  const ContactPoint& p = r.points[end.point];
  if (p.is_limit()) {
    const LimitRowAt& row = r.limits[p.limit];
    for (std::size_t k = 0; k < row.count; ++k)
      force[2 * row.body[k]] += along.x * row.j[2 * k],
          force[2 * row.body[k] + 1] += along.x * row.j[2 * k + 1];
    return;
  }
  PANTIN_ASSERT(2 * end.column + 1 < force.size());
  const Vec3 f = end.sign * contact::in_world(p.axes, along);
  if (p.is_rolling()) {
    force[2 * end.column + 1] += r.rollings[p.rolling].arm * f;
    return;
  }
  force[2 * end.column] += f, force[2 * end.column + 1] += glm::cross(end.arm, f);
}

void gather_contacts(World& world, Real h) {
  ContactScratch& r = world.memory.of<Islands>().contacts;
  r.points.clear(), r.ends.clear(), r.limits.clear(), r.members.clear(), r.groups.clear();
  std::vector<Island>& all = islands_of(world);
  r.sets.reset(all.size()), r.touched.assign(all.size(), 0);
  list_points(world, r, h);
  for (std::uint32_t i = 0; i < all.size(); ++i) {
    if (!r.touched[i]) continue;
    for (std::size_t k = 0; k < all[i].frames.size(); ++k) {
      all[i].frames[k].begin(all[i].scratch.frame_starts[k]);
    }
    take_up(world, r, i, h);
  }
  sort_points(r);
  find_rolling_points(r);
  list_members(r);
}

void place_points(World& world, const ContactGroup& g) {
  ContactScratch& r = world.memory.of<Islands>().contacts;
  for (ContactPoint& p : g.points) {
    if (p.is_limit()) {
      const LimitRowAt& row = r.limits[p.limit];
      const Island& m = islands_of(world)[row.island];
      p.gap = m.scratch.c[m.blocks[row.block].first_row];
      continue;
    }
    if (p.is_rolling()) continue;
    Vec3 at[2];
    for (int s = 0; s < 2; ++s) {
      const Vec3 outward = (s == 0 ? -1.0 : 1.0) * p.axes[0];
      if (p.end[s] == kNoIndex) {
        const Pose& pose = p.obstacle[s].pose;
        at[s] = pose.position + p.on[s].at(pose.rotation, outward);
        continue;
      }
      ContactEnd& e = r.ends[p.end[s]];
      const StepScratch& scratch = islands_of(world)[e.island].scratch;
      PANTIN_ASSERT(e.column < scratch.state.q.size() &&
                    scratch.entry.q.size() == scratch.state.q.size());
      const Quat end = scratch.state.q[e.column];
      e.arm = e.lead = p.on[s].at(end, outward);
      at[s] = scratch.state.x[e.column] + e.arm;
      if (p.on[s].circle == 0) continue;
      // The point of a rim travels: its impulse acts at the position half-way through the step.
      Quat begin = scratch.entry.q[e.column];
      if (glm::dot(begin, end) < 0) begin = -begin;
      e.arm = p.on[s].at(glm::normalize(begin + end), outward);
    }
    p.gap = glm::dot(p.axes[0], at[0] - at[1]);
  }
}

int parts_of(const World& world, const ContactGroup& g) {
  const ContactScratch& r = world.memory.of<Islands>().contacts;
  for (const GroupMember& member : g.members)
    if (const Island& m = islands_of(world)[member.island]; !m.blocks.empty() || !m.touches.empty())
      return 1;
  if (g.points.size() > kMostRimPoints) return 1;
  Real most = 0;
  for (const ContactPoint& p : g.points) {
    if (p.obstacle[0].moves() || p.obstacle[1].moves()) return 1;
    if (p.gap_before > kOnRim) continue;
    for (const int side : {0, 1}) most = std::max(most, g.h * rate_around(world, r, p, side));
  }
  return std::clamp(static_cast<int>(std::ceil(most / kMostAround)), 1, kMostRimParts);
}

void join_rims(const ContactGroup& g) {
  for (const ContactPoint& low : g.points)
    for (ContactPoint& p : g.points)
      for (const int side : {0, 1}) {
        const contact::TouchedPlace& rim = low.on[side];
        if (rim.circle > 0 && p.is_contact() && p.on[side].lies_on(rim) && has_same_bodies(p, low))
          p.on[side] = rim;
      }
}

void find_speeds(const World& world, const ContactGroup& g) {
  const ContactScratch& r = world.memory.of<Islands>().contacts;
  for (ContactPoint& p : g.points) {
    if (p.is_limit()) {
      const LimitRowAt& row = r.limits[p.limit];
      p.speed = {limit_rate(row, islands_of(world)[row.island].scratch.state), 0, 0};
      continue;
    }
    if (p.is_rolling()) {
      p.speed = rolling_speed(world, r, p);
      continue;
    }
    Vec3 now(0), before(0);
    for (int s = 0; s < 2; ++s) {
      const Real sign = s == 0 ? 1 : -1;
      if (p.end[s] == kNoIndex) {
        const Obstacle& o = p.obstacle[s];
        const Vec3 arm = p.on[s].at(o.pose.rotation, -sign * p.axes[0]);
        const Vec3 v = o.velocity + glm::cross(o.spin, arm);
        now += sign * v, before += sign * v;
        continue;
      }
      const ContactEnd& e = r.ends[p.end[s]];
      const StepScratch& scratch = islands_of(world)[e.island].scratch;
      now += sign * speed_at(scratch.state, e), before += sign * speed_at(scratch.entry, e);
    }
    // A conveyor surface moves tangentially only.
    const Vec3 slip = now + contacts_of(world)[p.contact].surface_velocity;
    p.speed = {glm::dot(p.axes[0], now), glm::dot(p.axes[1], slip), glm::dot(p.axes[2], slip)};
    p.pull = glm::dot(p.axes[0], now - before) / g.h;
  }
}

void find_responses(World& world, const GroupMember& member) {
  ContactScratch& r = world.memory.of<Islands>().contacts;
  Island& m = islands_of(world)[member.island];
  const std::size_t n = std::size_t(3) * member.ends;
  Real* w = &r.responses[member.first_response];
  std::fill(m.scratch.right.begin(), m.scratch.right.end(), 0.0);
  const std::span<const ContactEnd> ends =
      std::span<const ContactEnd>(r.ends).subspan(member.first_end, member.ends);
  for (std::size_t e = 0; e < ends.size(); ++e)
    for (int k = 0; k < 3; ++k) {
      const bool none = k > 0 && r.points[ends[e].point].is_limit();
      if (!none) {
        Vec3 along(0);
        along[k] = 1;
        std::fill(m.scratch.momenta.begin(), m.scratch.momenta.end(), Vec3(0));
        add_end_force(r, ends[e], along, m.scratch.momenta);
        solve(m, {m.scratch.momenta, m.scratch.right}, {m.scratch.solution, m.scratch.lambda});
      }
      for (std::size_t f = 0; f < ends.size(); ++f) {
        const Vec3 rates = none ? Vec3(0) : end_rates(r, ends[f], m.scratch.solution);
        for (int l = 0; l < 3; ++l)
          w[(3 * f + std::size_t(l)) * n + 3 * e + std::size_t(k)] = rates[l];
      }
    }
}

void find_own_responses(World& world, const ContactGroup& g) {
  ContactScratch& r = world.memory.of<Islands>().contacts;
  for (ContactPoint& p : g.points) {
    p.response = Mat3(0);
    Real free = 0;
    for (int s = 0; s < 2; ++s) {
      if (p.end[s] == kNoIndex) continue;
      const ContactEnd& e = r.ends[p.end[s]];
      const GroupMember& member = r.members[e.member];
      const Island& m = islands_of(world)[e.island];
      free +=
          p.is_rolling() ? free_rolling(m, e.column, r.rollings[p.rolling]) : 1 / m.mass[e.column];
      for (int t = 0; t < 2; ++t) {
        if (p.end[t] == kNoIndex || r.ends[p.end[t]].member != e.member) continue;
        const std::size_t n = std::size_t(3) * member.ends;
        const Real* w = &r.responses[member.first_response + 3 * (p.end[s] - member.first_end) * n +
                                     3 * (p.end[t] - member.first_end)];
        for (std::size_t l = 0; l < 3; ++l)
          for (std::size_t k = 0; k < 3; ++k) p.response[int(k)][int(l)] += w[l * n + k];
      }
    }
    const Real most =
        p.is_rolling() ? std::max(p.response[0][0], softest_of(p.response)) : p.response[0][0];
    p.works = most > (p.is_limit() ? 0 : kLeastResponse * free);
  }
}

}  // namespace pantin::detail::lagrangian
