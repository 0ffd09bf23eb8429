// Assigns contacts to islands.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/contact/detect.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/joints/joint_force.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::articulated {
namespace {

/// Distance of a hub from a mass centre, as a fraction of the island's size.
constexpr Real kHub = 1e-6;

/// Margins on the predicted displacement of any body of an island in a step, m: its moving anchors,
/// gravity, and what actuates its joints.
struct Margin {
  Real anchors = 0, gravity = 0, actuators = 0;
};

/// Bound on the displacement of a body's surface in this step: the predicted one, and a margin for
/// joints.
Real reach_of(const Shapes* shapes, const contact::Displacement& by, const Margin& margin) {
  if (!shapes) return 0;
  const Real extent = contact::extent_of(*shapes);
  const Real way = glm::length(by.translation) + extent * glm::length(by.rotation);
  return contact::kReachFactor * way + margin.anchors + 0.02 * extent + margin.gravity +
         margin.actuators;
}

contact::Displacement displacement_of(const World& world, const Island& a, std::size_t c) {
  const Pose& from = world.bodies.values()[a.slots[c]].pose;
  return {a.scratch.work.vec(kPosition, c) - from.position,
          rotation_vector(a.scratch.work.quat(kRotation, c) * glm::conjugate(from.rotation))};
}

/// Largest displacement of the island's anchors in this step.
Real displacement_of_targets(const Island& a) {
  Real most = 0;
  for (const Tree& t : a.trees)
    if (a.parents[t.first] == kHeld) most = std::max(most, glm::length(t.target - t.target_before));
  for (const PackedPin& constraint : a.pins)
    most = std::max(most, glm::length(constraint.target - constraint.target_before));
  return most;
}

/// Whether a body is the last of its branch and rotates about its mass centre, as a wheel does.
bool is_wheel(const Island& a, std::size_t c) {
  const bool is_last = c + 1 >= a.count() || a.parents[c + 1] != static_cast<std::int32_t>(c);
  return is_last && glm::length(a.constants.vec(kOwnAnchor, c)) < kHub * a.size;
}

/// Bound on the displacement by springs and motors of joints, beyond that at the present rates: as
/// if nothing were outboard of their bodies. Wheels stay where they are.
Real displacement_by_actuators(const World& world, const Island& a, Real h) {
  Real turned = 0;  // rad
  for (std::size_t c = 0; c < a.joints.size(); ++c) {
    if (!a.joints[c].stiff || !is_actuated(a.joints[c]) || a.parents[c] == kFree) continue;
    if (is_wheel(a, c)) continue;
    const Vec3 i = a.constants.vec(kInertia, c), arm = a.constants.vec(kOwnAnchor, c);
    const Real inertia = std::min({i.x, i.y, i.z}) + a.constants.at(kMass, c) * glm::dot(arm, arm);
    const Real rate = rate_of(world, a, c);
    turned += h * std::abs(rate_after(dof_of(world, a, c), {a.joint_memory[c].angle, rate, h},
                                      1 / inertia) -
                           rate);
  }
  return turned * a.size;
}

}  // namespace

bool is_own(const World& world, std::uint32_t slot) {
  const Owner owner = owner_of(partition_of(world), slot);
  return owner && owner.solver == kArticulated;
}

void keep_sleeping_contacts(World& world, Island& a, Real h) {
  const Real to_force = 1 / (h * h);
  for (const ContactRow& t : a.scratch.contact_rows) {
    if (t.side < 0) continue;
    Contact& c = contacts_of(world)[t.contact];
    c.force = to_force * c.lambda, c.depth = std::max(Real(0), -c.gap);
  }
}

