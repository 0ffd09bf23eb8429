#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// The linear response of every body to gaps and forces: translation of the own joint point and
/// rotation.
void linear_response(Island& a) {
  const LaneTable& w = a.scratch.work;
  auto tree = a.trees.begin();
  for (std::size_t c = 0; c < a.count(); ++c) {
    const std::int32_t parent = a.parents[c];
    Vec3 y;
    if (parent >= 0) {
      const auto q = static_cast<std::size_t>(parent);
      const Vec3 lever = w.vec(kParentArm, c) - w.vec(kArm, q);
      y = a.scratch.translation[q] + glm::cross(a.scratch.rotation[q], lever) + w.vec(kGap, c);
    } else {
      const Vec3 own = point_at(a, c, a.constants.vec(kOwnAnchor, c), kPredictedPoses);
      y = parent == kHeld ? tree->target - own
                          : solve_symmetric(articulated_mass(a, c), articulated_bias(a, c));
      ++tree;
    }
    const Vec3 d = response_rotation(a, c, y);
    a.scratch.translation[c] = y;
    a.scratch.rotation[c] = is_finite(d) ? d : Vec3(0);
  }
}

}  // namespace

Vec3 solve_symmetric(const Mat3& m, Vec3 b) {
  const Real floor = 4 * 2.220446049250313e-16 * (m[0][0] + m[1][1] + m[2][2]);
  const Real d0 = std::max(m[0][0], floor), l10 = m[0][1] / d0, l20 = m[0][2] / d0;
  const Real d1 = std::max(m[1][1] - l10 * m[0][1], floor), t = m[1][2] - l20 * m[0][1];
  const Real l21 = t / d1, d2 = std::max(m[2][2] - l20 * m[0][2] - l21 * t, floor);
  const Real y1 = b.y - l10 * b.x, y2 = b.z - l20 * b.x - l21 * y1;
  const Real z = y2 / d2, y = y1 / d1 - l21 * z;
  return {b.x / d0 - l10 * y - l20 * z, y, z};
}

void close_shake(World& world, Island& a, const IslandView& p, Real h) {
  const Kernels& k = kernels();
  LaneTable& w = a.scratch.work;
  for (std::size_t c = 0; c < a.count(); ++c)
    a.scratch.turned[c] = h * w.vec(kAngularVelocityStar, c);
  for (int newton = 0; newton < 2; ++newton) {
    // Gaps at the current poses, arms and inertias at the start of the step.
    k.levers(p, kPosition, kRotation);
    for (std::size_t c = 0; c < a.count(); ++c) {
      a.scratch.translation[c] = w.vec(kGap, c);
      w.set(kFinalRotation, c, world.bodies.values()[a.slots[c]].pose.rotation);
    }
    k.prepare(p, kPosition, kFinalRotation);
    for (std::size_t c = 0; c < a.count(); ++c) w.set(kGap, c, a.scratch.translation[c]);
    k.fill_blocks(p, a.scratch.blocks.data());
    k.inward_pass(p, a.scratch.blocks.data());
    linear_response(a);
    for (std::size_t c = 0; c < a.count(); ++c) {
      w.set(kPosition, c,
            w.vec(kPosition, c) + a.scratch.translation[c] -
                glm::cross(a.scratch.rotation[c], w.vec(kArm, c)));
      a.scratch.turned[c] += a.scratch.rotation[c];  // rotation vector of the whole step
      const Quat start = world.bodies.values()[a.slots[c]].pose.rotation;
      w.set(kRotation, c, glm::normalize(from_rotation_vector(a.scratch.turned[c]) * start));
    }
  }
  k.levers(p, kPosition, kRotation);
  k.sweep(p, a.scratch.targets.data(), kPosition, a.settings.rotation_stiffness);
  k.apply_poses(p, kRotation);
}

}  // namespace pantin::detail::articulated
