// Contacts as augmented-Lagrangian rows of their bodies: any number of them, redundant or not,
// costs one inward and one outward pass.
//
// A row pulls the contact point p to its goal with the force
//   f = l + w n n.(goal - p) + g (1 - n n^T)(goal - p)
// and updates the multiplier l from the result. The normal component is at least zero. Friction is
// at most mu times the normal force; for a sliding point the tangential stiffness g is reduced to
// match that bound (lagged, isotropic). [Alart & Curnier 1991, augmented Lagrangian]
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/contact/detect.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/articulated/push_out.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::articulated {
namespace {

/// Stiffness of contact rows relative to the island's mass. The multipliers correct the rest; a
/// larger weight would amplify rounding errors of redundant contacts.
constexpr Real kRowWeight = 30;
/// Position error below which a contact counts as at rest, relative to the size.
constexpr Real kRestTolerance = 1e-5;
/// Slip below which the friction bound need not have converged, relative to the size.
constexpr Real kSlipTolerance = 1e-6;
/// Penetrations up to this fraction of the size are removed by translating a free tree.
constexpr Real kShallowOverlap = 5e-3;
/// Multipliers beyond this bound (squared, kg^2 m^2) are discarded.
constexpr Real kMaxLambdaSquared = 1e36;
/// Slower impacts are inelastic, m/s.
constexpr Real kRestitutionThreshold = 0.2;

/// What may add to the predicted displacement of any body of an island in one step, m: its moving
/// anchors, and gravity.
struct Margin {
  Real anchors = 0, gravity = 0;
};

/// Bound on the displacement of a body's surface in this step: the predicted one, and a margin for
/// joints.
Real reach_of(const World& world, const Island& a, std::size_t c, const Margin& margin) {
  const Body& b = world.bodies.values()[a.slots[c]];
  const Shapes* shapes = world.shapes.find(a.bodies[c]);
  if (!shapes) return 0;
  const Real extent = contact::extent_of(*shapes);
  const Real translation = glm::length(a.scratch.work.vec(kPosition, c) - b.pose.position);
  const Quat rotation = a.scratch.work.quat(kRotation, c) * glm::conjugate(b.pose.rotation);
  return 1.25 * (translation + extent * glm::length(rotation_vector(rotation))) + margin.anchors +
         0.02 * extent + margin.gravity;
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

/// Displacement of a point of a fixed or kinematic body over the step.
Vec3 way_of(const Body& b, Vec3 at, Real h) {
  return contact::moves(b) ? h * (b.velocity + glm::cross(b.angular_velocity, at - b.pose.position))
                           : Vec3(0);
}

Vec3 final_point(const Island& a, std::size_t column, Vec3 anchor) {
  return point_at(a, column, anchor, kFinalPoses);
}

/// The component of a vector perpendicular to a unit normal.
Vec3 across(Vec3 v, Vec3 n) { return v - glm::dot(v, n) * n; }

/// Approach speed of two bodies at a contact, m/s, before the step.
Real approach(const World& world, const Contact& c) {
  const auto speed = [&](std::uint32_t slot, Vec3 point) {
    const Body& b = world.bodies.values()[slot];
    return b.velocity + glm::cross(b.angular_velocity, b.pose.rotation * point);
  };
  return -glm::dot(c.normal, speed(c.slot_a, c.point_a) - speed(c.slot_b, c.point_b));
}

/// A step or a part of one: its length, s, and the number of equal parts that follow it.
struct Substep {
  Real h = 0;
  int left = 0;
};

/// Goal of a's point in contact with a fixed or kinematic body.
Vec3 goal_of(const World& world, const Contact& c, Vec3 start, const Substep& now) {
  const Body& b = world.bodies.values()[c.slot_b];
  Vec3 end = to_world(b.pose, c.point_b);
  const Vec3 way = way_of(b, end, now.h);
  end -= Real(now.left) * way;
  const Vec3 bias = start + way - now.h * across(c.surface_velocity, c.normal);
  return bias + (glm::dot(c.normal, end - bias) + now.h * c.impact) * c.normal;
}

/// What a pass left open at a contact, m: the way from the point to its goal, and the remaining
/// penetration.
struct ContactError {
  Vec3 to_goal{0};
  Real depth = 0;
};

/// Active-set update of one contact after a pass, by the stiffness of its row, kg, and the size of
/// the island, m. True if unchanged.
bool update_active_set(Contact& c, const ContactError& left, Real weight, Real size) {
  const auto& [error, depth] = left;
  PANTIN_ASSERT(is_unit(c.normal));
  const Real residual = glm::dot(error, c.normal);
  if (!c.active) {
    if (!(depth > 1e-9 * size)) return true;
    c.active = true, c.lambda = Vec3(0), c.sliding = 1;
    return false;
  }
  const Real normal = glm::dot(c.lambda, c.normal) + weight * residual;
  const bool still = glm::dot(error, error) < kRestTolerance * kRestTolerance * size * size;
  if (normal <= 0 && still) return true;  // practically at rest: stays active
  if (normal <= 0) {
    c.active = false, c.lambda = Vec3(0), c.sliding = 1;
    return false;
  }
  const Vec3 tangential = across(c.lambda, c.normal) + weight * across(error, c.normal);
  const Real most = c.friction * normal, held = glm::length(tangential), before = c.sliding;
  const bool sticks = held <= most;
  c.sliding = sticks ? 1 : most / held;
  c.force = normal * c.normal + c.sliding * tangential;
  c.lambda = normal * c.normal + (sticks ? tangential : Vec3(0));
  const Real slip = glm::length(across(error, c.normal));
  const bool rubs = (c.sliding < 1 || before < 1) && slip > kSlipTolerance * size;
  return depth < kRestTolerance * size && (!rubs || std::abs(c.sliding - before) <= 0.05 * before);
}

}  // namespace

bool is_own(const World& world, std::uint32_t slot) {
  const Owner owner = owner_of(partition_of(world), slot);
  return owner && owner.solver == kArticulated;
}

void keep_sleeping_contacts(World& world, Island& a, Real h) {
  PANTIN_ASSERT(a.asleep);
  const Real to_force = 1 / (a.force_share * h * h);
  for (const ContactRow& t : a.scratch.contact_rows) {
    if (t.side < 0) continue;
    Contact& c = contacts_of(world)[t.contact];
    c.force = to_force * c.lambda, c.depth = std::max(Real(0), -c.gap);
  }
  a.active_set_iterations_used = a.sweeps_used = 0, a.limited = false;
}

void find_reaches(const World& world, Real h, std::span<Real> reach) {
  PANTIN_ASSERT(reach.size() >= world.bodies.size());
  for (const Island& a : islands_of(world)) {
    if (a.asleep) {
      for (const std::uint32_t slot : a.slots) reach[slot] = contact::kAtRest;
      continue;
    }
    PANTIN_ASSERT(a.scratch.predicted);
    const Margin margin{displacement_of_targets(a), glm::length(world.gravity) * h * h};
    for (std::size_t c = 0; c < a.count(); ++c)
      if (const Collision* collision = world.collisions.find(a.bodies[c]);
          collision && !collision->sensor)
        reach[a.slots[c]] = reach_of(world, a, c, margin);
  }
}

bool all_asleep(const World& world) {
  const auto& islands = islands_of(world);
  return std::all_of(islands.begin(), islands.end(), [](const Island& a) { return a.asleep; });
}

namespace {

/// One of the two bodies of a contact.
enum class ContactBody : std::uint8_t { a, b };

/// Assigns a contact to the island of one of its bodies, which wakes where a body approaches.
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
  const bool runs = c.active && c.surface_velocity != Vec3(0);  // a belt under it
  if (a.asleep && (comes || runs)) wake(world, a, h);
  ContactRow t;
  t.contact = contact, t.column = at.column, t.side = is_a ? 1 : -1;
  a.mutual = a.mutual || mutual;
  a.scratch.contact_rows.push_back(t);
}

}  // namespace

void take_contacts(World& world, Real h) {
  for (Island& a : islands_of(world)) a.scratch.contact_rows.clear(), a.mutual = false;
  std::vector<Contact>& contacts = contacts_of(world);
  for (std::uint32_t i = 0; i < contacts.size(); ++i) {
    Contact& c = contacts[i];
    if (!is_own(world, c.slot_a)) continue;
    const Body& b = world.bodies.values()[c.slot_b];
    const bool mutual = is_own(world, c.slot_b);
    if (!mutual && contact::moves(b))
      c.normal = glm::normalize(from_rotation_vector(h * b.angular_velocity) * c.normal);
    c.active = glm::dot(c.lambda, c.normal) > 0 || c.impact > 0;
    // Negative: an approach, returned by restitution in the step after the impact.
    if (c.impact <= 0)
      c.impact =
          c.restitution > 0 && approach(world, c) > kRestitutionThreshold ? -approach(world, c) : 0;
    take_contact(world, i, ContactBody::a, h);
    if (mutual) take_contact(world, i, ContactBody::b, h);
  }
  plan_contact_groups(world, h);
}

void prepare_contacts(World& world, Island& a, Real h) {
  const Real ratio = a.last_step > 0 && !a.fresh ? h / a.last_step : 1;
  for (ContactRow& t : a.scratch.contact_rows) {
    Contact& c = contacts_of(world)[t.contact];
    const bool mutual = is_own(world, c.slot_b);
    if (t.side > 0 && ratio != 1) c.lambda *= ratio * ratio;
    if (t.side > 0 && !(glm::dot(c.lambda, c.lambda) < kMaxLambdaSquared))
      c.lambda = Vec3(0), c.active = false;
    if (t.side > 0) c.before = c.lambda;
    const Vec3 point = t.side > 0 ? c.point_a : c.point_b;
    const Vec3 arm = a.scratch.work.quat(kRotation, t.column) * point;
    t.predicted = a.scratch.work.vec(kPosition, t.column) + arm;
    t.arm = arm - a.scratch.work.vec(kArm, t.column);
    t.weight = kRowWeight * a.mass;
    t.nonlinearity = Vec3(0);
    if (mutual) continue;
    Contact given = c;
    given.impact = std::max(Real(0), c.impact);
    t.goal = goal_of(world, given, to_world(world.bodies.values()[c.slot_a].pose, point),
                     {.h = h, .left = a.substeps_left});
  }
}

void add_contact_rows(const World& world, Island& a, std::vector<JointBlock>& blocks) {
  for (ContactRow& t : a.scratch.contact_rows) {
    const Contact& c = contacts_of(world)[t.contact];
    if (!c.active) continue;
    PANTIN_ASSERT(t.side > 0 && c.sliding >= 0 && c.sliding <= 1);
    t.tangential = t.weight * c.sliding;
    const Vec3 n = c.normal;
    const Vec3 bearing = glm::dot(c.lambda, n) * n;
    const Vec3 held = bearing + c.sliding * (c.lambda - bearing);
    const Mat3 w = t.tangential * Mat3(1) + (t.weight - t.tangential) * glm::outerProduct(n, n);
    const Vec3 f = held + w * (t.goal - t.nonlinearity - t.predicted);
    const Mat3 k(0, t.arm.z, -t.arm.y, -t.arm.z, 0, t.arm.x, t.arm.y, -t.arm.x, 0);
    JointBlock& b = blocks[t.column];
    const Mat3 kw = k * w;
    b.yy += w, b.ty += kw, b.tt -= kw * k;
    b.gy += f, b.gt += glm::cross(t.arm, f);
  }
}

bool update_iterated(World& world, Island& a) {
  bool converged = true;
  for (ContactRow& t : a.scratch.contact_rows) {
    Contact& c = contacts_of(world)[t.contact];
    const Vec3 before = t.nonlinearity;
    if (t.side > 0) {
      const Vec3 slip = across(t.goal - moved_to(a, t), c.normal);
      const Real normal = glm::dot(c.lambda, c.normal);
      c.active = normal > 0, c.force = c.lambda;
      // Equivalent stiffness of a contact row; a sliding contact has no tangential multiplier.
      if (c.sliding < 1 && !is_own(world, c.slot_b)) {
        const Real whole = t.weight * glm::length(slip), most = c.friction * normal;
        c.sliding = whole > most ? most / whole : 1;
        c.lambda = normal * c.normal;
      }
    }
    update_nonlinearity(a, t, t.side > 0 ? c.point_a : c.point_b);
    if (is_own(world, c.slot_b))
      converged =
          converged && std::abs(glm::dot(c.normal, t.nonlinearity - before)) < 1e-5 * a.size;
    else
      converged = converged && glm::dot(c.normal, t.goal - moved_to(a, t)) < 1e-5 * a.size;
  }
  return converged;
}

bool update_contacts(World& world, Island& a) {
  bool converged = true;
  for (ContactRow& t : a.scratch.contact_rows) {
    Contact& c = contacts_of(world)[t.contact];
    PANTIN_ASSERT(t.side > 0);
    const Vec3 error = t.goal - moved_to(a, t);
    update_nonlinearity(a, t, c.point_a);
    const Real depth = glm::dot(c.normal, t.goal - moved_to(a, t));
    converged = update_active_set(c, {error, depth}, t.weight, a.size) && converged;
  }
  return converged;
}

void push_out_trees(World& world, Island& a) {
  for (const Tree& tree : a.trees) {
    if (a.parents[tree.first] != kFree) continue;
    PANTIN_ASSERT(tree.first + tree.count <= a.count());
    for (int round = 0; round < 4; ++round) {
      HalfSpaces planes;
      for (const ContactRow& t : a.scratch.contact_rows) {
        const Contact& c = contacts_of(world)[t.contact];
        if (is_own(world, c.slot_b) || t.column < tree.first || t.column >= tree.first + tree.count)
          continue;
        const Vec3 on_b = to_world(world.bodies.values()[c.slot_b].pose, c.point_b);
        const Real depth = glm::dot(c.normal, on_b - final_point(a, t.column, c.point_a));
        // Deep penetrations are left to the next step: translating the whole tree for one body
        // would add too much energy.
        if (depth > 0 && depth < kShallowOverlap * a.size) planes.add(c.normal, depth);
      }
      if (planes.count == 0) break;
      const Vec3 out = push_out(planes);
      for (std::size_t c = tree.first; c < tree.first + tree.count; ++c)
        a.scratch.work.set(kFinalPosition, c, a.scratch.work.vec(kFinalPosition, c) + out);
    }
  }
}

Vec3 moved_to(const Island& a, const ContactRow& t) {
  PANTIN_ASSERT(t.column < a.scratch.translation.size() && t.column < a.scratch.rotation.size());
  return t.predicted + t.nonlinearity + a.scratch.translation[t.column] +
         glm::cross(a.scratch.rotation[t.column], t.arm);
}

void update_nonlinearity(const Island& a, ContactRow& t, Vec3 anchor) {
  t.nonlinearity += final_point(a, t.column, anchor) - moved_to(a, t);
}

Real finish_contacts(World& world, Island& a, Real h) {
  const Real to_force = 1 / (a.force_share * h * h);
  Real work = 0, lift = 0, given = 0, most_given = 0;
  for (ContactRow& t : a.scratch.contact_rows) {
    Contact& c = contacts_of(world)[t.contact];
    // Energy gained from another island is bounded by what that island had.
    if (is_own(world, c.slot_b)) {
      const Island& other =
          islands_of(world)[owner_of(partition_of(world), t.side > 0 ? c.slot_b : c.slot_a).island];
      const Vec3 arm = world.bodies.values()[a.slots[t.column]].pose.rotation *
                       (t.side > 0 ? c.point_a : c.point_b);
      const Vec3 way = a.memory.vec(kLastTranslation, t.column) +
                       glm::cross(a.memory.vec(kLastRotation, t.column), arm);
      if (&other != &a)
        given +=
            std::clamp(t.side * to_force * glm::dot(c.lambda, way), Real(0), other.kinetic_before);
      most_given = std::max(most_given, &other != &a ? other.kinetic_before : 0);
    }
    if (t.side < 0) {
      if (c.active) lift = std::max(lift, -c.gap);
      continue;
    }
    const Body &body = world.bodies.values()[c.slot_a], &other = world.bodies.values()[c.slot_b];
    const Vec3 on_b = to_world(other.pose, c.point_b);
    const Real apart = glm::dot(c.normal, to_world(body.pose, c.point_a) - on_b);
    c.depth = std::max(Real(0), -apart);
    c.force = c.active ? to_force * c.force : Vec3(0);
    // Energy may grow by restitution and by removal of penetration, but no more.
    if (c.impact > 0) {
      work += 0.5 * a.mass * c.impact * c.impact;
      c.impact = 0;
    } else if (c.impact < 0) {
      c.impact = c.active ? -c.restitution * c.impact : 0;
    }
    if (c.active && !is_own(world, c.slot_b))
      work += std::max(Real(0), glm::dot(c.force, way_of(other, on_b, h)));
    if (c.active) lift = std::max(lift, -c.gap);
  }
  return work + std::min(given, most_given) + lift * a.mass * glm::length(world.gravity);
}

}  // namespace pantin::detail::articulated
