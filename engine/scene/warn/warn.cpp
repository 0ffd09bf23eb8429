#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "engine/joints/kinds.hpp"
#include "engine/scene/build/build.hpp"
#include "engine/scene/build/cable_route.hpp"
#include "engine/world/faults.hpp"
#include "engine/world/solver_list.hpp"

namespace pantin::detail {
namespace {

constexpr Real kHeavy = 100;          // mass ratio across a joint that causes a warning
constexpr Real kOpen = 1e-6;          // m, initial gap of a joint
constexpr std::size_t kMostHeld = 8;  // points of one tree that are compared with all others

std::string quoted(const std::string& name) { return "\"" + name + "\""; }

/// By body: whether its solver closes loops of any kind of joint exactly.
struct Exact {
  const BuiltScene& built;
  const std::vector<Solver>& solvers;
  bool has(std::uint32_t body) const {
    return built.is_dynamic(body) && info_of(solvers[body]).closes_loops;
  }
  bool has(const BuiltJoint& joint) const { return has(joint.a) || has(joint.b); }
};

/// The initial gap of a joint: how far the anchors violate its kind, m.
Real gap_of(const BuiltJoint& j, const Pose& a, const Pose& b) {
  return info_of(j.joint.kind).gap(j.joint, a, b);
}

void warn_of_joints(const BuiltScene& built, const Exact& exact, BuildMessages& messages) {
  for (const BuiltJoint& j : built.joints) {
    const Real gap = gap_of(j, built.pose_of(j.a), built.pose_of(j.b));
    if (gap > kOpen)
      messages.warn(j.at, "gap",
                    "joint " + quoted(j.name) + " starts " + written(gap) +
                        " m open; the first step closes it");
    if (!built.is_dynamic(j.a) || !built.is_dynamic(j.b) || exact.has(j)) continue;
    const BuiltBody *a = &built.bodies[j.a], *b = &built.bodies[j.b];
    if (a->body.mass < b->body.mass) std::swap(a, b);
    const Real ratio = a->body.mass / b->body.mass;
    if (ratio > kHeavy)
      messages.warn(j.at, "ratio",
                    "joint " + quoted(j.name) + " has a mass ratio of " + written(ratio) + ":1 (" +
                        a->name + " " + written(a->body.mass) + " kg, " + b->name + " " +
                        written(b->body.mass) + " kg); above 100:1 the motion is less accurate");
  }
}

/// Sets of dynamic bodies that joints connect.
class Trees {
 public:
  explicit Trees(std::size_t count) : parent_(count), is_held_(count, false) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  /// Returns false if both are in one tree already.
  bool join(std::uint32_t a, std::uint32_t b) {
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }
  /// Returns false if the body's tree is held already. Call it after all joins.
  bool hold(std::uint32_t body) {
    const std::uint32_t tree = root(body);
    const bool is_first = !is_held_[tree];
    is_held_[tree] = true;
    return is_first;
  }

