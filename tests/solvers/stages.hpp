#pragma once
// The adjust stage from given predicted poses, without a step around it.
#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::test {

using namespace detail;

/// The first island of a World whose bodies stand at predicted poses, joints open.
class Stages {
 public:
  explicit Stages(World start, const articulated::Kernels& kernels = articulated::kernels())
      : world(std::move(start)), k_(kernels) {
    compile_if_changed(world);
    articulated::prepare(world);
    articulated::Island& a = articulation();
    for (std::size_t c = 0; c < a.slots.size(); ++c) {
      const Pose& pose = world.bodies.values()[a.slots[c]].pose;
      a.scratch.work.set(articulated::kPosition, c, pose.position);
      a.scratch.work.set(articulated::kRotation, c, pose.rotation);
    }
    for (articulated::Tree& t : a.trees) {
      if (t.held_body != UINT32_MAX) t.target = articulated::point_on(world, t.held_body, t.anchor);
      for (int n = 0; n < 3; ++n) a.scratch.targets.push_back(t.target[n]);
    }
    levers();
  }

  World world;
  articulated::Island& articulation() { return articulated::islands_of(world)[0]; }
  articulated::IslandView packed() { return articulated::view_of(world, articulation()); }

  void levers() { k_.levers(packed(), articulated::kPosition, articulated::kRotation); }
  /// Least displacement, root to leaf.
  void sweep() {
    articulated::Island& a = articulation();
    k_.sweep(packed(), a.scratch.targets.data(), articulated::kPosition,
             a.settings.rotation_stiffness);
    k_.apply_poses(packed(), articulated::kRotation);
  }
  /// The rule as printed.
  void literal(Real h) { articulated::literal_sweep(articulation(), h); }
  /// Articulated masses, from the leaves to the root.
  void inward_pass() {
    articulated::Island& a = articulation();
    blocks_.assign(articulated::kBlockSize * a.count(), 0);
    k_.prepare(packed(), articulated::kPosition, articulated::kRotation);
    k_.fill_blocks(packed(), blocks_.data());
    k_.inward_pass(packed(), blocks_.data());
  }

  /// The linear answer of a free pair to the gap between them, mapped to rotations exactly: what
  /// close() mends to close the joint.
  void answer_linearly(Pose& root, Pose& child) {
    const articulated::Island& a = articulation();
    const articulated::LaneTable& w = a.scratch.work;
    const Vec3 translation = articulated::solve_symmetric(articulated::articulated_mass(a, 0),
                                                          articulated::articulated_bias(a, 0));
    const Vec3 rotation = articulated::response_rotation(a, 0, translation);
    const Vec3 follow = translation + glm::cross(rotation, w.vec(articulated::kParentArm, 1)) +
                        w.vec(articulated::kGap, 1);
    const Vec3 turn_child = articulated::response_rotation(a, 1, follow);
    root = {root.position + translation,
            glm::normalize(from_rotation_vector(rotation) * root.rotation)};
    child = {child.position + follow - glm::cross(turn_child, w.vec(articulated::kArm, 1)),
             glm::normalize(from_rotation_vector(turn_child) * child.rotation)};
  }

  std::size_t column(Entity body) {
    const articulated::Island& a = articulation();
    std::size_t c = 0;
    while (a.bodies[c] != body) ++c;
    return c;
  }
  Pose predicted(Entity body) {
    const articulated::LaneTable& w = articulation().scratch.work;
    return {w.vec(articulated::kPosition, column(body)),
            w.quat(articulated::kRotation, column(body))};
  }
  Pose final(Entity body) {
    const articulated::LaneTable& w = articulation().scratch.work;
    return {w.vec(articulated::kFinalPosition, column(body)),
            w.quat(articulated::kFinalRotation, column(body))};
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
    const Vec3 rotated(1 - r[0][0], 1 - r[1][1], 1 - r[2][2]);
    return mass / 2 * glm::dot(d, d) + glm::dot(j, rotated);
  }

 private:
  const articulated::Kernels& k_;
  std::vector<Real> blocks_;
};

}  // namespace pantin::test
