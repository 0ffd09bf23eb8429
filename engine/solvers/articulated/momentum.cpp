#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::articulated {
namespace {

struct MassCentre {
  Real mass = 0;
  Vec3 position{0}, velocity{0};
};

MassCentre mass_centre(const World& world, const Island& a, const Tree& tree) {
  MassCentre m;
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    m.mass += b.mass;
    m.position += b.mass * b.pose.position, m.velocity += b.mass * b.velocity;
  }
  m.position /= m.mass, m.velocity /= m.mass;
  return m;
}

Vec3 spin_momentum_about(const World& world, const Island& a, const Tree& tree,
                         const MassCentre& centre) {
  Vec3 l(0);
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    l += b.mass * glm::cross(b.pose.position - centre.position, b.velocity - centre.velocity);
    l += b.pose.rotation * (b.inertia * (glm::conjugate(b.pose.rotation) * b.spin));
  }
  return l;
}

Mat3 whole_inertia(const World& world, const Island& a, const Tree& tree, Vec3 centre) {
  Mat3 sum(0);
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    const Vec3 r = b.pose.position - centre;
    sum += world_inertia(b.pose.rotation, b.inertia) +
           b.mass * (glm::dot(r, r) * Mat3(1) - glm::outerProduct(r, r));
  }
  return sum;
}

/// What drag and given torques leave of the angular momentum over one step; false where bodies are
/// braked unequally, since then the joints decide.
bool expected_spin_momentum(const World& world, const Island& a, const Tree& tree,
                            const MassCentre& centre, Real h, Vec3& expected) {
  const Real drag = a.constants.at(kDrag, tree.first);
  expected = std::exp(-drag * h) * tree.spin_momentum;
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c) {
    if (a.constants.at(kDrag, c) != drag) return false;
    if (!a.forced) continue;
    const Vec3 force = a.constants.at(kMass, c) * a.room.forces.vec(0, c);
    const Vec3 at = world.bodies.values()[a.slots[c]].pose.position;
    expected += h * (glm::cross(at - centre.position, force) + a.room.forces.vec(3, c));
  }
  return true;
}

/// Moves the whole tree back to where its mass centre would be without the joints.
void shift(World& world, Island& a, const Tree& tree) {
  Vec3 off(0);
  Real mass = 0;
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c) {
    const Real m = a.constants.at(kMass, c);
    mass += m;
    off += m * (a.room.work.vec(kPosition, c) - world.bodies.values()[a.slots[c]].pose.position);
  }
  off /= mass;
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c) {
    world.bodies.values()[a.slots[c]].pose.position += off;
    a.memory.set(kLastSlide, c, a.memory.vec(kLastSlide, c) + off);
  }
  // The velocities of the step follow from the displacement: all get the same share.
  const Real rate = (a.fresh ? 2 : a.second_order ? 1.5 : 1.0);
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c)
    world.bodies.values()[a.slots[c]].velocity += rate / a.last_step * off;
}

/// Turns the whole tree rigidly and corrects its spin, so that it has the angular momentum
/// `wanted`.
void spin_up(World& world, Island& a, const Tree& tree, Vec3 wanted, Real h) {
  MassCentre centre = mass_centre(world, a, tree);
  const Real share = a.fresh ? 0.5 : a.second_order ? 2.0 / 3 : 1.0;
  const Vec3 lack = wanted - spin_momentum_about(world, a, tree, centre);
  const Vec3 omega = solve_symmetric(whole_inertia(world, a, tree, centre.position), lack);
  const Quat turn = turn_by(share * h * omega);
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    const Vec3 moved = centre.position + turn * (b.pose.position - centre.position);
    a.memory.set(kLastSlide, c, a.memory.vec(kLastSlide, c) + moved - b.pose.position);
    a.memory.set(kLastTurn, c, a.memory.vec(kLastTurn, c) + share * h * omega);
    b.pose = {moved, glm::normalize(turn * b.pose.rotation)};
  }
  // In the turned pose the spin is corrected once more, now to the last bit.
  const Vec3 left = wanted - spin_momentum_about(world, a, tree, centre);
  const Vec3 extra = solve_symmetric(whole_inertia(world, a, tree, centre.position), left);
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    b.velocity += glm::cross(extra, b.pose.position - centre.position);
    b.spin += extra;
  }
}

}  // namespace

Vec3 spin_momentum(const World& world, const Island& a, const Tree& tree) {
  return spin_momentum_about(world, a, tree, mass_centre(world, a, tree));
}

bool repair_momentum(World& world, Island& a, Real h) {
  if (!a.cords.empty() || !a.holds.empty()) return false;
  bool repaired = false;
  for (Tree& t : a.trees) {
    if (a.parents[t.first] != kFree || t.count < 2) continue;
    a.last_step = h;
    shift(world, a, t);
    Vec3 expected;
    if (expected_spin_momentum(world, a, t, mass_centre(world, a, t), h, expected)) {
      spin_up(world, a, t, expected, h);
      t.spin_momentum = expected;
    }
    repaired = true;
  }
  return repaired;
}

}  // namespace pantin::articulated