 private:
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  std::vector<std::uint32_t> parent_;
  std::vector<bool> is_held_;
};

/// Under the sweeps, joints that close a loop or anchor a tree again constrain their point only.
/// "auto" passes such joints to "lagrangian" if they would lose constraints.
void warn_of_loops(const BuiltScene& built, const Exact& exact, BuildMessages& messages) {
  Trees trees(built.bodies.size());
  std::vector<std::pair<std::uint32_t, const BuiltJoint*>> holds;  // by body
  const auto warn = [&](const BuiltJoint& j, const char* does) {
    const bool turns = info_of(j.joint.kind).uses_axes || j.joint.limits.any() || j.drive;
    if (turns)
      messages.warn(
          j.at, "loop",
          "joint " + quoted(j.name) + " " + does +
              ", so this solver constrains only its point, not its kind, limits or drive");
  };
  for (const BuiltJoint& j : built.joints) {
    const std::uint32_t mover = built.is_dynamic(j.a) ? j.a : j.b;
    if (exact.has(j) || exact.solvers[mover] == Solver::articulated) continue;
    const bool a = built.is_dynamic(j.a), b = built.is_dynamic(j.b);
    if (a && b && !trees.join(j.a, j.b)) warn(j, "closes a loop of dynamic bodies");
    if (a != b) holds.emplace_back(a ? j.a : j.b, &j);
  }
  std::stable_sort(holds.begin(), holds.end(),
                   [](const auto& x, const auto& y) { return x.first < y.first; });
  for (const auto& [body, joint] : holds)
    if (!trees.hold(body)) warn(*joint, "fixes a body that another joint already fixes");
}

/// Warns of joints that start beyond their limits.
void warn_of_turns(const BuiltScene& built, BuildMessages& messages) {
  constexpr Real kBeyond = 1e-6;  // rad
  for (const BuiltJoint& j : built.joints) {
    const Quat start =
        relative_rotation(j.joint, built.pose_of(j.a).rotation, built.pose_of(j.b).rotation);
    const Real beyond = violation(j.joint, start);
    if (beyond > kBeyond)
      messages.warn(
          j.at, "turn",
          "joint " + quoted(j.name) + " starts " + written(beyond * 180 / kPi) +
              " degrees beyond what its kind and limits allow; it will jump into that range");
  }
}

/// Warns of features that a solver ignores but that do not prevent a run: one line each.
void warn_of_unknown(const BuiltScene& built, const Exact& exact, Solver solver,
                     BuildMessages& messages) {
  const std::string who =
      std::string("but the solver \"") + name_of(solver) + "\" does not support ";
  std::size_t solid = 0;
  const BuiltBody* first = nullptr;
  for (std::uint32_t i = 0; i < built.bodies.size(); ++i)
    if (built.bodies[i].collision && !built.bodies[i].collision->sensor && built.is_dynamic(i) &&
        exact.solvers[i] == solver && solid++ == 0)
      first = &built.bodies[i];
  if (solid > 0 && !knows(solver, Feature::contact))
    messages.warn(first->at, "contact",
                  "body " + quoted(first->name) +
                      (solid > 1 ? " and " + std::to_string(solid - 1) + " more are" : " is") +
                      " solid, " + who +
                      "impacts, or contacts with bodies of its own or of \"auto\"; it is only "
                      "pushed out of others");
  for (const BuiltJoint& j : built.joints) {
    const std::uint32_t mover = built.is_dynamic(j.a) ? j.a : j.b;
    if (j.joint.limits->soft_zone > 0 && built.is_dynamic(mover) &&
        exact.solvers[mover] == solver && !knows(solver, Feature::soft_stop))
      messages.warn(j.at, "soft",
                    "joint " + quoted(j.name) + " has a soft stop, " + who +
                        (info_of(solver).closes_loops ? "them yet; " : "them; ") +
                        "the stop is hard");
  }
}

void warn_of_strings(const BuiltScene& built, BuildMessages& messages) {
  for (const BuiltCable& s : built.cables) {
    const Real over =
        s.guides.empty()
            ? stretch(s.joint, built.pose_of(s.a), built.pose_of(s.b))
            : std::max(Real(0), path_length(route_of(built, s), {}).length - s.joint.length);
    if (over > kOpen)
      messages.warn(s.at, "short",
                    "cable " + quoted(s.name) + " of " + written(s.joint.length) + " m starts " +
                        written(over) + " m too short; its initial pull is large");
  }
}

/// A point of a dynamic body at a fixed position: by an exact pin, or by a joint to a body that
/// joints cannot move.
struct Held {
  std::uint32_t body;
  Vec3 anchor, target;
  int priority;
  ElementId at;
  std::string name;
};

struct Edge {
  std::uint32_t body;
  Vec3 exit, entry;  // anchors in this body and in the other
};

/// The path through the joints from one held point to each body of its tree.
struct Way {
  bool is_known = false;
  Vec3 entry{0};
  Real length = 0, longest = 0;  // of the segments up to `entry`
};

class Reach {
 public:
  explicit Reach(const BuiltScene& built)
      : assembly_(built), edges_(built.bodies.size()), held_(built.bodies.size()) {
    for (const BuiltJoint& j : built.joints) {
      if (!holds_point(j.joint.kind)) continue;  // a path across it has no fixed length
      const bool a = built.is_dynamic(j.a), b = built.is_dynamic(j.b);
      if (a && b) {
        edges_[j.a].push_back({j.b, j.joint.anchor_a, j.joint.anchor_b});
        edges_[j.b].push_back({j.a, j.joint.anchor_b, j.joint.anchor_a});
      } else if (a) {
        hold({j.a, j.joint.anchor_a, to_world(built.pose_of(j.b), j.joint.anchor_b), 0, j.at,
              "joint " + quoted(j.name)});
      } else {
        hold({j.b, j.joint.anchor_b, to_world(built.pose_of(j.a), j.joint.anchor_a), 0, j.at,
              "joint " + quoted(j.name)});
      }
    }
    for (const BuiltPin& p : built.pins)
      if (p.pin.kind == PinKind::exact && !built.is_dynamic(p.to))
        hold({p.body, p.pin.anchor, to_world(built.pose_of(p.to), p.pin.target), p.pin.priority,
              p.at, "pin " + quoted(p.name)});
  }

