// The cheapest models for the groups of bodies of a scene that accepts an error.
#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "engine/base/disjoint_sets.hpp"
#include "engine/geometry/convex.hpp"
#include "engine/scene/build/build.hpp"
#include "engine/world/features.hpp"
#include "engine/world/flat.hpp"
#include "engine/world/partition.hpp"
#include "engine/world/timed_event.hpp"

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

/// The heights z at which all bodies that were added have a section in the plane: round shapes at
/// their centres, prisms anywhere.
struct Heights {
  Real bottom = -std::numeric_limits<Real>::infinity(), top = -bottom;  // m

  void add(const World& world, Entity e) {
    constexpr Real kSame = 1e-6;  // m
    const Shapes* shapes = world.shapes.find(e);
    if (!shapes) return;
    Real low = std::numeric_limits<Real>::infinity(), high = -low;
    for (const Shape& shape : shapes->list) {
      if (shape.kind == ShapeKind::plane) continue;
      const Pose at = compose(world.bodies[e].pose, shape.local);
      const bool is_prism = shape.kind == ShapeKind::box || shape.kind == ShapeKind::cylinder ||
                            shape.kind == ShapeKind::hull;
      const Aabb box = bounds_of(shape, at);
      low = std::min(low, is_prism ? box.low.z : at.position.z - kSame);
      high = std::max(high, is_prism ? box.high.z : at.position.z + kSame);
    }
    if (low > high) return;
    bottom = std::max(bottom, low), top = std::min(top, high);
  }
  bool are_level() const { return bottom <= top; }
};

/// Bodies that no other group's bodies can meet, and what they consist of.
struct Group {
  std::vector<std::uint32_t> slots;
  bool has_tree = false;     // of two bodies or more, and no loop
  bool is_hung = false;      // a body on a joint of its own
  bool has_loop = false;     // or what "auto" leaves to "lagrangian"
  bool has_solid = false;    // a body that collides
  bool has_bounces = false;  // restitution, its own or of bodies that it may hit
  bool has_own = false;      // solver settings of its own
  Entity beyond;             // what neither "auto" nor "lagrangian" supports
  Heights heights;
  std::string leaves_plane;  // why, a clause
  Solver solver = Solver::articulated;
  std::string why;

  bool is_flat() const { return leaves_plane.empty() && (!has_solid || heights.are_level()); }
  /// Whether "planar" is the cheaper model, and accurate enough.
  bool pays(Real error) const {
    const bool contacts_fit = !has_solid || (!has_bounces && error >= kContactError);
    return !has_tree && contacts_fit && (has_loop || has_solid);
  }
  /// Whether both solvers do the same.
  bool is_free() const { return !has_tree && !is_hung && !has_loop && !has_solid; }
};

/// Why an event cannot be had in the plane, as a clause, or empty.
std::string fault_in_plane(const World& world, const TimedEvent& event) {
  constexpr Real kSame = 1e-6;  // m
  const char* const leaves = "is driven out of the xy plane by an event";
  return std::visit(
      [&](const auto& e) -> std::string {
        if constexpr (std::is_same_v<std::decay_t<decltype(e)>, PullEvent>) {
          const Body* b = world.bodies.find(e.body);
          if (!b) return "";
          if (e.stiffness > 0) return "is pulled by a spring, which planar does not support";
          const Real apart = e.target.z - to_world(b->pose, e.anchor).z;
          return std::abs(apart) > kSame ? leaves : "";
        }
        Real most = 0;
        if constexpr (requires { e.force; })
          most = std::max({std::abs(e.force.z), std::abs(e.torque.x), std::abs(e.torque.y)});
        if constexpr (requires { e.impulse; })
          most = std::max({std::abs(e.impulse.z), std::abs(e.angular_impulse.x),
                           std::abs(e.angular_impulse.y)});
        if constexpr (std::is_same_v<std::decay_t<decltype(e)>, WindEvent>)
          most = std::max(std::abs(e.velocity.z), std::abs(e.gusts.z));
        if constexpr (requires { e.gravity; }) most = std::abs(e.gravity.z);
        return most > 0 ? leaves : "";
      },
      event.kind);
}

class Chooser {
 public:
  Chooser(const World& world, Real error)
      : world_(world),
        error_(error),
        count_(static_cast<std::uint32_t>(world.bodies.size())),
        islands_(find_islands(world)),
        joined_(count_) {}

  std::vector<ModelChoice> choose();

 private:
  bool is_dynamic(std::uint32_t slot) const {
    return slot < count_ && world_.bodies.values()[slot].motion == Motion::dynamic;
  }
  const Collision* collision_of(std::uint32_t slot) const {
    const Collision* c = world_.collisions.find(world_.bodies.owners()[slot]);
    return c && !c->sensor ? c : nullptr;
  }
  Group* group_of(Entity body) {
    const std::uint32_t slot = world_.bodies.slot(body);
    return is_dynamic(slot) ? &groups_[place_[joined_.root(slot)]] : nullptr;
  }
  void join_colliders();
  void list_groups();
  void note_colliders();
  void note_joints();
  void note_islands(const std::vector<bool>& closers, const std::vector<bool>& has_joint);
  void note_events();
  void note_unsupported();
  void decide(Group& group) const;

