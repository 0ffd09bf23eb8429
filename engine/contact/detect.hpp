#pragma once
/// Contact detection.
#include <span>

#include "engine/base/invariants.hpp"
#include "engine/base/math.hpp"
#include "engine/base/threads.hpp"
#include "engine/contact/contact.hpp"
#include "engine/geometry/shape.hpp"
#include "engine/world/body.hpp"

namespace pantin {
struct World;
}

namespace pantin::detail {

namespace contact {

/// The reach that marks a sleeping body.
inline constexpr Real kAtRest = -1;

/// What a body's surface may move in a step, as a multiple of the predicted displacement: joints
/// and contacts change it.
inline constexpr Real kReachFactor = 1.25;

/// Fills contacts_of(world) from the current poses: all points where two bodies may come into
/// contact within the step, so that fast bodies do not tunnel through thin ones. `reach` (m, by
/// body slot) bounds the displacement of each body's surface.
///
/// At most 8 points for a pair of convex shapes and 16 for a shape on a mesh or a height field.
/// Multipliers and spring offsets of the previous step are carried over to contacts of the same
/// bodies and key (warm start). Sorted by slots and key without duplicates; does not allocate in
/// the steady state. Contacts between bodies at rest, fixed ones or those with a reach of kAtRest,
/// stay as they were.
void find_contacts(World& world, std::span<const Real> reach);

/// A search for the contacts of a step.
struct SearchTask {
  Real h = 0;                             // s
  const ContactFilter* filter = nullptr;  // decides which bodies collide
  Threads threads = {};
};

/// Detects the contacts of a step from the poses at its start and the solvers'
/// reaches in Memory::scratch. Kinematic bodies, and those in DetectScratch::starts, are already at
/// their poses at the end of the step.
void detect(World& world, const SearchTask& task);

/// Fills sensor_overlaps_of(world) from the current poses, for the bodies that the last
/// detection saw. Costs nothing where there is no sensor; does not allocate in the steady state.
void sense(World& world);

/// Distance of the farthest point of a body's shapes from its mass centre, m.
Real extent_of(const Shapes& shapes);

/// One of the two bodies of a contact, and its rotation from body axes to world axes.
struct BodyOfContact {
  enum class Side : std::uint8_t { a, b } side;
  Quat rotation;
};

/// Contact point of a body as a function of its rotation: the sum of a body point, the farthest
/// point of a circle about a body axis along the outward normal, and a radius along that normal.
struct TouchedPlace {
  Vec3 core{0};                 // m, body frame
  Vec3 axis{0};                 // unit, body frame
  Real circle = 0, radius = 0;  // m

  /// m, from the mass centre, world axes.
  Vec3 at(Quat rotation, Vec3 outward) const {
    Vec3 place = rotation * core + radius * outward;
    if (circle == 0) return place;
    PANTIN_ASSERT(is_unit(axis) && is_unit(outward));
    const Vec3 about = rotation * axis, across = outward - glm::dot(outward, about) * about;
    const Real length = glm::length(across);
    return length > 0 ? place + circle / length * across : place;
  }
  /// Angular rate of the circle's farthest point about the normal while the body rotates, rad/s.
  Real rate_around(Quat rotation, Vec3 spin, Vec3 normal) const;
  /// Whether this is a point of the body on the circle of `rim`.
  bool lies_on(const TouchedPlace& rim) const;
};
TouchedPlace touched_place(const World& world, const Contact& contact, const BodyOfContact& at);

/// Whether a body without a solver moves (a kinematic body).
bool moves(const Body& b);

/// The pose, `h` seconds before, of a kinematic body that is at the end of the step already.
Pose pose_before(const Body& b, Real h);

}  // namespace contact
}  // namespace pantin::detail
