#pragma once
/// A group at rest, solved as a whole: group_rest.cpp, with the rows of joints, limits and cables
/// of group_rest_links.cpp.
#include "engine/solvers/articulated/impulses/group_points.hpp"

namespace pantin::detail::articulated {

/// Compliance R, as a fraction of the response of a point.
inline constexpr Real kRestCompliance = 1e-7;
/// m/s: slower bodies may be at rest.
inline constexpr Real kRestSpeed = 0.02;
/// s: in longer steps gliding bodies would lag behind.
inline constexpr Real kGlidingSubstep = 1.0 / 400;
/// Whether a group may glide in a step of h seconds: more than few bodies, none with joints.
inline bool may_glide_for(const Group& g, Real h) {
  return h < kGlidingSubstep && g.trees.empty() && g.resting.size() > kFewBodies;
}
/// Fraction of an overlap closed in a step.
inline constexpr Real kRestClosed = 0.2;

/// Which rows act: those of the current speeds, those of the last step, or those that acted when
/// impulses were last computed.
enum class Acting : std::uint8_t { now, as_before, as_found };

/// A motion of a body; a fixed one keeps its own, and has no direction.
inline Wrench motion_of(const Group& g, std::uint32_t body, Wrench RestBody::*motion) {
  if (body < g.resting.size()) return g.resting[body].*motion;
  const GroupBody& b = g.bodies[body];
  return motion == &RestBody::direction ? Wrench{} : Wrench{b.velocity, b.spin};
}

/// m: a radius of gyration.
inline Real size_of(const GroupBody& b) {
  const Vec3 per = b.per_inertia;
  return std::sqrt(b.per_mass / std::min({per.x, per.y, per.z}));
}

/// Whether all bodies are calm in a step; in a part of it light ones that touch nothing may swing,
/// and bodies without joints glide on one another (group_calm.cpp).
bool are_calm(const Group& g, const GroupPart& part);

/// Whether bodies touch at faces, not at single points, given the points of all pairs.
bool have_faces(std::size_t points, std::size_t pairs);
/// Whether loads press bodies without joints, of which the first `free` are dynamic, so hard that
/// sweeps would leave a sag in steps of h seconds. Impulses are forces.
bool is_pressed(std::span<const GroupBody> bodies, std::span<const GroupContact> contacts,
                std::size_t free, Real h);
/// N: the weight of all bodies, and the forces applied to them.
Real whole_weight(std::span<const GroupBody> bodies);

/// The most rows of a joint with its actuator, of its limits, and of soft zones and the drive.
inline constexpr std::size_t kMostJointLinks = 6, kMostLimitLinks = 4,
                             kMostSpringLinks = TurnSprings::kMost;

/// The rows of all joints, limits within reach and ties at the current poses; arms refer to mass
/// centres. `fast`: m/s, above which bodies do not rest.
void begin_links(const Group& g, const GroupPart& part, Real fast);
/// Predicts which limits and cables act, given a margin of speed, m/s.
void predict_links(const Group& g, Real margin);
/// Computes the impulses, and adds them to the residuals of momentum.
void add_link_impulses(const Group& g, Acting acting);
/// Adds J^T G J to the matrix.
void add_link_blocks(const Group& g, const BlockFactor& e);
/// Before a line search: changes of speed along the direction.
void aim_links(const Group& g);
/// Derivative of the rows' part of the objective at a fraction of the direction.
Real slope_of_links(const Group& g, Real part);
/// Reduces the compliance of rows that yield faster. Whether there are any.
bool harden_links(const Group& g, Real most);

/// Writes the impulses and torques that were found to the contacts.
void set_rest_impulses(const Group& g);
/// Applies the impulses that were found, to trees through their joints; applies others instead.
void push_resting_trees(const Group& g, const GroupPart& part);
void push_trees_again(const Group& g, Real h);

/// Translates a tree so that the bodies that bear it move as their contacts ask for, in the mean:
/// swinging arms would push them into the ground, or aside.
void keep_standing(const Group& g, const GroupTree& t);

}  // namespace pantin::detail::articulated
