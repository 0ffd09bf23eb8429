#include <pantin/measure.hpp>

#include <limits>

#include "engine/joints/rows.hpp"
#include "engine/solvers/articulated/island.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin {
namespace {

constexpr Real kNoNumber = std::numeric_limits<Real>::quiet_NaN();

/// Of a block of a mechanism.
struct BlockAt {
  const lagrangian::Island* mechanism = nullptr;
  std::size_t block = 0;
};

/// The mechanism that moves one of two bodies.
const lagrangian::Island* mechanism_of(const World& world, Entity a, Entity b) {
  for (const Entity e : {a, b}) {
    const std::uint32_t slot = e ? world.bodies.slot(e) : kNoSlot;
    const Owner owner = owner_of(partition_of(world), slot);
    if (owner && owner.solver == kLagrangian) return &lagrangian::islands_of(world)[owner.island];
  }
  return nullptr;
}

std::optional<BlockAt> find_block(const lagrangian::Island* m, lagrangian::BlockKind kind, std::uint32_t source) {
  if (!m) return std::nullopt;
  for (std::size_t i = 0; i < m->blocks.size(); ++i)
    if (m->blocks[i].kind == kind && m->blocks[i].source == source) return BlockAt{m, i};
  return std::nullopt;
}

/// The angle that the solver counts whole turns from; 0 where it counts none.
Real counted_angle(const World& world, std::uint32_t link) {
  const Link& l = world.links.values()[link];
  const lagrangian::Island* m = mechanism_of(world, l.a, l.b);
  if (!m) return 0;
  for (const lagrangian::Effort& e : m->efforts)
    if (e.link == link && e.coordinate == Coordinate::turn) return e.before;
  for (std::size_t i = 0; i < m->blocks.size(); ++i) {
    const lagrangian::Block& b = m->blocks[i];
    const bool screw =
        b.kind == lagrangian::BlockKind::joint && info_of(l.joint.kind).counts_turns;
    const bool counts = b.kind == lagrangian::BlockKind::limit || b.kind == lagrangian::BlockKind::spring;
    if (b.source == link && (screw || (counts && b.coordinate == Coordinate::turn)))
      return m->memory[i].before[0];
  }
  return 0;
}

Placed placed(const Body& b) {
  return {b.pose.position, b.pose.rotation, glm::mat3_cast(b.pose.rotation), b.velocity, b.spin};
}

bool has(JointKind kind, Coordinate which) { return info_of(kind).find(which) != nullptr; }

struct CoordinateAt {
  Real value = kNoNumber, rate = kNoNumber;
};

CoordinateAt coordinate(const World& world, Entity joint, Coordinate which) {
  CoordinateAt at;
  const std::uint32_t slot = world.links.slot(joint);
  if (slot == kNoSlot) return at;
  const Link& link = world.links.values()[slot];
  const Body *on_a = world.bodies.find(link.a), *on_b = world.bodies.find(link.b);
  if (!on_a || !on_b || !has(link.joint.kind, which)) return at;
  const Placed a = placed(*on_a), b = placed(*on_b);
  const Real before = which == Coordinate::turn ? counted_angle(world, slot) : 0;
  Vec3 j[4];
  write_coordinate(link.joint, which, a, b, before, {&at.value, j, nullptr});
  at.rate = glm::dot(j[0], a.velocity) + glm::dot(j[1], a.spin) + glm::dot(j[2], b.velocity) +
            glm::dot(j[3], b.spin);
  return at;
}

/// What the procedural solver divides multipliers by to have newtons; 0 before its first step.
Real to_force(const articulated::Island& a) {
  const Real h = a.last_step;
  return h > 0 ? 1 / (a.force_share * h * h) : 0;
}

/// Finds what holds a body of an articulation, by a function of a tree, of a hold: the force on it.
std::optional<Vec3> articulated_link_force(const World& world, std::uint32_t slot) {
  const Link& link = world.links.values()[slot];
  for (const articulated::Island& a : articulated::islands_of(world)) {
    const Real scale = to_force(a);
    if (scale == 0) continue;
    for (std::size_t c = 0; c < a.count(); ++c) {
      if (a.links[c] != slot) continue;
      const Vec3 on_own = scale * a.memory.vec(articulated::kLoad, c);
      return a.bodies[c] == link.b ? on_own : -on_own;
    }
    for (const articulated::Hold& h : a.holds) {
      if (h.held_link != slot) continue;
      const Vec3 on_held = scale * h.load;
      return a.bodies[h.column] == link.b ? on_held : -on_held;
    }
  }
  return std::nullopt;
}

std::optional<Vec3> articulated_pin_force(const World& world, std::uint32_t pin) {
  for (const articulated::Island& a : articulated::islands_of(world)) {
    const Real scale = to_force(a);
    if (scale == 0) continue;
    for (const articulated::Tree& t : a.trees)
      if (t.held_pin == pin) return scale * a.memory.vec(articulated::kLoad, t.first);
    for (const articulated::Hold& h : a.holds)
      if (h.held_pin == pin) return scale * h.load;
  }
  return std::nullopt;
}

/// Of a pin that pulls by a spring on a mechanism.
Vec3 spring_force(const World& world, const Pin& pin) {
  const Body& body = world.bodies[pin.body];
  const Vec3 at = to_world(body.pose, pin.anchor);
  const Vec3 to = pin.to ? to_world(world.bodies[pin.to].pose, pin.target) : pin.target;
  return pin.stiffness * (to - at);
}

}  // namespace