void find_reaches(const World& world, Real h, const contact::Reaches& out) {
  const std::span<Real> reach = out.reach;
  PANTIN_ASSERT(reach.size() >= world.bodies.size());
  const Islands& all = world.memory.of<Islands>();
  for (const RestLists::Sleeper& s : all.rest.sleepers) {
    if (s.slot != kNoSlot) {
      reach[s.slot] = contact::kAtRest;
      continue;
    }
    for (const std::uint32_t slot : all.list[s.island].slots) reach[slot] = contact::kAtRest;
  }
  each_awake(world, [&](const Island& a) {
    PANTIN_ASSERT(a.scratch.predicted);
    const Margin margin{displacement_of_targets(a), glm::length(world.gravity) * h * h,
                        displacement_by_actuators(world, a, h)};
    for (std::size_t c = 0; c < a.count(); ++c)
      if (const Collision* collision = world.collisions.find(a.bodies[c]);
          collision && !collision->sensor) {
        const std::uint32_t slot = a.slots[c];
        out.displacement[slot] = displacement_of(world, a, c);
        reach[slot] = reach_of(world.shapes.find(a.bodies[c]), out.displacement[slot], margin);
      }
  });
}

bool all_asleep(const World& world) {
  const Islands& all = world.memory.of<Islands>();
  return all.rest.version == partition_of(world).rest_version && all.rest.awake.empty();
}

namespace {

/// One of the two bodies of a contact.
enum class ContactBody : std::uint8_t { a, b };

/// Assigns a contact to the island of one of its bodies; wakes it for a moving body or surface.
void take_contact(World& world, std::uint32_t contact, ContactBody which, Real h) {
  const bool is_a = which == ContactBody::a;
  const Contact& c = contacts_of(world)[contact];
  const Partition& partition = partition_of(world);
  const bool mutual = is_own(world, c.slot_b);
  const Owner at = owner_of(partition, is_a ? c.slot_a : c.slot_b);
  Island& a = islands_of(world)[at.island];
  PANTIN_ASSERT(at.solver == kArticulated && at.column < a.count());
  const Body& b = world.bodies.values()[c.slot_b];
  const bool comes = !mutual && (contact::moves(b) || b.restart || b.teleport);
  const bool runs = c.active && c.surface_velocity != Vec3(0);  // a moving surface
  if (a.asleep && (comes || runs)) wake(world, a, h);
  if (a.asleep && a.scratch.contact_rows.empty())
    world.memory.of<Islands>().rest.touched.push_back(at.island);
  ContactRow t;
  t.contact = contact, t.column = at.column, t.side = is_a ? 1 : -1;
  a.scratch.contact_rows.push_back(t);
}

}  // namespace

void assign_contacts(World& world, Real h) {
  RestLists& rest = rest_lists(world);
  IslandVector& list = islands_of(world);
  for (const std::uint32_t i : rest.awake) list[i].scratch.contact_rows.clear();
  for (const std::uint32_t i : rest.touched) list[i].scratch.contact_rows.clear();
  rest.touched.clear();
  const std::vector<Contact>& contacts = contacts_of(world);
  for (std::uint32_t i = 0; i < contacts.size(); ++i) {
    if (!is_own(world, contacts[i].slot_a)) continue;
    take_contact(world, i, ContactBody::a, h);
    if (is_own(world, contacts[i].slot_b)) take_contact(world, i, ContactBody::b, h);
  }
}

void take_contacts(World& world, Real h) {
  for (Contact& c : contacts_of(world)) {
    if (!is_own(world, c.slot_a)) continue;
    const Body& b = world.bodies.values()[c.slot_b];
    if (!is_own(world, c.slot_b) && contact::moves(b))
      c.normal = glm::normalize(from_rotation_vector(h * b.angular_velocity) * c.normal);
    c.active = glm::dot(c.lambda, c.normal) > 0;
  }
  assign_contacts(world, h);
  plan_contact_groups(world, h);
  for (const std::uint32_t i : world.memory.of<Islands>().rest.touched)
    if (Island& a = islands_of(world)[i]; a.asleep) keep_sleeping_contacts(world, a, h);
}

}  // namespace pantin::detail::articulated
