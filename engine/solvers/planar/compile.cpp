// Lists the bodies, joints and gears of the plane.
#include <algorithm>
#include <cmath>

#include "engine/joints/kinds.hpp"
#include "engine/solvers/planar/island.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/world/flat.hpp"

namespace pantin::detail::planar {
namespace {

constexpr Real kSameTurn = 1e-9;  // rad: the caller did not rotate the body

struct Turned {
  Real angle = 0;
  Quat tilt{1, 0, 0, 0};
};

/// Splits a rotation into one about z after a tilt. A rotation about z moves (w, z) and (x, y) each
/// on a circle; the larger one determines the angle.
Turned split(Quat q) {
  const bool upright = q.w * q.w + q.z * q.z >= q.x * q.x + q.y * q.y;
  const Real half = upright ? std::atan2(q.z, q.w) : std::atan2(q.y, q.x);
  // The tilt is exactly the identity, at any angle: a loaded World splits at another angle.
  if (q.x == 0 && q.y == 0) return {2 * half};
  const Quat back(std::cos(half), 0, 0, -std::sin(half));
  return {2 * half, glm::normalize(back * q)};
}

bool is_solid(const World& world, Entity e) {
  const Collision* collision = world.collisions.find(e);
  return collision && !collision->sensor;
}

/// Numbers of the plane's bodies by slot.
struct Builder {
  World& world;
  Planar& all;
  Partition& partition;
  std::vector<std::uint32_t> island;  // by slot
  std::vector<bool> wanted;
  std::vector<std::uint32_t> number;

