// Whether a group is solved as a whole (group_rest.cpp): its bodies hardly move, glide on one
// another, or are pressed too hard for contact springs.
#include <algorithm>

#include "engine/solvers/articulated/impulses/group_resting.hpp"
#include "engine/solvers/articulated/impulses/rest_cones.hpp"

namespace pantin::detail::articulated {
namespace {

/// A body is calm below this speed, m/s, and this path in a step, in sizes of the body.
constexpr Real kCalmWay = 0.02;
/// m/s: the same for few bodies, whose other method is exact: they must be nearly still.
constexpr Real kStill = 1e-3;
/// Fraction of a shallow overlap: points with a smaller gap bear bodies that glide.
constexpr Real kBears = 0.1;
/// Sizes of a body by which contact springs may give way under the load that it bears, where most
/// pairs touch at edges and where they touch at faces, as in towers; and would under the weight of
/// the heaviest, and of all.
constexpr Real kSags = 0.003, kSagsAtFaces = 0.0003, kSagsByOne = 0.05, kSagsByAll = 0.1;
constexpr std::size_t kPointsOfFace = 3;
/// Least mean number of points of a pair: bodies touching at single points roll, and rarely rest.
constexpr std::size_t kLeastPoints = 2;
/// Largest fraction of a group's mass that may swing from it.
constexpr Real kArms = 0.1;

Real most_of(std::size_t bodies) { return bodies > kFewBodies ? kRestSpeed : kStill; }

/// Adds up the bodies of a group that rest, on ground that may move as a whole, and those that
/// swing from them.
struct Calmness {
  enum class May : std::uint8_t { rest, swing };
  Real most = 0, h = 0;        // m/s; s
  Vec3 ground{0};              // m/s
  Real moving = 0, whole = 0;  // kg
  bool is_lost = false;        // a body moves that must not

  Calmness(std::span<const GroupBody> bodies, std::size_t free, Real step)
      : most(most_of(free)), h(step) {
    const auto all_ground = bodies.subspan(free);
    if (!all_ground.empty()) ground = all_ground.front().velocity;
    for (const GroupBody& b : all_ground)
      is_lost = is_lost || b.velocity != ground || b.spin != Vec3(0);
  }
  bool is_calm(const GroupBody& b, const Wrench& motion) const {
    const Real size = size_of(b);
    const Real speed = glm::length(motion.force - ground) + size * glm::length(motion.torque);
    return speed < most && h * speed < kCalmWay * size;
  }
  void add(const GroupBody& b, const Wrench& motion, May may) {
    whole += 1 / b.per_mass;
    if (is_calm(b, motion)) return;
    moving += 1 / b.per_mass;
    is_lost = is_lost || may == May::rest;
  }
  bool holds() const { return !is_lost && moving <= kArms * whole; }
};

/// Whether bodies glide on one another: none turns, and none parts from what bears it or comes
/// nearer. `motion_of` gives the motion of a free body.
template <class MotionOf>
bool all_glide(std::span<const GroupBody> bodies, std::span<const GroupContact> contacts,
               std::size_t free, const MotionOf& motion_of) {
  const auto speed_of = [&](std::uint32_t i) {
    return i < free ? motion_of(i).force : bodies[i].velocity;
  };
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (i >= free) {
      if (bodies[i].spin != Vec3(0)) return false;
      continue;
    }
    const Wrench motion = motion_of(static_cast<std::uint32_t>(i));
    if (bodies[i].node != kNoNode ||
        !(size_of(bodies[i]) * glm::length(motion.torque) < kRestSpeed))
      return false;
  }
  return std::none_of(contacts.begin(), contacts.end(), [&](const GroupContact& c) {
    return bears(c) && !(std::abs(glm::dot(c.axes[0], speed_of(c.a) - speed_of(c.b))) < kRestSpeed);
  });
}

}  // namespace

bool bears(const GroupContact& c) { return c.impulse.x > 0 || c.gap < kBears * c.shallow; }