  void warn(BuildMessages& messages) {
    std::vector<bool> seen(assembly_.bodies.size(), false);
    for (std::uint32_t start = 0; start < held_.size(); ++start) {
      if (seen[start] || held_[start].empty()) continue;
      std::vector<const Held*> all;
      for (std::uint32_t body : tree_of(start)) {
        seen[body] = true;
        for (std::size_t h : held_[body]) all.push_back(&list_[h]);
      }
      std::stable_sort(all.begin(), all.end(),
                       [](const Held* a, const Held* b) { return a->priority > b->priority; });
      for (std::size_t i = 0; i < std::min(all.size(), kMostHeld); ++i) compare(all, i, messages);
    }
  }

 private:
  void hold(Held held) {
    held_[held.body].push_back(list_.size());
    list_.push_back(std::move(held));
  }

  std::vector<std::uint32_t> tree_of(std::uint32_t start) {
    std::vector<std::uint32_t> order{start};
    std::vector<Way>& ways = ways_;
    ways.resize(assembly_.bodies.size());
    ways[start].is_known = true;
    for (std::size_t i = 0; i < order.size(); ++i)
      for (const Edge& e : edges_[order[i]])
        if (!ways[e.body].is_known) ways[e.body].is_known = true, order.push_back(e.body);
    for (std::uint32_t body : order) ways[body] = {};
    return order;
  }

  /// Compares held point `i` with those after it.
  void compare(const std::vector<const Held*>& all, std::size_t i, BuildMessages& messages) {
    if (i + 1 == all.size()) return;
    const Held& from = *all[i];
    std::vector<std::uint32_t> order{from.body};
    ways_[from.body] = {true, from.anchor, 0, 0};
    for (std::size_t k = 0; k < order.size(); ++k) {
      const Way way = ways_[order[k]];
      for (const Edge& e : edges_[order[k]]) {
        if (ways_[e.body].is_known) continue;
        const Real part = glm::length(e.exit - way.entry);
        ways_[e.body] = {true, e.entry, way.length + part, std::max(way.longest, part)};
        order.push_back(e.body);
      }
    }
    for (std::size_t k = i + 1; k < all.size(); ++k) judge(from, *all[k], messages);
    for (std::uint32_t body : order) ways_[body] = {};
  }

  void judge(const Held& from, const Held& to, BuildMessages& messages) const {
    const Way& way = ways_[to.body];
    const Real last = glm::length(to.anchor - way.entry);
    const Real reach = way.length + last, longest = std::max(way.longest, last);
    const Real least = std::max(Real(0), 2 * longest - reach);
    const Real distance = glm::length(to.target - from.target);
    const std::string where = to.name + " is held " + written(distance) + " m from " + from.name +
                              ", but the linkage between them ";
    if (distance > reach + kOpen)
      messages.warn(to.at, "reach",
                    where + "reaches only " + written(reach) + " m; it stays out of reach");
    else if (distance < least - kOpen)
      messages.warn(to.at, "reach",
                    where + "cannot fold below " + written(least) + " m; it stays out of reach");
  }

  const BuiltScene& assembly_;
  std::vector<std::vector<Edge>> edges_;
  std::vector<Held> list_;
  std::vector<std::vector<std::size_t>> held_;  // by body, into list_
  std::vector<Way> ways_;
};

}  // namespace

void warn_of_structure(const BuiltScene& built, const std::vector<Solver>& solvers,
                       BuildMessages& messages) {
  const Exact exact{built, solvers};
  warn_of_joints(built, exact, messages);
  warn_of_loops(built, exact, messages);
  for (const SolverInfo& by : kSolverInfos) warn_of_unknown(built, exact, by.solver, messages);
  warn_of_turns(built, messages);
  warn_of_strings(built, messages);
  Reach(built).warn(messages);
}

}  // namespace pantin::detail