  bool is_own(std::uint32_t slot) const { return slot != kNoSlot && island[slot] != kNobody; }
  bool is_foreign(std::uint32_t slot) const {
    return !is_own(slot) && world.bodies.values()[slot].motion == Motion::dynamic;
  }
  void leave_out(Entity who, std::string why) {
    partition.faults.push_back({who, std::move(why), StructureFault::left_out, false});
  }
};

void pick_links(Builder& b) {
  for (std::uint32_t i = 0; i < b.world.links.size(); ++i) {
    const Link& link = b.world.links.values()[i];
    const std::uint32_t slot_a = b.world.bodies.slot(link.a), slot_b = b.world.bodies.slot(link.b);
    if (slot_a == kNoSlot || slot_b == kNoSlot || slot_a == slot_b) continue;  // reported elsewhere
    if (!b.is_own(slot_a) && !b.is_own(slot_b)) continue;
    const auto pose = [&](std::uint32_t slot) { return b.world.bodies.values()[slot].pose; };
    std::string why = flat_fault(link.joint, pose(slot_a), pose(slot_b));
    for (const auto& [body, anchor] :
         {std::pair{link.a, link.joint.anchor_a}, {link.b, link.joint.anchor_b}})
      if (const KinematicPath* path = b.world.paths.find(body); path && why.empty())
        why = flat_fault(link.joint, *path, anchor);
    if (!why.empty()) {
      b.leave_out(b.world.links.owners()[i], std::move(why));
      continue;
    }
    b.wanted[slot_a] = b.wanted[slot_b] = true;
    b.all.links.push_back({b.world.links.owners()[i], i, slot_a, slot_b});
  }
}

void pick_pins(Builder& b) {
  for (std::uint32_t i = 0; i < b.world.pins.size(); ++i) {
    const Pin& pin = b.world.pins.values()[i];
    const std::uint32_t slot = b.world.bodies.slot(pin.body);
    const std::uint32_t to = pin.to ? b.world.bodies.slot(pin.to) : kNoSlot;
    if (slot == kNoSlot || slot == to || (pin.to && to == kNoSlot)) continue;
    if ((!b.is_own(slot) && !b.is_own(to)) || pin.kind != PinKind::exact) continue;
    if (b.is_foreign(slot) || (pin.to && b.is_foreign(to))) {
      b.leave_out(b.world.pins.owners()[i], "ties a planar body to a body of another solver");
      continue;
    }
    b.wanted[slot] = true;
    if (pin.to) b.wanted[to] = true;
    b.all.pins.push_back({b.world.pins.owners()[i], i, slot, pin.to ? to : kNobody});
  }
}

void pick_gears(Builder& b) {
  const auto find = [&](Entity link) {
    const std::uint32_t slot = b.world.links.slot(link);
    const auto at = std::find_if(b.all.links.begin(), b.all.links.end(),
                                 [&](const FlatLink& l) { return l.link == slot; });
    return static_cast<std::uint32_t>(at - b.all.links.begin());
  };
  for (std::uint32_t i = 0; i < b.world.gears.size(); ++i) {
    const Gear& gear = b.world.gears.values()[i];
    const std::uint32_t first = find(gear.first), second = find(gear.second);
    if (first == second || std::max(first, second) >= b.all.links.size()) continue;
    const auto fits = [&](std::uint32_t at, FlatJoint needed) {
      const Link& link = b.world.links.values()[b.all.links[at].link];
      const FlatJoint kind = flat_kind(link.joint, b.world.bodies[link.a].pose);
      return kind == needed && link.joint.kind != JointKind::ball;
    };
    const FlatJoint one = gear.first_travels ? FlatJoint::slider : FlatJoint::hinge;
    const FlatJoint two = gear.second_travels ? FlatJoint::slider : FlatJoint::hinge;
    if (fits(first, one) && fits(second, two))
      b.all.gears.push_back({b.world.gears.owners()[i], i, {first, second}});
    else
      b.leave_out(b.world.gears.owners()[i],
                  "couples a degree of freedom that the joint does not have");
  }
}

void pick_drives(Builder& b) {
  for (std::uint32_t at = 0; at < b.all.links.size(); ++at) {
    const Entity owner = b.all.links[at].owner;
    const std::uint32_t slot = b.world.joint_drives.slot(owner);
    if (slot == kNoSlot || !b.world.joint_drives.values()[slot].exact) continue;
    const DriveMotion& motion = b.world.joint_drives.values()[slot].motion;
    const Link& link = b.world.links.values()[b.all.links[at].link];
    std::string why = flat_drive_fault(link.joint, motion, b.world.bodies[link.a].pose);
    if (!why.empty()) {
      b.leave_out(owner, std::move(why));
      continue;
    }
    FlatDrive& made = b.all.drives.emplace_back();
    made.owner = owner, made.drive = slot, made.link = at, made.travels = motion.travels;
  }
}

void pick_belts(Builder& b) {
  for (std::uint32_t i = 0; i < b.world.belts.size(); ++i) {
    const Belt& belt = b.world.belts.values()[i];
    const std::size_t count = belt.pulleys.size();
    std::vector<std::uint32_t> slots;
    for (const BeltPulley& p : belt.pulleys) slots.push_back(b.world.bodies.slot(p.body));
    if (count < 2 || std::find(slots.begin(), slots.end(), kNoSlot) != slots.end()) continue;
    if (std::none_of(slots.begin(), slots.end(), [&](std::uint32_t s) { return b.is_own(s); }))
      continue;
    for (const std::uint32_t slot : slots) b.wanted[slot] = true;
    const auto held = static_cast<std::uint32_t>(held_spans(b.world, belt));
    for (std::uint32_t k = 0; k < held; ++k)
      b.all.spans.push_back({i, k, held, slots[k], slots[(k + 1) % count]});
  }
}

FlatCurve::Side side_of(const Body& body, const ContactSurface& surface) {
  const Quat tilt = split(body.pose.rotation).tilt;
  const Quat axes = tilt * surface.pose.rotation;
  const Vec3 arm = tilt * surface.pose.position;
  return {surface.curve, nullptr, {arm.x, arm.y, 0}, 2 * std::atan2(axes.z, axes.w)};
}

void pick_curves(Builder& b) {
  for (std::uint32_t i = 0; i < b.world.surface_contacts.size(); ++i) {
    const SurfaceContact& c = b.world.surface_contacts.values()[i];
    const std::uint32_t slot_a = b.world.bodies.slot(c.a), slot_b = b.world.bodies.slot(c.b);
    if (slot_a == kNoSlot || slot_b == kNoSlot || slot_a == slot_b) continue;
    if (!c.on_b.curve || (!b.is_own(slot_a) && !b.is_own(slot_b))) continue;  // reported elsewhere
    const Entity owner = b.world.surface_contacts.owners()[i];
    if (const char* why = c.restored()) {
      b.leave_out(owner, why);
      continue;
    }
    if (b.is_foreign(slot_a) || b.is_foreign(slot_b)) {
      b.leave_out(owner, "ties a planar body to a body of another solver");
      continue;
    }
    const Body &on_a = b.world.bodies.values()[slot_a], &on_b = b.world.bodies.values()[slot_b];
    if (std::string why = flat_fault(c, on_a.pose, on_b.pose); !why.empty()) {
      b.leave_out(owner, std::move(why));
      continue;
    }
    b.wanted[slot_a] = b.wanted[slot_b] = true;
    FlatCurve& made = b.all.curves.emplace_back();
    made.owner = owner, made.contact = i, made.a = slot_a, made.b = slot_b;
    made.island = b.is_own(slot_a) ? b.island[slot_a] : b.island[slot_b];
    made.rolls = c.motion != SurfaceMotion::sliding, made.lifts = c.lifts, made.over = c.over;
    made.sides = {side_of(on_a, c.on_a), side_of(on_b, c.on_b)};
    if (c.known) made.places[0] = {.used = true, .t_a = c.at.a.u, .t_b = c.at.b.u};
    made.known = c.known && !c.lifts;
  }
}

void number_bodies(Builder& b) {
  b.number.assign(b.world.bodies.size(), kNobody);
  for (std::uint32_t slot = 0; slot < b.world.bodies.size(); ++slot) {
    const Entity e = b.world.bodies.owners()[slot];
    const bool solid = is_solid(b.world, e);
    if (!b.is_own(slot) && !b.wanted[slot] && (!solid || b.is_foreign(slot))) continue;
    b.number[slot] = static_cast<std::uint32_t>(b.all.bodies.size());
    const Turned turned = split(b.world.bodies.values()[slot].pose.rotation);
    b.all.bodies.push_back({e, slot, b.island[slot], solid, turned.angle, turned.tilt});
  }
  for (FlatLink& l : b.all.links) l.a = b.number[l.a], l.b = b.number[l.b];
  for ([[maybe_unused]] const FlatLink& l : b.all.links)
    PANTIN_ASSERT(l.a != kNobody && l.b != kNobody);
  for (FlatSpan& s : b.all.spans) s.a = b.number[s.a], s.b = b.number[s.b];
  for (FlatCurve& c : b.all.curves) c.a = b.number[c.a], c.b = b.number[c.b];
  for ([[maybe_unused]] const FlatCurve& c : b.all.curves)
    PANTIN_ASSERT(c.a != kNobody && c.b != kNobody && c.a != c.b);
  for (FlatPin& p : b.all.pins) {
    p.body = b.number[p.body];
    if (p.to != kNobody) p.to = b.number[p.to];
  }
}

/// Carries over the rotation of bodies, the state of gears and drives, and the contacts between
/// them.
void carry_over(const Planar& was, Planar& all) {
  std::vector<std::uint32_t> now(was.bodies.size(), kNobody);
  std::uint32_t at = 0;
  for (std::uint32_t i = 0; i < was.bodies.size(); ++i) {
    // The order of slots may have changed, but rarely does.
    for (std::uint32_t tries = 0; tries < all.bodies.size(); ++tries, ++at) {
      if (at == all.bodies.size()) at = 0;
      if (all.bodies[at].body != was.bodies[i].body) continue;
      now[i] = at;
      all.bodies[at].turned = was.bodies[i].turned, all.bodies[at].tilt = was.bodies[i].tilt;
      break;
    }
  }
  const auto take_load = [&](std::size_t to, Entity owner, const auto& list, std::size_t from) {
    for (std::size_t i = 0; i < list.size(); ++i)
      if (list[i].owner == owner) all.loads[to] = was.loads[from + i];
  };
  for (std::size_t i = 0; i < all.links.size(); ++i) take_load(i, all.links[i].owner, was.links, 0);
  for (std::size_t i = 0; i < all.pins.size(); ++i)
    take_load(all.links.size() + i, all.pins[i].owner, was.pins, was.links.size());
  for (FlatGear& gear : all.gears)
    for (const FlatGear& old : was.gears)
      if (old.gear == gear.gear)
        gear.counted = old.counted, gear.first = old.first, gear.second = old.second,
        gear.offset = old.offset;
  for (FlatDrive& drive : all.drives)
    for (const FlatDrive& old : was.drives)
      if (old.owner == drive.owner && old.travels == drive.travels)
        drive.counted = old.counted, drive.first = old.first, drive.value = old.value;
  for (FlatCurve& c : all.curves) {
    for (const FlatCurve& old : was.curves) {
      if (old.owner != c.owner) continue;
      const bool same = old.sides[0].wire == c.sides[0].wire &&
                        old.sides[1].wire == c.sides[1].wire && old.rolls == c.rolls;
      if (!same) continue;
      for (std::size_t i = 0; i < 2; ++i) c.sides[i].pieces = old.sides[i].pieces;
      if (c.lifts == old.lifts)
        c.known = old.known, c.over = old.over, c.places = old.places, c.searched = old.searched,
        c.struck = old.struck, c.how = old.how;
    }
    for (FlatCurve::Side& side : c.sides)
      if (!side.pieces)
        side.pieces = std::make_shared<const nurbs::CurvePieces>(side.wire->curve());
    c.meets_once = meets_once(c);
  }
  PANTIN_ASSERT(all.loads.size() == all.links.size() + all.pins.size());
  all.near = was.near;
  for (PlaneContact t : was.touches) {
    t.a = now[t.a], t.b = now[t.b];
    if (t.a != kNobody && t.b != kNobody) all.touches.push_back(t);
  }
  std::sort(all.touches.begin(), all.touches.end(), comes_before);
}

}  // namespace

void compile(World& world, std::span<const IslandPlan> plans) {
  Planar& kept = plane_of(world);
  const Planar was = std::move(kept);
  kept = Planar();
  if (plans.empty()) return;
  Builder b{world, kept, world.memory.of<Partition>(), {}, {}, {}};
  b.island.assign(world.bodies.size(), kNobody), b.wanted.assign(world.bodies.size(), false);
  kept.islands = static_cast<std::uint32_t>(plans.size());
  kept.sleep_speed = plans.front().settings.sleep_speed;
  for (std::uint32_t i = 0; i < plans.size(); ++i) {
    kept.sleep_speed = std::min(kept.sleep_speed, plans[i].settings.sleep_speed);
    for (const std::uint32_t slot : plans[i].slots) {
      if (plans[i].unfit)
        b.wanted[slot] = true;
      else
        b.island[slot] = i;
    }
  }
  pick_links(b), pick_pins(b), pick_gears(b), pick_drives(b), pick_belts(b), pick_curves(b);
  number_bodies(b);
  for (std::uint32_t i = 0; i < kept.bodies.size(); ++i)
    if (kept.bodies[i].island != kNobody) b.partition.set_column(kept.bodies[i].slot, i);
  kept.loads.assign(kept.links.size() + kept.pins.size(), {});
  carry_over(was, kept);
  for (FlatLink& l : kept.links)
    if (const Real* angle = find_count(b.partition.turns, l.owner, Coordinate::angle))
      l.angle = *angle;
  PANTIN_ASSERT(std::is_sorted(kept.touches.begin(), kept.touches.end(), comes_before));
  list_mechanisms(world, kept);
}

void read_turns(const World& world, Planar& all) {
  for (FlatBody& f : all.bodies) {
    const Pose& at = world.bodies.values()[f.slot].pose;
    const Turned now = split(at.rotation);
    if (at.position.z != f.height) f.height = at.position.z, all.scratch.has_sections = false;
    const Real gained = std::remainder(now.angle - f.turned, 2 * kPi);
    // q and -q split at angles 2 pi apart: the remainder is the same.
    if (std::abs(gained) < kSameTurn) continue;
    f.turned += gained, f.tilt = now.tilt;
    all.scratch.has_sections = false;
  }
}

}  // namespace pantin::detail::planar
