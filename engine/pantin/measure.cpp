#include <limits>
#include <pantin/measure.hpp>

#include "engine/joints/kinds.hpp"
#include "engine/joints/rows.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/solvers/planar/island.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/world/cable_route.hpp"
#include "engine/world/joint_coordinate.hpp"

namespace pantin {

using namespace detail;

namespace {

constexpr Real kNoNumber = std::numeric_limits<Real>::quiet_NaN();

/// Index of a block of an island.
struct BlockAt {
  const lagrangian::Island* mechanism = nullptr;
  std::size_t block = 0;
};

/// The island that moves one of two bodies.
const lagrangian::Island* mechanism_of(const World& world, Entity a, Entity b) {
  for (const Entity e : {a, b}) {
    const std::uint32_t slot = e ? world.bodies.slot(e) : kNoSlot;
    const Owner owner = owner_of(partition_of(world), world.bodies.slot_then(slot));
    if (owner && owner.solver == kLagrangian) return &lagrangian::islands_of(world)[owner.island];
  }
  return nullptr;
}

std::optional<BlockAt> find_block(const lagrangian::Island* m, lagrangian::BlockKind kind,
                                  std::uint32_t source) {
  if (!m) return std::nullopt;
  for (std::size_t i = 0; i < m->blocks.size(); ++i)
    if (m->blocks[i].kind == kind && m->blocks[i].source == source) return BlockAt{m, i};
  return std::nullopt;
}

/// The angle from which the solver counts whole turns; 0 if it counts none.
Real counted_angle(const World& world, std::uint32_t link) {
  const Link& l = world.links.values()[link];
  const lagrangian::Island* m = mechanism_of(world, l.a, l.b);
  if (!m) return 0;
  for (const lagrangian::JointForce& e : m->joint_forces)
    if (e.link == link && e.coordinate == Coordinate::angle) return e.before;
  for (std::size_t i = 0; i < m->blocks.size(); ++i) {
    const lagrangian::Block& b = m->blocks[i];
    const bool screw = b.kind == lagrangian::BlockKind::joint && info_of(l.joint.kind).counts_turns;
    const bool counts = b.kind == lagrangian::BlockKind::limit ||
                        b.kind == lagrangian::BlockKind::drive ||
                        b.kind == lagrangian::BlockKind::spring;
    if (b.source == link && (screw || (counts && b.coordinate == Coordinate::angle)))
      return m->memory[i].before[0];
  }
  return 0;
}

bool has(JointKind kind, Coordinate which) { return info_of(kind).find(which) != nullptr; }

CoordinateAt coordinate(const World& world, Entity joint, Coordinate which) {
  const std::uint32_t slot = world.links.slot(joint);
  const Link* link = slot == kNoSlot ? nullptr : &world.links.values()[slot];
  if (!link || !world.bodies.find(link->a) || !world.bodies.find(link->b) ||
      !has(link->joint.kind, which))
    return {kNoNumber, kNoNumber};
  const Real before = which == Coordinate::angle ? counted_angle(world, slot) : 0;
  return coordinate_at(world, *link, which, before);
}

/// Looked up by the slot that the joint had when its island was built.
std::optional<JointReaction> articulated_reaction(const World& world, const Link& link,
                                                  std::uint32_t slot) {
  for (const articulated::Island& a : articulated::islands_of(world)) {
    const Real scale = articulated::force_per_lambda(a);
    if (scale == 0) continue;
    for (std::size_t c = 0; c < a.count(); ++c) {
      if (a.links[c] != slot) continue;
      const articulated::JointLoad load = articulated::joint_load(a, c);
      const Real sign = a.bodies[c] == link.b ? 1 : -1;
      return JointReaction{sign * load.force, sign * load.torque};
    }
    // A joint that closes a loop, or anchors a tree again, constrains its point only.
    for (const articulated::PackedPin& h : a.pins) {
      if (h.held_link != slot) continue;
      return JointReaction{(a.bodies[h.column] == link.b ? scale : -scale) * h.lambda, Vec3(0)};
    }
  }
  return std::nullopt;
}

std::optional<JointReaction> planar_reaction(const World& world, std::uint32_t slot) {
  const planar::Planar& all = planar::plane_of(world);
  for (std::size_t i = 0; i < all.links.size() && i < all.reactions.size(); ++i)
    if (all.links[i].link == slot)
      return JointReaction{all.reactions[i].force, {0, 0, all.reactions[i].torque}};
  return std::nullopt;
}

std::optional<Vec3> articulated_pin_force(const World& world, std::uint32_t pin) {
  for (const articulated::Island& a : articulated::islands_of(world)) {
    const Real scale = articulated::force_per_lambda(a);
    if (scale == 0) continue;
    for (const articulated::Tree& t : a.trees)
      if (t.held_pin == pin) return scale * a.memory.vec(articulated::kLambda, t.first);
    for (const articulated::PackedPin& h : a.pins)
      if (h.held_pin == pin) return scale * h.lambda;
  }
  return std::nullopt;
}

/// The force of a spring pin on an island.
Vec3 spring_force(const World& world, const Pin& pin) {
  const Body& body = world.bodies[pin.body];
  const Vec3 at = to_world(body.pose, pin.anchor);
  const Body* holder = pin.to ? &world.bodies[pin.to] : nullptr;
  const Vec3 to = holder ? to_world(holder->pose, pin.target) : pin.target;
  const Vec3 rate = (holder ? velocity_at(*holder, to) : Vec3(0)) - velocity_at(body, at);
  return pin.stiffness * (to - at) + pin.damping * rate;
}

}  // namespace

std::optional<LocalFrames> joint_frames(const World& world, Entity joint) {
  const Link* link = world.links.find(joint);
  if (!link || !world.bodies.find(link->a) || !world.bodies.find(link->b)) return std::nullopt;
  const Joint& j = link->joint;
  if (j.kind == JointKind::distance || j.kind == JointKind::spring || j.kind == JointKind::custom)
    return std::nullopt;
  const auto side = [&](Entity body, Vec3 anchor, Quat axes) {
    return compose(inverse(world.origin_pose(body)),
                   compose(world.bodies[body].pose, {anchor, axes}));
  };
  return LocalFrames{side(link->a, j.anchor_a, j.frames.a()),
                     side(link->b, j.anchor_b, j.frames.b())};
}

Real joint_angle(const World& world, Entity joint) {
  return coordinate(world, joint, Coordinate::angle).value;
}
Real joint_second_angle(const World& world, Entity joint) {
  return coordinate(world, joint, Coordinate::second).value;
}
Vec3 joint_swing(const World& world, Entity joint) {
  const Link* link = world.links.find(joint);
  const Body *a = link ? world.bodies.find(link->a) : nullptr,
             *b = link ? world.bodies.find(link->b) : nullptr;
  if (!a || !b || !has(link->joint.kind, Coordinate::swing)) return Vec3(kNoNumber);
  return swing_twist(relative_rotation(link->joint, a->pose.rotation, b->pose.rotation)).swing;
}
Real joint_angular_speed(const World& world, Entity joint) {
  return coordinate(world, joint, Coordinate::angle).rate;
}
Real joint_travel(const World& world, Entity joint) {
  return coordinate(world, joint, Coordinate::travel).value;
}
Real joint_speed(const World& world, Entity joint) {
  return coordinate(world, joint, Coordinate::travel).rate;
}

std::optional<JointReaction> joint_reaction(const World& world, Entity joint) {
  const std::uint32_t now = world.links.slot(joint);
  if (now == kNoSlot) return std::nullopt;
  const Link& link = world.links.values()[now];
  const std::uint32_t slot = world.links.slot_then(now);
  if (slot == kNoSlot) return std::nullopt;
  if (const auto at =
          find_block(mechanism_of(world, link.a, link.b), lagrangian::BlockKind::joint, slot)) {
    if (at->mechanism->fresh || !at->mechanism->scratch.ready) return std::nullopt;
    const lagrangian::ConstraintWrench f = lagrangian::joint_wrench(*at->mechanism, at->block);
    const Vec3 arm = world.bodies[link.b].pose.rotation * link.joint.anchor_b;
    return JointReaction{f.force, f.torque - glm::cross(arm, f.force)};
  }
  if (const auto planar = planar_reaction(world, slot)) return planar;
  return articulated_reaction(world, link, slot);
}

Real cable_tension(const World& world, Entity cable) {
  const std::uint32_t now = world.cables.slot(cable);
  if (now == kNoSlot) return kNoNumber;
  const Cable& s = world.cables.values()[now];
  const std::uint32_t slot = world.cables.slot_then(now);
  const lagrangian::Island* m = mechanism_of(world, s.a, s.b);
  for (const CableGuide& g : s.guides)
    if (!m) m = mechanism_of(world, g.body, {});
  if (const auto at = find_block(m, lagrangian::BlockKind::cable, slot)) {
    if (s.guides.empty())
      return glm::length(lagrangian::joint_wrench(*at->mechanism, at->block).force);
    return m->scratch.ready ? m->forces[m->blocks[at->block].first_row] : 0;
  }
  const auto pose_of = [&](Entity e) {
    const Body* b = world.bodies.find(e);
    return b ? &b->pose : nullptr;
  };
  if (m && s.joint.compliance > 0) return stretch_of(s, pose_of) / s.joint.compliance;
  return s.tension;
}

std::optional<Vec3> pin_force(const World& world, Entity pin) {
  const std::uint32_t now = world.pins.slot(pin);
  if (now == kNoSlot) return std::nullopt;
  const Pin& p = world.pins.values()[now];
  const std::uint32_t slot = world.pins.slot_then(now);
  if (slot == kNoSlot) return std::nullopt;
  const lagrangian::Island* m = mechanism_of(world, p.body, p.to);
  if (const auto at = find_block(m, lagrangian::BlockKind::pin, slot)) {
    if (m->fresh || !m->scratch.ready) return std::nullopt;
    return -lagrangian::joint_wrench(*m, at->block).force;
  }
  if (m && m->fresh) return std::nullopt;
  if (m && p.kind == PinKind::spring) return spring_force(world, p);
  return articulated_pin_force(world, slot);
}

}  // namespace pantin
