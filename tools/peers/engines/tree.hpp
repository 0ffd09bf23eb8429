#pragma once
/// A spelt-out scene as a tree of bodies that hang on joints, and the points that close its loops:
/// for engines in minimal coordinates.
#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>

#include "tools/peers/engines/engine.hpp"

namespace pantin::peers {

struct Placed {
  Eigen::Vector3d position;
  Eigen::Quaterniond rotation;
  Eigen::Vector3d point(const Three& local) const {
    return position + rotation * Eigen::Vector3d(local[0], local[1], local[2]);
  }
  Eigen::Vector3d local(const Eigen::Vector3d& point) const {
    return rotation.conjugate() * (point - position);
  }
};

/// At the start; the world is at the origin.
inline Placed placed(const Spelt& scene, int body) {
  if (body < 0) return {Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity()};
  const SpeltPose& at = scene.bodies[static_cast<std::size_t>(body)].at;
  return {{at.position[0], at.position[1], at.position[2]},
          {at.rotation[3], at.rotation[0], at.rotation[1], at.rotation[2]}};
}

/// A body on a joint; all places are those of the start, in world axes.
struct Limb {
  int body, parent;  // parent: a body, or -1 for the world and for the body that is led
  bool is_hinge;
  Eigen::Vector3d anchor, axis;  // axis: of a hinge
};

/// Two bodies that keep a point together.
struct Closure {
  int a, b;  // -1: the world
  Eigen::Vector3d point;
};

struct Tree {
  std::vector<Limb> limbs;  // parents first
  std::vector<Closure> closures;
  int led = -1;  // the body that moves on a path, if any: all that hangs on the world hangs on it
};

inline Eigen::Vector3d axis_of(const Spelt& scene, const SpeltJoint& j) {
  const Eigen::Quaterniond axes(j.axes_a[3], j.axes_a[0], j.axes_a[1], j.axes_a[2]);
  return placed(scene, j.a).rotation * (axes * Eigen::Vector3d::UnitX());
}

enum class Loops { planar, spatial };

/// One point closes a loop of balls, or of hinges that are all parallel; else a hinge has two.
inline void close_loop(const Spelt& scene, const SpeltJoint& j, Loops loops, Tree& tree) {
  const Eigen::Vector3d anchor = placed(scene, j.a).point(j.anchor_a);
  if (j.kind == "ball" || loops == Loops::planar) {
    tree.closures.push_back({j.a, j.b, anchor});
    return;
  }
  constexpr double kHalf = 0.1;  // m
  for (const double side : {-kHalf, kHalf})
    tree.closures.push_back({j.a, j.b, anchor + side * axis_of(scene, j)});
}

inline Tree tree_of(const Spelt& scene) {
  Tree tree;
  const int count = static_cast<int>(scene.bodies.size());
  std::vector<bool> is_held(scene.bodies.size(), false);
  for (int i = 0; i < count; ++i)
    if (!scene.bodies[static_cast<std::size_t>(i)].path.empty())
      tree.led = i, is_held[static_cast<std::size_t>(i)] = true;
  const auto held = [&](int body) { return body < 0 || is_held[static_cast<std::size_t>(body)]; };
  const auto base = [&](int body) { return body == tree.led ? -1 : body; };
  bool is_planar = true;
  const Eigen::Vector3d first =
      scene.joints.empty() ? Eigen::Vector3d::Zero() : axis_of(scene, scene.joints[0]);
  for (const SpeltJoint& j : scene.joints)
    is_planar = is_planar && j.kind == "hinge" && axis_of(scene, j).cross(first).norm() < 1e-9;
  std::vector<const SpeltJoint*> left;
  for (const SpeltJoint& j : scene.joints) left.push_back(&j);
  while (!left.empty()) {
    const auto next = std::find_if(left.begin(), left.end(),
                                   [&](const SpeltJoint* j) { return held(j->a) || held(j->b); });
    if (next == left.end()) throw std::runtime_error("a body hangs on nothing");
    const SpeltJoint& j = **next;
    left.erase(next);
    if (held(j.a) && held(j.b)) {
      close_loop(scene, j, is_planar ? Loops::planar : Loops::spatial, tree);
      continue;
    }
    const int body = held(j.a) ? j.b : j.a, parent = held(j.a) ? j.a : j.b;
    is_held[static_cast<std::size_t>(body)] = true;
    tree.limbs.push_back({body, base(parent), j.kind == "hinge",
                          placed(scene, j.a).point(j.anchor_a), axis_of(scene, j)});
  }
  return tree;
}

inline void put(Moving& to, const Eigen::Vector3d& position) {
  for (int k = 0; k < 3; ++k) to.position[k] = position[k];
}

}  // namespace pantin::peers
