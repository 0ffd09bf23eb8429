// Which free bodies touch, and how they enter and leave their step (free_bodies.cpp).
#include <algorithm>
#include <optional>
#include <utility>

#include "engine/base/rotation.hpp"
#include "engine/contact/detect.hpp"
#include "engine/geometry/kinds.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::articulated {
namespace {

constexpr std::uint32_t kNone = UINT32_MAX;
/// Of that overlap: what is left to take up when bodies fall asleep.
constexpr Real kSettled = 5e-4;
/// Sleep conserves forces as they are: it waits until hardly anything moves, but not for ever (s).
constexpr Real kDead = 1e-3, kPatience = 8;
/// Overlaps up to this fraction of the size of a body are removed by translating it.
constexpr Real kShallow = 5e-3;

bool is_free_body(const Island& a) {
  return a.count() == 1 && !a.unfit && a.finite && a.settings.solver == Solver::articulated &&
         a.parents[0] == kFree && !a.follows && a.pins.empty() && a.cables.empty() &&
         a.joints.empty();
}

Real radius_of(const World& world, std::uint32_t slot, std::uint64_t index) {
  const Shapes* shapes = world.shapes.find(world.bodies.owners()[slot]);
  if (!shapes || index >= shapes->list.size()) return 0;
  const Shape& s = shapes->list[index];
  const auto rounded = traits_of(s.kind).rounded;
  const std::optional<RoundedBox> core = rounded ? rounded(s) : std::nullopt;
  return core ? core->radius : 0;
}

}  // namespace

void plan_free_bodies(World& world, Real h) {
  Islands& all = world.memory.of<Islands>();
  FreeScratch& r = all.free;
  std::vector<Contact>& contacts = contacts_of(world);
  const Partition& partition = partition_of(world);
  r.sets.reset(all.list.size()), r.group_of.resize(all.list.size());
  r.eligible.assign(all.list.size(), 1), r.awake.assign(all.list.size(), 0);
  const auto island_at = [&](std::uint32_t slot) { return owner_of(partition, slot).island; };
  for (const Contact& c : contacts) {
    if (!contact::feels_contacts(partition, c.slot_b)) continue;
    r.sets.join(island_at(c.slot_a), island_at(c.slot_b));
  }
  for (std::uint32_t i = 0; i < all.list.size(); ++i) {
    Island& a = all.list[i];
    a.free_body = false;
    const std::uint32_t group = r.sets.root(i);
    r.group_of[i] = group;
    if (!is_free_body(a)) r.eligible[group] = 0;
    if (!a.asleep) r.awake[group] = 1;
  }
  for (std::uint32_t i = 0; i < all.list.size(); ++i) {
    Island& a = all.list[i];
    const std::uint32_t group = r.group_of[i];
    const bool free = r.eligible[group] != 0;
    // Who touches somebody awake is awake.
    if (a.asleep && (r.awake[group] != 0 || (a.mutual && !free))) wake(world, a, h);
    for (const ContactRow& row : a.scratch.contact_rows)
      if (!free) contacts[row.contact].rest = 0;
    if (!free || a.scratch.contact_rows.empty()) continue;
    a.free_body = true, a.mutual = false;
  }
}