Real joint_angle(const World& world, Entity joint) {
  return coordinate(world, joint, Coordinate::turn).value;
}
Real joint_second_angle(const World& world, Entity joint) {
  return coordinate(world, joint, Coordinate::second).value;
}
Real joint_angular_speed(const World& world, Entity joint) {
  return coordinate(world, joint, Coordinate::turn).rate;
}
Real joint_travel(const World& world, Entity joint) {
  return coordinate(world, joint, Coordinate::slide).value;
}
Real joint_speed(const World& world, Entity joint) {
  return coordinate(world, joint, Coordinate::slide).rate;
}

std::optional<JointReaction> joint_reaction(const World& world, Entity joint) {
  const std::uint32_t slot = world.links.slot(joint);
  if (slot == kNoSlot) return std::nullopt;
  const Link& link = world.links.values()[slot];
  if (const auto at = find_block(mechanism_of(world, link.a, link.b), lagrangian::BlockKind::joint, slot)) {
    if (at->mechanism->fresh || !at->mechanism->room.ready) return std::nullopt;
    const lagrangian::JointForce f = lagrangian::joint_force(*at->mechanism, at->block);
    const Vec3 arm = world.bodies[link.b].pose.rotation * link.joint.anchor_b;
    return JointReaction{f.force, f.torque - glm::cross(arm, f.force)};
  }
  const auto force = articulated_link_force(world, slot);
  if (!force) return std::nullopt;
  return JointReaction{*force, std::nullopt};
}

Real cable_tension(const World& world, Entity cable) {
  const std::uint32_t slot = world.strings.slot(cable);
  if (slot == kNoSlot) return kNoNumber;
  const String& s = world.strings.values()[slot];
  const lagrangian::Island* m = mechanism_of(world, s.a, s.b);
  if (const auto at = find_block(m, lagrangian::BlockKind::cable, slot))
    return glm::length(lagrangian::joint_force(*at->mechanism, at->block).force);
  if (m && s.joint.compliance > 0)
    return stretch(s.joint, world.bodies[s.a].pose, world.bodies[s.b].pose) / s.joint.compliance;
  return s.tension;
}

std::optional<Vec3> pin_force(const World& world, Entity pin) {
  const std::uint32_t slot = world.pins.slot(pin);
  if (slot == kNoSlot) return std::nullopt;
  const Pin& p = world.pins.values()[slot];
  const lagrangian::Island* m = mechanism_of(world, p.body, p.to);
  if (const auto at = find_block(m, lagrangian::BlockKind::pin, slot)) {
    if (m->fresh || !m->room.ready) return std::nullopt;
    return -lagrangian::joint_force(*m, at->block).force;
  }
  if (m && p.grip == Grip::spring) return m->fresh ? std::nullopt : std::optional(spring_force(world, p));
  return articulated_pin_force(world, slot);
}

}  // namespace pantin
