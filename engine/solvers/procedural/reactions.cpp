// What articulations do to the bodies of mechanisms that hold them or lie below them.
//
// Multipliers say how the reactions are shared out; their sum is taken from the balance of momentum,
// so that what one side loses the other gains:
//   sum of forces on the articulation = (p_after - p_before) / h - weight + drag
#include <algorithm>

#include "engine/solvers/procedural/internal.hpp"
#include "engine/solvers/procedural/procedural.hpp"

namespace pantin::procedural {
namespace {

/// Where the force of a pin or a string is told.
Hanging* hanging_of(World& world, BlockKind kind, std::uint32_t source) {
  for (Mechanism& m : world.mechanisms)
    for (Hanging& g : m.hangings)
      if (g.kind == kind && g.source == source) return &g;
  return nullptr;
}

/// All forces on the articulation but those of its holders, N: weight, pushes, drag.
Vec3 other_forces(const World& world, const Articulation& a, Real h) {
  Vec3 sum(0);
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Real mass = a.constants.at(kMass, c);
    sum += mass * a.constants.at(kGravityScale, c) * world.gravity;
    if (a.forced) sum += mass * a.room.forces.vec(0, c);
    sum -= a.constants.at(kDrag, c) * mass / h * a.memory.vec(kLastSlide, c);
  }
  return sum;
}

/// At most this many holders of one articulation are told apart.
constexpr std::size_t kMost = 16;

struct Reactions {
  Vec3 sum{0};     // N on the articulation, all holders
  Real sizes = 0;  // of the told ones
  Hanging* told[kMost] = {};
  std::size_t count = 0;
  bool others = false;  // holders that are no mechanism's
};

/// What an articulation presses on mechanisms is felt in their next step.
void press(World& world, const Articulation& a) {
  for (const Touch& t : a.room.touches) {
    const Contact& c = world.contacts[t.contact];
    if (t.side < 0 || !c.active || !world.is_exact(c.slot_b)) continue;
    const MechanismPlace at = world.exact[c.slot_b];
    std::vector<Vec3>& owed = world.mechanisms[at.mechanism].owed;
    owed[2 * at.body] -= c.force;
    owed[2 * at.body + 1] -=
        glm::cross(world.bodies.values()[c.slot_b].pose.rotation * c.point_b, c.force);
  }
}

}  // namespace

void tell_pulls(World& world, Articulation& a, Real h) {
  const Real to_force = 1 / (a.force_share * h * h);
  Reactions r;
  const auto hold = [&](BlockKind kind, std::uint32_t source, Vec3 force) {
    r.sum += force;
    Hanging* g = source == UINT32_MAX ? nullptr : hanging_of(world, kind, source);
    if (!g || r.count == kMost) {
      r.others = r.others || force != Vec3(0);
      return;
    }
    g->force = -force, g->mass = a.mass;
    r.told[r.count++] = g, r.sizes += glm::length(force);
  };
  for (const Tree& t : a.trees)
    if (a.parents[t.first] == kHeld)
      hold(BlockKind::pin, t.held_pin, to_force * a.memory.vec(kLoad, t.first));
  for (const Hold& g : a.holds)
    if (g.partner == UINT32_MAX) hold(BlockKind::pin, g.held_pin, to_force * g.load);
  for (const Cord& cord : a.cords) {
    if (cord.column_a != UINT32_MAX && cord.column_b != UINT32_MAX) continue;
    const String& s = world.strings.values()[cord.string];
    const Vec3 to_b = to_world(world.bodies[s.b].pose, s.joint.anchor_b) -
                      to_world(world.bodies[s.a].pose, s.joint.anchor_a);
    const Real span = glm::length(to_b);
    const Vec3 on_a = span > 0 ? to_force * cord.load / span * to_b : Vec3(0);
    hold(BlockKind::string, cord.string, cord.column_a != UINT32_MAX ? on_a : -on_a);
  }
  for (const Touch& t : a.room.touches)
    r.others = r.others || (t.side > 0 && world.contacts[t.contact].active);
  if (r.count == 0 || r.others) return;
  Vec3 momentum(0);
  for (std::size_t c = 0; c < a.count(); ++c)
    momentum += a.constants.at(kMass, c) * world.bodies.values()[a.slots[c]].velocity;
  const Vec3 lack = (momentum - a.momentum_before) / h - other_forces(world, a, h) - r.sum;
  // What the multipliers do not explain is shared by their sizes.
  for (std::size_t i = 0; i < r.count; ++i) {
    const Real part = r.sizes > 0 ? glm::length(r.told[i]->force) / r.sizes
                                  : Real(1) / static_cast<Real>(r.count);
    r.told[i]->force -= part * lack;
  }
}

void tell_pressures(World& world) {
  for (const Articulation& a : world.articulations) press(world, a);
}

}  // namespace pantin::procedural