namespace {

FreeBody gather_body(const World& world, std::uint32_t slot, Real h) {
  const Body& b = world.bodies.values()[slot];
  FreeBody f;
  f.slot = slot;
  f.pose = b.pose, f.velocity = b.velocity, f.spin = b.angular_velocity;
  if (contact::feels_contacts(partition_of(world), slot)) return f;
  if (!contact::moves(b)) {
    f.velocity = f.spin = Vec3(0);
    return f;
  }
  f.pose = contact::pose_before(b, h);
  return f;
}

FreeBody gather_body(const World& world, const Island& a, std::uint32_t number) {
  FreeBody f = gather_body(world, a.slots[0], 0);
  f.island = number;
  const Real mass = a.constants.at(kMass, 0);
  const Vec3 inertia = a.constants.vec(kInertia, 0);
  f.per_mass = 1 / mass, f.per_inertia = Real(1) / inertia;
  f.drag = a.constants.at(kDrag, 0);
  f.acceleration = a.constants.at(kGravityScale, 0) * world.gravity;
  if (const Force* force = world.forces.find(a.bodies[0]))
    f.acceleration += force->force / mass, f.torque = force->torque;
  f.response = inverse_inertia(f, f.pose.rotation);
  const Mat3 r = glm::mat3_cast(f.pose.rotation);
  f.angular_momentum = r * (inertia * (glm::transpose(r) * f.spin));
  return f;
}

FreeContact gather_contact(const World& world, std::uint32_t number, const Island& island) {
  const Contact& c = contacts_of(world)[number];
  const Body &a = world.bodies.values()[c.slot_a], &b = world.bodies.values()[c.slot_b];
  FreeContact f;
  f.contact = number;
  f.axes[0] = c.normal;
  const Vec3 aside = std::abs(c.normal.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  f.axes[1] = glm::normalize(glm::cross(c.normal, aside));
  f.axes[2] = glm::cross(c.normal, f.axes[1]);
  // Round shapes are touched below their core, however they turn; corners turn with the body.
  f.radius_a = radius_of(world, c.slot_a, c.key >> 54 & 0x3ff);
  f.radius_b = radius_of(world, c.slot_b, c.key >> 44 & 0x3ff);
  f.core_a = c.point_a + f.radius_a * (glm::conjugate(a.pose.rotation) * c.normal);
  f.core_b = c.point_b - f.radius_b * (glm::conjugate(b.pose.rotation) * c.normal);
  f.friction = c.friction, f.restitution = c.restitution, f.rest = c.rest;
  f.shallow = kShallow * island.size;
  // From the multiplier to the mean force.
  const Real per =
      island.last_step > 0 && !island.fresh ? 1 / (island.last_step * island.last_step) : 0;
  const Vec3 force = per * c.lambda;
  f.impulse = {std::max(Real(0), glm::dot(force, f.axes[0])), glm::dot(force, f.axes[1]),
               glm::dot(force, f.axes[2])};
  if (!is_finite(f.impulse) || f.impulse.x == 0) f.impulse = Vec3(0);
  return f;
}

/// Contacts by group, bodies of each group with the fixed ones that it touches.
void gather(const World& world, FreeScratch& r, Real h) {
  const Partition& partition = partition_of(world);
  const std::vector<Island>& list = islands_of(world);
  const std::vector<Contact>& contacts = contacts_of(world);
  r.order.clear(), r.groups.clear(), r.bodies.clear(), r.contacts.clear();
  const auto group_at = [&](std::uint32_t contact) {
    return r.group_of[owner_of(partition, contacts[contact].slot_a).island];
  };
  for (std::uint32_t i = 0; i < contacts.size(); ++i) {
    const Island& a = list[owner_of(partition, contacts[i].slot_a).island];
    if (a.free_body && !a.asleep) r.order.push_back(i);
  }
  std::sort(r.order.begin(), r.order.end(), [&](std::uint32_t i, std::uint32_t j) {
    return std::pair(group_at(i), i) < std::pair(group_at(j), j);
  });
  r.index.resize(world.bodies.size());
  for (std::size_t from = 0; from < r.order.size();) {
    std::size_t to = from;
    while (to < r.order.size() && group_at(r.order[to]) == group_at(r.order[from])) ++to;
    FreeScratch::Range range{r.bodies.size(), 0, r.contacts.size(), 0};
    const auto add = [&](std::uint32_t slot, FreeBody body) {
      r.index[slot] = static_cast<std::uint32_t>(r.bodies.size() - range.first_body);
      r.bodies.push_back(std::move(body));
    };
    for (std::size_t i = from; i < to; ++i) {
      const Contact& c = contacts[r.order[i]];
      r.index[c.slot_a] = r.index[c.slot_b] = kNone;
    }
    for (const bool fixed : {false, true})  // free ones first
      for (std::size_t i = from; i < to; ++i) {
        const Contact& c = contacts[r.order[i]];
        for (const std::uint32_t slot : {c.slot_a, c.slot_b}) {
          const Owner owner = owner_of(partition, slot);
          if (owner.feels_contacts == fixed || r.index[slot] != kNone) continue;
          add(slot, fixed ? gather_body(world, slot, h)
                          : gather_body(world, list[owner.island], owner.island));
        }
      }
    for (std::size_t i = from; i < to; ++i) {
      const Contact& c = contacts[r.order[i]];
      r.contacts.push_back(
          gather_contact(world, r.order[i], list[owner_of(partition, c.slot_a).island]));
      r.contacts.back().a = r.index[c.slot_a], r.contacts.back().b = r.index[c.slot_b];
    }
    range.bodies = r.bodies.size() - range.first_body;
    range.contacts = r.contacts.size() - range.first_contact;
    r.groups.push_back(range);
    from = to;
  }
}

/// The body, and what the next step of its island starts from. False if it is lost.
bool write_body(World& world, const FreeBody& f, Real h) {
  Island& a = islands_of(world)[f.island];
  Body& b = world.bodies.values()[f.slot];
  const Vec3 x = f.pose.position;
  if (!(is_finite(f.pose) && is_finite(f.velocity) && is_finite(f.spin) &&
        glm::dot(x, x) < kTooFar * kTooFar)) {
    a.lost = a.bodies[0];
    return false;
  }
  a.memory.set(kLastTranslation, 0, x - b.pose.position);
  a.memory.set(kLastRotation, 0,
               rotation_vector(f.pose.rotation * glm::conjugate(b.pose.rotation)));
  b.pose = f.pose, b.velocity = f.velocity, b.angular_velocity = f.spin;
  a.trees[0].knows_angular_momentum = false;
  a.limited = a.disturbed = false, a.in_contact = true;
  a.contact_active = false;
  a.force_share = 1, a.reserve = 0, a.sweeps_used = a.active_set_iterations_used = 0;
  remember_step(world, a, h);
  a.calm_steps = 0;  // the other rules have no history to go on
  return true;
}

void write_contact(World& world, const FreeContact& f, Real h) {
  Contact& c = contacts_of(world)[f.contact];
  c.lambda = h * h * to_world(f, f.impulse);
  c.force = to_world(f, f.passed) / h;
  c.active = f.passed.x > 0, c.impact = 0, c.sliding = 1, c.rest = f.rest;
  c.depth = std::max(Real(0), -f.gap);
}

/// Whether the springs of a group have taken up their loads.
bool is_settled(std::span<const FreeContact> contacts) {
  return std::all_of(contacts.begin(), contacts.end(),
                     [](const FreeContact& c) { return c.settling <= kSettled * c.shallow; });
}

/// A group sleeps once all of it has been still for long enough.
void let_sleep(World& world, std::span<const FreeBody> bodies,
               std::span<const FreeContact> contacts, Real h) {
  const bool settled = is_settled(contacts);
  bool still = true;
  for (const FreeBody& f : bodies) {
    if (f.per_mass == 0) {
      still = still && f.velocity == Vec3(0) && f.spin == Vec3(0);
      continue;
    }
    Island& a = islands_of(world)[f.island];
    const Body& b = world.bodies.values()[f.slot];
    const Real slow = a.settings.sleep_speed;
    const bool quiet = a.contact_active && glm::length(b.velocity) < slow &&
                       glm::length(b.angular_velocity) < 10 * slow;
    a.quiet_time = quiet ? a.quiet_time + h : 0;
    const bool dead = glm::length(b.velocity) < kDead * slow &&
                      glm::length(b.angular_velocity) < 10 * kDead * slow;
    still = still && a.quiet_time > (dead && settled ? kTimeToSleep : kPatience);
  }
  if (!still) return;
  for (const FreeBody& f : bodies)
    if (f.per_mass > 0) fall_asleep(world, islands_of(world)[f.island]);
}

}  // namespace

void step_free_bodies(World& world, const StepTask& task) {
  FreeScratch& r = world.memory.of<Islands>().free;
  gather(world, r, task.h);
  const Real h = task.h;
  for_each_island(r.groups.size(), task.threads, [&](std::size_t i) {
    const FreeScratch::Range& g = r.groups[i];
    step_free_group(std::span(r.bodies).subspan(g.first_body, g.bodies),
                    std::span(r.contacts).subspan(g.first_contact, g.contacts), h);
  });
  for (const FreeBody& b : r.bodies)
    if (b.per_mass > 0) write_body(world, b, h);
  for (const FreeContact& c : r.contacts) write_contact(world, c, h);
  for (const FreeScratch::Range& g : r.groups) {
    const auto bodies = std::span(r.bodies).subspan(g.first_body, g.bodies);
    const auto contacts = std::span(r.contacts).subspan(g.first_contact, g.contacts);
    for (const FreeContact& c : contacts) {
      if (!(c.passed.x > 0)) continue;
      islands_of(world)[bodies[c.a].island].contact_active = true;
      if (bodies[c.b].per_mass > 0) islands_of(world)[bodies[c.b].island].contact_active = true;
    }
    let_sleep(world, bodies, contacts, h);
  }
}

}  // namespace pantin::detail::articulated
