#include <optional>

#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

struct MassCentre {
  Real mass = 0;
  Vec3 position{0}, velocity{0};
};

MassCentre mass_centre(const World& world, const Island& a, const Tree& tree) {
  PANTIN_ASSERT(is_part(tree.first, tree.count, a.count()));
  MassCentre m;
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    m.mass += b.mass;
    m.position += b.mass * b.pose.position, m.velocity += b.mass * b.velocity;
  }
  m.position /= m.mass, m.velocity /= m.mass;
  return m;
}

Vec3 angular_momentum_about(const World& world, const Island& a, const Tree& tree,
                            const MassCentre& centre) {
  Vec3 l(0);
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    l += b.mass * glm::cross(b.pose.position - centre.position, b.velocity - centre.velocity);
    l += b.pose.rotation * (b.inertia * (glm::conjugate(b.pose.rotation) * b.angular_velocity));
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

/// Expected angular momentum after drag and external torques over one step; none if drag differs
/// between bodies, since it then depends on the joints.
std::optional<Vec3> expected_angular_momentum(const World& world, const Island& a, const Tree& tree,
                                              Real h) {
  const MassCentre centre = mass_centre(world, a, tree);
  const Real drag = a.constants.at(kDrag, tree.first);
  Vec3 expected = std::exp(-drag * h) * tree.angular_momentum;
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c) {
    if (a.constants.at(kDrag, c) != drag) return std::nullopt;
    if (!a.forced) continue;
    const Vec3 force = a.constants.at(kMass, c) * a.scratch.forces.vec(0, c);
    const Vec3 at = world.bodies.values()[a.slots[c]].pose.position;
    expected += h * (glm::cross(at - centre.position, force) + a.scratch.forces.vec(3, c));
  }
  return expected;
}

/// Translates the whole tree so that its mass centre moves as in free motion.
void shift(World& world, Island& a, const Tree& tree) {
  Vec3 off(0);
  Real mass = 0;
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c) {
    const Real m = a.constants.at(kMass, c);
    mass += m;
    off += m * (a.scratch.work.vec(kPosition, c) - world.bodies.values()[a.slots[c]].pose.position);
  }
  off /= mass;
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c) {
    world.bodies.values()[a.slots[c]].pose.position += off;
    a.memory.set(kLastTranslation, c, a.memory.vec(kLastTranslation, c) + off);
  }
  // Velocities follow from displacements: all change by the same amount.
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c)
    world.bodies.values()[a.slots[c]].velocity += off / a.last_step;
}

/// Rotates the whole tree rigidly and corrects its angular velocity, so that its angular momentum
/// is `bias`. The step is Island::last_step.
void set_angular_momentum(World& world, Island& a, const Tree& tree, Vec3 bias) {
  const Real h = a.last_step;
  PANTIN_ASSERT(h > 0);
  MassCentre centre = mass_centre(world, a, tree);
  const Vec3 residual = bias - angular_momentum_about(world, a, tree, centre);
  const Vec3 omega = solve_symmetric(whole_inertia(world, a, tree, centre.position), residual);
  const Quat rotation = from_rotation_vector(h * omega);
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    const Vec3 moved = centre.position + rotation * (b.pose.position - centre.position);
    a.memory.set(kLastTranslation, c, a.memory.vec(kLastTranslation, c) + moved - b.pose.position);
    a.memory.set(kLastRotation, c, a.memory.vec(kLastRotation, c) + h * omega);
    b.pose = {moved, glm::normalize(rotation * b.pose.rotation)};
  }
  // A second correction at the rotated pose, exact up to rounding.
  const Vec3 left = bias - angular_momentum_about(world, a, tree, centre);
  const Vec3 extra = solve_symmetric(whole_inertia(world, a, tree, centre.position), left);
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    b.velocity += glm::cross(extra, b.pose.position - centre.position);
    b.angular_velocity += extra;
  }
}

}  // namespace

Vec3 angular_momentum(const World& world, const Island& a, const Tree& tree) {
  return angular_momentum_about(world, a, tree, mass_centre(world, a, tree));
}

void keep_angular_momentum(World& world, const Island& a, Tree& tree, Real h) {
  const MassCentre centre = mass_centre(world, a, tree);
  const std::optional<Vec3> expected = expected_angular_momentum(world, a, tree, h);
  tree.knows_angular_momentum = expected.has_value();
  if (!expected) return;
  const Vec3 left = *expected - angular_momentum_about(world, a, tree, centre);
  const Vec3 omega = solve_symmetric(whole_inertia(world, a, tree, centre.position), left);
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    b.velocity += glm::cross(omega, b.pose.position - centre.position);
    b.angular_velocity += omega;
  }
  tree.angular_momentum = *expected;
}

void repair_momentum(World& world, Island& a, Real h) {
  if (has_rows(a)) return;
  for (Tree& t : a.trees) {
    if (a.parents[t.first] != kFree || t.count < 2) continue;
    a.last_step = h;
    shift(world, a, t);
    if (const std::optional<Vec3> expected = expected_angular_momentum(world, a, t, h)) {
      set_angular_momentum(world, a, t, *expected);
      t.angular_momentum = *expected;
    }
  }
}

}  // namespace pantin::detail::articulated
