// The cheapest model for a scene that accepts an error.
#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "engine/base/disjoint_sets.hpp"
#include "engine/geometry/convex.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/scene/build/build.hpp"
#include "engine/world/flat.hpp"

namespace pantin::detail {
namespace {

/// From here on "planar" is accurate enough in contact: `pantin chart` of the shipped scenes.
constexpr Real kContactError = 0.01;

/// Counts errors, and forgets them.
class Refusals final : public BuildMessages {
 public:
  void error(const ElementId&, std::string_view, std::string) override { ++count_; }
  void warn(const ElementId&, std::string_view, std::string) override {}
  std::size_t errors() const override { return count_; }
  Hints& hints() override { return hints_; }

 private:
  std::size_t count_ = 0;
  Hints hints_;
};

/// Whether all bodies that collide meet at one height z, as their sections in the plane do: round
/// shapes with their centres, prisms with some part.
bool are_level(const BuiltScene& built) {
  constexpr Real kSame = 1e-6;  // m
  const Real none = std::numeric_limits<Real>::infinity();
  Real bottom = -none, top = none;
  for (const BuiltBody& b : built.bodies) {
    if (!b.collision || !b.mass_properties) continue;
    Real low = none, high = -none;
    for (const Shape& shape : b.mass_properties->shapes) {
      if (shape.kind == ShapeKind::plane) continue;
      const Pose at = compose(b.body.pose, shape.local);
      const bool is_prism = shape.kind == ShapeKind::box || shape.kind == ShapeKind::cylinder ||
                            shape.kind == ShapeKind::hull;
      const Aabb box = bounds_of(shape, at);
      low = std::min(low, is_prism ? box.low.z : at.position.z - kSame);
      high = std::max(high, is_prism ? box.high.z : at.position.z + kSame);
    }
    if (low > high) continue;
    bottom = std::max(bottom, low), top = std::min(top, high);
  }
  return bottom <= top;
}

/// What the bodies of a scene that are free to move consist of.
struct Makeup {
  bool has_tree = false;     // of two bodies or more, and no loop
  bool has_loop = false;     // or what "auto" leaves to "lagrangian"
  bool has_solid = false;    // a free body that collides
  bool has_bounces = false;  // restitution
};

Makeup makeup_of(const BuiltScene& built) {
  const auto count = static_cast<std::uint32_t>(built.bodies.size());
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  DisjointSets islands(count);
  std::vector<bool> is_looped(count, false);
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    const bool moves_a = built.is_dynamic(a), moves_b = built.is_dynamic(b);
    if (moves_a && moves_b) islands.join(a, b);
    return std::pair(moves_a ? a : count, moves_b ? b : count);
  };
  const auto close = [&](std::uint32_t a, std::uint32_t b) {
    const auto [at, to] = join(a, b);
    if (at < count) is_looped[at] = true;
    if (to < count) is_looped[to] = true;
  };
  for (const BuiltJoint& j : built.joints) {
    pairs.push_back(join(j.a, j.b));
    const bool is_exact = j.drive && j.drive->exact;
    if (!is_articulated(j.joint.kind) || (*j.joint.parameters).restitution != 0 || is_exact)
      close(j.a, j.b);
  }
  for (const BuiltSurfaceJoint& s : built.surface_joints) close(s.a, s.b);
  for (const BuiltGear& g : built.gears) close(built.joints[g.first].b, built.joints[g.second].b);
  for (const BuiltBelt& b : built.belts)
    for (const std::uint32_t body : b.bodies) close(b.bodies.front(), body);
  const std::vector<bool> closers = loop_closers(count, pairs);
  std::vector<bool> has_loop(count, false);
  std::vector<int> sizes(count, 0);
  for (std::uint32_t i = 0; i < count; ++i) {
    if (!built.is_dynamic(i)) continue;
    ++sizes[islands.root(i)];
    if (closers[i] || is_looped[i]) has_loop[islands.root(i)] = true;
  }
  Makeup made;
  for (std::uint32_t i = 0; i < count; ++i) {
    const BuiltBody& b = built.bodies[i];
    made.has_bounces = made.has_bounces || (b.collision && b.collision->restitution > 0);
    if (!built.is_dynamic(i)) continue;
    const bool is_solid = b.collision != nullptr;
    made.has_solid = made.has_solid || is_solid;
    made.has_loop = made.has_loop || has_loop[i];
    made.has_tree = made.has_tree || (!has_loop[islands.root(i)] && sizes[islands.root(i)] > 1);
  }
  return made;
}

/// Whether "planar" is the cheaper model of a scene that it knows, and accurate enough.
bool pays(const Makeup& made, Real error) {
  if (made.has_tree) return false;
  return made.has_loop || (made.has_solid && !made.has_bounces && error >= kContactError);
}

}  // namespace

bool any_leaves_plane(const std::vector<BuiltEvent>& events) {
  const auto along_z = [](const auto& e) {
    Real most = 0;
    if constexpr (requires { e.force; })
      most = std::max({std::abs(e.force.z), std::abs(e.torque.x), std::abs(e.torque.y)});
    if constexpr (requires { e.impulse; })
      most = std::max(
          {std::abs(e.impulse.z), std::abs(e.angular_impulse.x), std::abs(e.angular_impulse.y)});
    if constexpr (std::is_same_v<std::decay_t<decltype(e)>, WindEvent>)
      most = std::max(std::abs(e.velocity.z), std::abs(e.gusts.z));
    if constexpr (requires { e.gravity; }) most = std::abs(e.gravity.z);
    return most;
  };
  return std::ranges::any_of(
      events, [&](const BuiltEvent& event) { return std::visit(along_z, event.event.kind) > 0; });
}

std::vector<bool> loop_closers(std::uint32_t count,
                               const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) {
  std::vector<bool> closers(count, false);
  DisjointSets joined(count + 1);
  for (auto [a, b] : pairs) {
    a = std::min(a, count), b = std::min(b, count);
    if (a == count && b == count) continue;
    if (joined.root(a) == joined.root(b)) closers[std::min(a, b)] = true;
    joined.join(a, b);
  }
  return closers;
}

Solver cheapest_solver(const BuiltScene& built, Vec3 gravity, Real error) {
  const auto takes = [&](Solver solver) {
    const std::vector<Solver> solvers = solvers_of(built, solver);
    Refusals refusals;
    check_solvers(built, solvers, refusals);
    check_planes(built, solvers, gravity, refusals);
    check_events(built, solvers, refusals);
    return refusals.errors() == 0;
  };
  const bool auto_takes = takes(Solver::articulated);
  const bool is_flat =
      has_planar_solver() && !any_leaves_plane(built.events) && takes(Solver::planar);
  if (is_flat && are_level(built) && pays(makeup_of(built), error)) return Solver::planar;
  if (auto_takes) return Solver::articulated;
  if (is_flat) return Solver::planar;
  return takes(Solver::lagrangian) ? Solver::lagrangian : Solver::articulated;
}

}  // namespace pantin::detail
