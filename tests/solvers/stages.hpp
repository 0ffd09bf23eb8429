#pragma once
// The adjust stage from given predicted poses, without a step around it.
#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::test {

/// The first articulation of a World whose bodies stand at predicted poses, joints open.
class Stages {
 public:
  explicit Stages(World start, const articulated::Kernels& kernels = articulated::kernels())
      : world(std::move(start)), k_(kernels) {
    compile_if_changed(world);
    articulated::prepare(world);
    articulated::Island& a = articulation();
    for (std::size_t c = 0; c < a.slots.size(); ++c) {
      const Pose& pose = world.bodies.values()[a.slots[c]].pose;
      a.room.work.set(articulated::kPosition, c, pose.position);
      a.room.work.set(articulated::kRotation, c, pose.rotation);
    }
    for (articulated::Tree& t : a.trees) {
      if (t.held_body != UINT32_MAX) t.target = articulated::point_on(world, t.held_body, t.anchor);
      for (int n = 0; n < 3; ++n) a.room.targets.push_back(t.target[n]);
    }
    levers();
  }

  World world;
  articulated::Island& articulation() { return articulated::islands_of(world).front(); }
  articulated::Packed packed() { return articulated::packed(world, articulation()); }

  void levers() { k_.levers(packed(), articulated::kPosition, articulated::kRotation); }
  /// Least displacement, root to leaf.
  void sweep() {
    articulated::Island& a = articulation();
    k_.sweep(packed(), a.room.targets.data(), articulated::kPosition, a.settings.turn_stiffness);
    k_.commit(packed(), articulated::kRotation);
  }
  /// The rule as printed.
  void literal(Real h) { articulated::literal_sweep(articulation(), h); }
  /// Articulated masses up.
  void gather(bool tension) {
    articulated::Island& a = articulation();
    if (a.is_chain) {
      k_.gather_chain(packed(), tension);
      return;
    }
    k_.prepare(packed(), articulated::kPosition, articulated::kRotation, tension);
    k_.fill_blocks(packed(), a.room.blocks.data());
    k_.gather_tree(packed(), tension, a.room.blocks.data());
  }
  /// ... and down again.
  void close() {
    k_.close(packed(), articulation().room.targets.data(), articulated::kPosition);
    k_.commit(packed(), articulated::kRotation);
  }

  /// The linear answer of a free pair to the gap between them, mapped to rotations exactly: what
  /// close() mends to close the joint.
  void answer_linearly(Pose& root, Pose& child) {
    const articulated::Island& a = articulation();
    const articulated::Table& w = a.room.work;
    const Vec3 slide =
        articulated::solve_symmetric(articulated::group_mass(a, 0), articulated::group_load(a, 0));
    const Vec3 turn = articulated::answer(a, 0, slide);
    const Vec3 follow = slide + glm::cross(turn, w.vec(articulated::kParentArm, 1)) + w.vec(articulated::kGap, 1);
    const Vec3 turn_child = articulated::answer(a, 1, follow);
    root = {root.position + slide, glm::normalize(turn_by(turn) * root.rotation)};
    child = {child.position + follow - glm::cross(turn_child, w.vec(articulated::kArm, 1)),
             glm::normalize(turn_by(turn_child) * child.rotation)};
  }

  std::size_t column(Entity body) {
    const articulated::Island& a = articulation();
    std::size_t c = 0;
    while (a.bodies[c] != body) ++c;
    return c;
  }
  Pose predicted(Entity body) {
    const articulated::Table& w = articulation().room.work;
    return {w.vec(articulated::kPosition, column(body)), w.quat(articulated::kRotation, column(body))};
  }
  Pose final(Entity body) {
    const articulated::Table& w = articulation().room.work;
    return {w.vec(articulated::kFinalPosition, column(body)), w.quat(articulated::kFinalRotation, column(body))};
  }

  /// The mass-weighted squared displacement of all material points between the predicted and the
  /// final poses, halved: kg m^2.
  Real action() {
    Real sum = 0;
    for (Entity e : articulation().bodies) {
      const Body& b = world.bodies[e];
      sum += displacement(b.mass, b.inertia, predicted(e), final(e));
    }
    return sum;
  }

  static Real displacement(Real mass, Vec3 inertia, const Pose& from, const Pose& to) {
    const Vec3 d = to.position - from.position;
    const Vec3 j = Vec3((inertia.x + inertia.y + inertia.z) / 2) - inertia;
    const Mat3 r = glm::mat3_cast(glm::conjugate(from.rotation) * to.rotation);
    const Vec3 turned(1 - r[0][0], 1 - r[1][1], 1 - r[2][2]);
    return mass / 2 * glm::dot(d, d) + glm::dot(j, turned);
  }

 private:
  const articulated::Kernels& k_;
};

}  // namespace pantin::test
