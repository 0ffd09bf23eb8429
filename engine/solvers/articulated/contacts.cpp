// Contacts as rows of the bodies they touch: stiff springs with multipliers, so that any number of
// them, dependent or not, is answered by one way up and one way down the tree.
//
// A row draws the point of contact p to its goal with the load
//   f = l + w n n.(goal - p) + g (1 - n n^T)(goal - p)
// and learns the multiplier l from what it bore: along the normal only pushes count; across it
// friction bears at most mu times that, and where the point slides the grip g is cut down so that
// it brakes by just as much (lagged, isotropic). [Alart & Curnier 1991, augmented Lagrangian]
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/push_out.hpp"
#include "engine/contact/detect.hpp"

namespace pantin::articulated {
namespace {

/// Rows outweigh the articulation by this much; what is left is met by their loads, which a larger
/// weight would make learn from rounding where contacts could bear instead of each other.
constexpr Real kRowWeight = 30;
/// A contact that misses its place by less is at rest, part of the size.
constexpr Real kStill = 1e-5;
/// One that slips by less does not have to know yet how much its friction can bear.
constexpr Real kNoSlip = 1e-6;
/// Overlaps up to this part of the size are taken out by moving a free tree whole.
constexpr Real kSlight = 5e-3;
/// A load beyond this (its square, kg^2 m^2) is none.
constexpr Real kTooLarge = 1e36;
/// Approaches slower than this are not given back, m/s.
constexpr Real kQuiet = 0.2;

/// How far a body's surface may come in this step: the way predicted, and what joints may add.
Real reach_of(const World& world, const Island& a, std::size_t c, Real drawn, Real h) {
  const Body& b = world.bodies.values()[a.slots[c]];
  const Shapes* shapes = world.shapes.find(a.bodies[c]);
  if (!shapes) return 0;
  const Real extent = contact::extent_of(*shapes);
  const Real slide = glm::length(a.room.work.vec(kPosition, c) - b.pose.position);
  const Quat turn = a.room.work.quat(kRotation, c) * glm::conjugate(b.pose.rotation);
  return 1.25 * (slide + extent * glm::length(rotation_vector(turn))) + drawn + 0.02 * extent +
         glm::length(world.gravity) * h * h;
}

/// How far a hand draws an articulation in this step.
Real drawn_by_hands(const Island& a) {
  Real most = 0;
  for (const Tree& t : a.trees)
    if (a.parents[t.first] == kHeld)
      most = std::max(most, glm::length(t.target - t.target_before));
  for (const Hold& hold : a.holds)
    most = std::max(most, glm::length(hold.target - hold.target_before));
  return most;
}

bool is_dynamic(const World& world, std::uint32_t slot) {
  return contact::feels_contacts(partition_of(world), slot);
}

/// Displacement of a point of a fixed or driven body over the step.
Vec3 way_of(const Body& b, Vec3 at, Real h) {
  return contact::moves(b) ? h * (b.velocity + glm::cross(b.spin, at - b.pose.position)) : Vec3(0);
}

Vec3 final_point(const Island& a, std::size_t column, Vec3 anchor) {
  return point_at(a, column, anchor, kFinalPosition, kFinalRotation);
}

/// Parts of a vector across a unit normal.
Vec3 across(Vec3 v, Vec3 n) { return v - glm::dot(v, n) * n; }

/// The speed at which two bodies come together at a contact, m/s; what was there before the step.
Real approach(const World& world, const Contact& c) {
  const auto speed = [&](std::uint32_t slot, Vec3 point) {
    const Body& b = world.bodies.values()[slot];
    return b.velocity + glm::cross(b.spin, b.pose.rotation * point);
  };
  return -glm::dot(c.normal, speed(c.slot_a, c.point_a) - speed(c.slot_b, c.point_b));
}

/// Goal of a's point against a body that joints do not move.
Vec3 goal_of(const World& world, const Contact& c, Vec3 start, Real h, int parts_left) {
  const Body& b = world.bodies.values()[c.slot_b];
  Vec3 end = to_world(b.pose, c.point_b);
  const Vec3 way = way_of(b, end, h);
  end -= Real(parts_left) * way;
  const Vec3 wanted = start + way;
  return wanted + (glm::dot(c.normal, end - wanted) + h * c.impact) * c.normal;
}

/// What a contact learns from a pass. `miss` leads from where its row took the point to its goal,
/// `depth` is the overlap that is left. /// True if it bears as it was thought to.
bool learn(Contact& c, Vec3 miss, Real depth, Real weight, Real size) {
  const Real lack = glm::dot(miss, c.normal);
  if (!c.active) {
    if (!(depth > 1e-9 * size)) return true;
    c.active = true, c.load = Vec3(0), c.sliding = 1;
    return false;
  }
  const Real normal = glm::dot(c.load, c.normal) + weight * lack;
  const bool still = glm::dot(miss, miss) < kStill * kStill * size * size;
  if (normal <= 0 && still) return true;  // as good as at rest: no reason to let go
  if (normal <= 0) {
    c.active = false, c.load = Vec3(0), c.sliding = 1;
    return false;
  }
  const Vec3 grip = across(c.load, c.normal) + weight * across(miss, c.normal);
  const Real most = c.friction * normal, held = glm::length(grip), before = c.sliding;
  const bool sticks = held <= most;
  c.sliding = sticks ? 1 : most / held;
  c.force = normal * c.normal + c.sliding * grip;
  c.load = normal * c.normal + (sticks ? grip : Vec3(0));
  const Real slip = glm::length(across(miss, c.normal));
  const bool rubs = (c.sliding < 1 || before < 1) && slip > kNoSlip * size;
  return depth < kStill * size && (!rubs || std::abs(c.sliding - before) <= 0.05 * before);
}

}  // namespace

void keep_touches(World& world, Island& a, Real h) {
  const Real to_force = 1 / (a.force_share * h * h);
  for (const Touch& t : a.room.touches) {
    if (t.side < 0) continue;
    Contact& c = contacts_of(world)[t.contact];
    c.force = to_force * c.load, c.depth = std::max(Real(0), -c.gap);
  }
  a.passes_used = a.rounds_used = 0, a.limited = false;
}

void find_reaches(const World& world, Real h, std::span<Real> reach) {
  for (const Island& a : islands_of(world)) {
    const Real drawn = drawn_by_hands(a);
    for (std::size_t c = 0; c < a.count(); ++c)
      if (world.collisions.find(a.bodies[c])) reach[a.slots[c]] = reach_of(world, a, c, drawn, h);
  }
}

bool all_asleep(const World& world) {
  const auto& islands = islands_of(world);
  return std::all_of(islands.begin(), islands.end(), [](const Island& a) { return a.resting; });
}

namespace {

/// Gives a contact to the island of one of its bodies, which wakes where something comes.
void take_contact(World& world, std::uint32_t contact, bool is_a, Real h) {
  const Contact& c = contacts_of(world)[contact];
  const Partition& partition = partition_of(world);
  const bool mutual = contact::feels_contacts(partition, c.slot_b);
  const Owner at = owner_of(partition, is_a ? c.slot_a : c.slot_b);
  Island& a = islands_of(world)[at.island];
  const Body& b = world.bodies.values()[c.slot_b];
  const bool comes = contact::moves(b) || b.restart || b.teleport;
  if (a.resting && (mutual || comes)) stir(world, a, h);
  Touch t;
  t.contact = contact, t.column = at.column, t.side = is_a ? 1 : -1;
  a.mutual = a.mutual || mutual;
  a.room.touches.push_back(t);
}

}  // namespace

void take_contacts(World& world, Real h) {
  for (Island& a : islands_of(world)) a.room.touches.clear(), a.mutual = false;
  std::vector<Contact>& contacts = contacts_of(world);
  for (std::uint32_t i = 0; i < contacts.size(); ++i) {
    Contact& c = contacts[i];
    const Body& b = world.bodies.values()[c.slot_b];
    const bool mutual = is_dynamic(world, c.slot_b);
    if (!mutual && contact::moves(b)) c.normal = glm::normalize(turn_by(h * b.spin) * c.normal);
    c.active = glm::dot(c.load, c.normal) > 0 || c.impact > 0;
    // Below zero: an approach, to be given back in the step after it was stopped.
    if (c.impact <= 0)
      c.impact = c.restitution > 0 && approach(world, c) > kQuiet ? -approach(world, c) : 0;
    take_contact(world, i, true, h);
    if (mutual) take_contact(world, i, false, h);
  }
}

void aim_touches(World& world, Island& a, Real h) {
  const Real ratio = a.last_step > 0 && !a.fresh ? h / a.last_step : 1;
  for (Touch& t : a.room.touches) {
    Contact& c = contacts_of(world)[t.contact];
    const bool mutual = is_dynamic(world, c.slot_b);
    if (t.side > 0 && ratio != 1) c.load *= ratio * ratio;
    if (t.side > 0 && !(glm::dot(c.load, c.load) < kTooLarge)) c.load = Vec3(0), c.active = false;
    if (t.side > 0) c.before = c.load;
    const Vec3 point = t.side > 0 ? c.point_a : c.point_b;
    const Vec3 arm = a.room.work.quat(kRotation, t.column) * point;
    t.predicted = a.room.work.vec(kPosition, t.column) + arm;
    t.arm = arm - a.room.work.vec(kArm, t.column);
    t.weight = kRowWeight * a.mass;
    t.bend = Vec3(0);
    if (mutual) continue;
    Contact given = c;
    given.impact = std::max(Real(0), c.impact);
    t.goal = goal_of(world, given, to_world(world.bodies.values()[c.slot_a].pose, point), h,
                     a.parts_left);
  }
}

void add_touches(const World& world, Island& a, std::vector<JointBlock>& blocks) {
  for (Touch& t : a.room.touches) {
    const Contact& c = contacts_of(world)[t.contact];
    if (!c.active) continue;
    t.grip = t.weight * c.sliding;
    const Vec3 n = c.normal;
    const Vec3 bearing = glm::dot(c.load, n) * n;
    const Vec3 held = bearing + c.sliding * (c.load - bearing);
    const Mat3 w = t.grip * Mat3(1) + (t.weight - t.grip) * glm::outerProduct(n, n);
    const Vec3 f = held + w * (t.goal - t.bend - t.predicted);
    const Mat3 k(0, t.arm.z, -t.arm.y, -t.arm.z, 0, t.arm.x, t.arm.y, -t.arm.x, 0);
    JointBlock& b = blocks[t.column];
    const Mat3 kw = k * w;
    b.yy += w, b.ty += kw, b.tt -= kw * k;
    b.gy += f, b.gt += glm::cross(t.arm, f);
  }
}

bool settle_iterated(World& world, Island& a) {
  bool settled = true;
  for (Touch& t : a.room.touches) {
    Contact& c = contacts_of(world)[t.contact];
    const Vec3 before = t.bend;
    if (t.side > 0) {
      const Vec3 slip = across(t.goal - moved_to(a, t), c.normal);
      const Real normal = glm::dot(c.load, c.normal);
      c.active = normal > 0, c.force = c.load;
      // As a row of the solve the contact would brake like this; a sliding one keeps no grip.
      if (c.sliding < 1 && !is_dynamic(world, c.slot_b)) {
        const Real whole = t.weight * glm::length(slip), most = c.friction * normal;
        c.sliding = whole > most ? most / whole : 1;
        c.load = normal * c.normal;
      }
    }
    learn_bend(a, t, t.side > 0 ? c.point_a : c.point_b);
    if (is_dynamic(world, c.slot_b))
      settled = settled && std::abs(glm::dot(c.normal, t.bend - before)) < 1e-5 * a.size;
    else
      settled = settled && glm::dot(c.normal, t.goal - moved_to(a, t)) < 1e-5 * a.size;
  }
  return settled;
}

bool settle_touches(World& world, Island& a) {
  bool settled = true;
  for (Touch& t : a.room.touches) {
    Contact& c = contacts_of(world)[t.contact];
    const Vec3 miss = t.goal - moved_to(a, t);
    learn_bend(a, t, c.point_a);
    const Real depth = glm::dot(c.normal, t.goal - moved_to(a, t));
    settled = learn(c, miss, depth, t.weight, a.size) && settled;
  }
  return settled;
}

void push_out_trees(World& world, Island& a) {
  for (const Tree& tree : a.trees) {
    if (a.parents[tree.first] != kFree) continue;
    for (int round = 0; round < 4; ++round) {
      HalfSpaces planes;
      for (const Touch& t : a.room.touches) {
        const Contact& c = contacts_of(world)[t.contact];
        if (is_dynamic(world, c.slot_b) || t.column < tree.first ||
            t.column >= tree.first + tree.count)
          continue;
        const Vec3 on_b = to_world(world.bodies.values()[c.slot_b].pose, c.point_b);
        const Real depth = glm::dot(c.normal, on_b - final_point(a, t.column, c.point_a));
        // A deep overlap is left to the next step: to lift all for one body would throw it.
        if (depth > 0 && depth < kSlight * a.size) planes.add(c.normal, depth);
      }
      if (planes.count == 0) break;
      const Vec3 out = push_out(planes);
      for (std::size_t c = tree.first; c < tree.first + tree.count; ++c)
        a.room.work.set(kFinalPosition, c, a.room.work.vec(kFinalPosition, c) + out);
    }
  }
}

Vec3 moved_to(const Island& a, const Touch& t) {
  return t.predicted + t.bend + a.room.slide[t.column] + glm::cross(a.room.turn[t.column], t.arm);
}

void learn_bend(const Island& a, Touch& t, Vec3 anchor) {
  t.bend += final_point(a, t.column, anchor) - moved_to(a, t);
}

Real finish_touches(World& world, Island& a, Real h) {
  const Real to_force = 1 / (a.force_share * h * h);
  Real work = 0, lift = 0, given = 0, most_given = 0;
  for (Touch& t : a.room.touches) {
    Contact& c = contacts_of(world)[t.contact];
    // What another articulation does to this one it may gain, as far as the other had it.
    if (is_dynamic(world, c.slot_b)) {
      const Island& other =
          islands_of(
              world)[owner_of(partition_of(world), t.side > 0 ? c.slot_b : c.slot_a).island];
      const Vec3 arm = world.bodies.values()[a.slots[t.column]].pose.rotation *
                       (t.side > 0 ? c.point_a : c.point_b);
      const Vec3 way = a.memory.vec(kLastSlide, t.column) +
                       glm::cross(a.memory.vec(kLastTurn, t.column), arm);
      if (&other != &a)
        given += std::clamp(t.side * to_force * glm::dot(c.load, way), Real(0), other.kinetic_before);
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
    // What is given back, or lifted out of an overlap, may be gained; no more than that.
    if (c.impact > 0) {
      work += 0.5 * a.mass * c.impact * c.impact;
      c.impact = 0;
    } else if (c.impact < 0) {
      c.impact = c.active ? -c.restitution * c.impact : 0;
    }
    if (c.active && !is_dynamic(world, c.slot_b))
      work += std::max(Real(0), glm::dot(c.force, way_of(other, on_b, h)));
    if (c.active) lift = std::max(lift, -c.gap);
  }
  return work + std::min(given, most_given) + lift * a.mass * glm::length(world.gravity);
}

}  // namespace pantin::articulated
