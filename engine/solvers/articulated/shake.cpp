#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::articulated {
namespace {

/// The linear answer of every body to the gaps and loads gathered: slide of the own joint point
/// into room.slide, turn into room.turn.
void answer_linearly(Island& a) {
  const Table& w = a.room.work;
  auto tree = a.trees.begin();
  for (std::size_t c = 0; c < a.count(); ++c) {
    const std::int32_t parent = a.parents[c];
    Vec3 y;
    if (parent >= 0) {
      const auto q = static_cast<std::size_t>(parent);
      const Vec3 lever = w.vec(kParentArm, c) - w.vec(kArm, q);
      y = a.room.slide[q] + glm::cross(a.room.turn[q], lever) + w.vec(kGap, c);
    } else {
      const Vec3 own = point_at(a, c, a.constants.vec(kOwnAnchor, c), kPosition, kRotation);
      y = parent == kHeld ? tree->target - own
                          : solve_symmetric(group_mass(a, c), group_load(a, c));
      ++tree;
    }
    const Vec3 d = answer(a, c, y);
    a.room.slide[c] = y;
    a.room.turn[c] = is_finite(d) ? d : Vec3(0);
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

void close_shake(World& world, Island& a, const Packed& p, Real h) {
  const Kernels& k = kernels();
  Table& w = a.room.work;
  for (std::size_t c = 0; c < a.count(); ++c) a.room.loads[c] = h * w.vec(kSpinStar, c);
  for (int newton = 0; newton < 2; ++newton) {
    // Gaps of the poses as they stand, arms and inertias of the step's start.
    k.levers(p, kPosition, kRotation);
    for (std::size_t c = 0; c < a.count(); ++c) {
      a.room.slide[c] = w.vec(kGap, c);
      w.set(kFinalRotation, c, world.bodies.values()[a.slots[c]].pose.rotation);
    }
    k.prepare(p, kPosition, kFinalRotation, false);
    for (std::size_t c = 0; c < a.count(); ++c) w.set(kGap, c, a.room.slide[c]);
    k.fill_blocks(p, a.room.blocks.data());
    k.gather_tree(p, false, a.room.blocks.data());
    answer_linearly(a);
    for (std::size_t c = 0; c < a.count(); ++c) {
      w.set(kPosition, c,
            w.vec(kPosition, c) + a.room.slide[c] - glm::cross(a.room.turn[c], w.vec(kArm, c)));
      a.room.loads[c] += a.room.turn[c];  // rotation vector of the whole step
      const Quat start = world.bodies.values()[a.slots[c]].pose.rotation;
      w.set(kRotation, c, glm::normalize(turn_by(a.room.loads[c]) * start));
    }
  }
  k.levers(p, kPosition, kRotation);
  k.sweep(p, a.room.targets.data(), kPosition, a.settings.turn_stiffness);
  k.commit(p, kRotation);
}

}  // namespace pantin::articulated