  const World& world_;
  Real error_;
  std::uint32_t count_;
  std::vector<IslandPlan> islands_;
  DisjointSets joined_;
  std::vector<std::size_t> place_;  // of groups, by the root of their slots
  std::vector<Group> groups_;
};

/// Bodies that collide can meet wherever they start. Those with equal filters are joined at once.
void Chooser::join_colliders() {
  struct Filter {
    std::uint32_t groups, with;
    bool others;
    std::uint32_t first;  // slot
    std::vector<std::uint32_t> slots;
  };
  std::vector<Filter> filters;
  for (std::uint32_t slot = 0; slot < count_; ++slot) {
    const Collision* c = is_dynamic(slot) ? collision_of(slot) : nullptr;
    if (!c) continue;
    auto at = std::ranges::find_if(filters, [&](const Filter& f) {
      return f.groups == c->groups && f.with == c->with && f.others == c->others;
    });
    if (at == filters.end())
      at = filters.insert(filters.end(), {c->groups, c->with, c->others, slot, {}});
    at->slots.push_back(slot);
  }
  for (const Filter& a : filters)
    for (const Filter& b : filters) {
      if (!(a.groups & b.with) || !(b.groups & a.with) || !(a.others || b.others)) continue;
      for (const std::uint32_t slot : b.slots) joined_.join(a.first, slot);
    }
}

void Chooser::list_groups() {
  place_.assign(count_, SIZE_MAX);
  for (const IslandPlan& island : islands_) {
    std::size_t& place = place_[joined_.root(island.slots.front())];
    if (place == SIZE_MAX) place = groups_.size(), groups_.emplace_back();
    Group& group = groups_[place];
    group.slots.insert(group.slots.end(), island.slots.begin(), island.slots.end());
  }
  for (Group& g : groups_) std::ranges::sort(g.slots);
}

void Chooser::note_colliders() {
  Heights fixed;
  bool has_bounces = false;
  for (std::uint32_t slot = 0; slot < count_; ++slot) {
    const Collision* c = collision_of(slot);
    if (!c || is_dynamic(slot)) continue;
    fixed.add(world_, world_.bodies.owners()[slot]);
    has_bounces = has_bounces || c->restitution > 0;
  }
  for (Group& g : groups_) {
    g.heights = fixed, g.has_bounces = has_bounces;
    for (const std::uint32_t slot : g.slots) {
      const Entity e = world_.bodies.owners()[slot];
      g.has_own = g.has_own || world_.settings.find(e);
      const Collision* c = collision_of(slot);
      if (!c) continue;
      g.has_solid = true, g.has_bounces = g.has_bounces || c->restitution > 0;
      g.heights.add(world_, e);
    }
  }
}

/// Finds joints and the loops that they close.
void Chooser::note_joints() {
  std::vector<bool> has_joint(count_, false);
  const auto place_of = [&](Entity body) {
    const std::uint32_t slot = world_.bodies.slot(body);
    if (!is_dynamic(slot)) return count_;
    has_joint[slot] = true;
    return slot;
  };
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const Link& l : world_.links.values()) pairs.emplace_back(place_of(l.a), place_of(l.b));
  note_islands(loop_closers(count_, pairs), has_joint);
}

void Chooser::note_islands(const std::vector<bool>& closers, const std::vector<bool>& has_joint) {
  const std::vector<std::string> faults = plane_faults(world_, islands_);
  for (std::size_t i = 0; i < islands_.size(); ++i) {
    const std::vector<std::uint32_t>& slots = islands_[i].slots;
    Group& group = *group_of(world_.bodies.owners()[slots.front()]);
    const auto any = [&](const std::vector<bool>& of) {
      return std::ranges::any_of(slots, [&](std::uint32_t slot) { return of[slot]; });
    };
    const bool loops = bool(islands_[i].beyond) || any(closers);
    group.has_loop = group.has_loop || loops;
    group.has_tree = group.has_tree || (!loops && slots.size() > 1);
    group.is_hung = group.is_hung || (!loops && any(has_joint));
    if (group.leaves_plane.empty()) group.leaves_plane = faults[i];
  }
}