bool may_glide(std::span<const GroupBody> bodies, std::span<const GroupContact> contacts,
               std::size_t free) {
  const auto is_borne = [](const GroupBody& b) {
    return b.touched || glm::length(b.velocity) < kRestSpeed;
  };
  return std::all_of(bodies.begin(), bodies.begin() + static_cast<std::ptrdiff_t>(free),
                     is_borne) &&
         all_glide(bodies, contacts, free, [&](std::uint32_t i) {
           return Wrench{bodies[i].velocity, bodies[i].spin};
         });
}

Real whole_weight(std::span<const GroupBody> bodies) {
  Real weight = 0;
  for (const GroupBody& b : bodies)
    if (b.per_mass > 0) weight += glm::length(b.acceleration) / b.per_mass;
  return weight;
}

bool have_faces(std::size_t points, std::size_t pairs) { return points >= kLeastPoints * pairs; }

bool is_pressed(std::span<const GroupBody> bodies, std::span<const GroupContact> contacts,
                std::size_t free, Real h) {
  if (free <= kFewBodies) return false;
  const Real weight = whole_weight(bodies), stiffness = spring_stiffness(h);
  /// Sizes of a body by which a load compresses its springs.
  const auto sag_of = [&](const GroupBody& b, Real load) {
    return load * b.per_mass / (stiffness * size_of(b));
  };
  Real under_all = 0, under_one = 0, heaviest = 0, most = 0;
  for (const GroupBody& b : bodies.first(free))
    heaviest = std::max(heaviest, glm::length(b.acceleration) / b.per_mass);
  for (const GroupBody& b : bodies.first(free)) {
    under_all = std::max(under_all, sag_of(b, weight));
    under_one = std::max(under_one, sag_of(b, heaviest));
  }
  if (under_one > kSagsByOne) return true;
  std::size_t slide = 0, hold = 0, pairs = 0, at_faces = 0, all_pairs = 0;
  for (std::size_t from = 0, to = 0; from < contacts.size(); from = to) {
    Real load = 0;
    std::size_t points = 0;
    for (to = from; to < contacts.size() && have_same_bodies(contacts[to], contacts[from]); ++to) {
      if (!(contacts[to].impulse.x > 0)) continue;
      load += contacts[to].impulse.x, ++points;
      ++(holds(contacts[to]) ? hold : slide);
    }
    ++all_pairs, pairs += points > 0, at_faces += points >= kPointsOfFace;
    for (const std::uint32_t i : {contacts[from].a, contacts[from].b})
      if (i < free) most = std::max(most, sag_of(bodies[i], std::min(load, weight)));
  }
  if (!have_faces(contacts.size(), all_pairs)) return false;
  if (under_all > kSagsByAll) return true;
  if (pairs == 0) return under_all > kSagsAtFaces;  // they are about to strike
  return slide <= hold && most > (2 * at_faces >= pairs ? kSagsAtFaces : kSags);
}

bool are_calm(const Group& g, const GroupPart& part) {
  if (may_glide_for(g, part.h))
    return all_glide(g.bodies, g.contacts, g.resting.size(),
                     [&](std::uint32_t i) { return g.resting[i].motion; });
  Calmness calm(g.bodies, g.resting.size(), part.h);
  for (std::size_t i = 0; i < g.resting.size(); ++i) {
    const RestBody& r = g.resting[i];
    const bool swings = part.h < part.whole && !r.touches;
    calm.add(g.bodies[i], r.motion, swings ? Calmness::May::swing : Calmness::May::rest);
  }
  return calm.holds();
}

bool is_calm(std::span<const GroupBody> bodies, std::size_t free, Real h) {
  Calmness calm(bodies, free, h);
  for (const GroupBody& b : bodies.first(free))
    calm.add(b, {b.velocity, b.spin},
             b.node != kNoNode && !b.touched ? Calmness::May::swing : Calmness::May::rest);
  return calm.holds();
}

}  // namespace pantin::detail::articulated