void Chooser::note_events() {
  const auto* events = events_of(world_);
  if (!events) return;
  for (const TimedEvent& event : events->values()) {
    const std::string why = fault_in_plane(world_, event);
    if (why.empty()) continue;
    const auto push = [&](Group& g) {
      if (g.leaves_plane.empty()) g.leaves_plane = why;
    };
    const auto note = [&](const auto& e) {
      bool is_of_all = true;
      if constexpr (requires { e.bodies; }) {
        is_of_all = e.bodies.empty();
        for (const Entity body : e.bodies)
          if (Group* g = group_of(body)) push(*g);
      } else if constexpr (requires { e.body; }) {
        is_of_all = false;
        if (Group* g = group_of(e.body)) push(*g);
      }
      if (is_of_all) std::ranges::for_each(groups_, push);
    };
    std::visit(note, event.kind);
  }
}

void Chooser::note_unsupported() {
  each_feature(world_, Scope::all(world_),
               [&](Entity owner, std::span<const Entity> bodies, Feature what, const char*) {
                 if (knows(solver_for(Solver::articulated, what), what)) return;
                 for (const Entity body : bodies)
                   if (Group* g = group_of(body); g && !g->beyond) g->beyond = owner;
               });
}

void Chooser::decide(Group& g) const {
  const bool is_flat = has_planar_solver() && g.is_flat();
  if (is_flat && (g.pays(error_) || g.beyond)) {
    g.solver = Solver::planar;
    g.why = !g.pays(error_) ? "in the xy plane, with what \"auto\" does not support"
            : g.has_loop    ? "it has a loop, or a joint that \"auto\" leaves to \"lagrangian\", "
                              "and stays in the xy plane"
                            : "free bodies that collide and stay in the xy plane";
    return;
  }
  if (!g.leaves_plane.empty())
    g.why = "it " + g.leaves_plane;
  else if (g.has_solid && !g.heights.are_level())
    g.why = "its bodies, and what they may hit, do not collide at one height z";
  else if (g.has_tree)
    g.why = "it has a tree of joints, which costs less than in \"planar\"";
  else if (g.has_solid)
    g.why = g.has_bounces ? "it bounces, which \"planar\" does less accurately"
                          : "it collides, and \"planar\" is accurate to 0.01 only";
  else
    g.why = g.is_hung ? "bodies on a joint of their own, which cost less than in \"planar\""
                      : "free bodies, which cost the same in any solver";
}

std::vector<ModelChoice> Chooser::choose() {
  for (const IslandPlan& island : islands_)
    for (const std::uint32_t slot : island.slots) joined_.join(island.slots.front(), slot);
  join_colliders();
  list_groups(), note_colliders(), note_joints(), note_events(), note_unsupported();
  std::erase_if(groups_, [](const Group& g) { return g.has_own; });
  for (Group& g : groups_) decide(g);
  // What both do alike goes with the others, so that the scene has one solver.
  const auto is_planar = [](const Group& g) { return g.solver == Solver::planar; };
  if (std::ranges::all_of(
          groups_, [&](const Group& g) { return is_planar(g) || (g.is_free() && g.is_flat()); }) &&
      std::ranges::any_of(groups_, is_planar))
    for (Group& g : groups_)
      if (!is_planar(g)) g.solver = Solver::planar, g.why += ": as the rest of the scene";
  std::vector<ModelChoice> choices;
  for (Group& g : groups_) choices.push_back({std::move(g.slots), g.solver, std::move(g.why)});
  return choices;
}

}  // namespace

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

std::vector<ModelChoice> choose_models(const World& world, Real error) {
  return Chooser(world, error).choose();
}

void withdraw_refused(const BuiltScene& built, Vec3 gravity, std::vector<ModelChoice>& choices) {
  std::vector<Solver> solvers = solvers_of(built, Solver::articulated);
  const auto refusals = [&] {
    Refusals found;
    check_solvers(built, solvers, found), check_planes(built, solvers, gravity, found);
    check_events(built, solvers, found);
    return found.errors();
  };
  const std::size_t before = refusals();
  for (const ModelChoice& c : choices)
    for (const std::uint32_t slot : c.slots)
      if (c.solver == Solver::planar && slot < solvers.size()) solvers[slot] = c.solver;
  if (refusals() <= before) return;
  for (ModelChoice& c : choices)
    if (c.solver == Solver::planar)
      c.solver = Solver::articulated, c.why = "\"planar\" does not support all of this scene";
}

Solver give_models(const std::vector<ModelChoice>& choices, const SolverSettings& planar,
                   BuiltScene& built) {
  const auto is_planar = [](const ModelChoice& c) { return c.solver == Solver::planar; };
  std::size_t chosen = 0, all = 0;
  for (const ModelChoice& c : choices) chosen += c.slots.size();
  for (const BuiltBody& b : built.bodies) all += b.body.motion == Motion::dynamic;
  if (chosen > 0 && chosen == all && std::ranges::all_of(choices, is_planar)) return Solver::planar;
  for (const ModelChoice& c : choices)
    for (const std::uint32_t slot : c.slots)
      if (is_planar(c) && slot < built.bodies.size()) built.bodies[slot].solver = &planar;
  return Solver::articulated;
}

}  // namespace pantin::detail
