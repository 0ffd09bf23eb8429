// The rows of joints that constrain rotations, in the energy-momentum method; small inverses.
#include <algorithm>

#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/smooth/conserving_joints.hpp"

namespace pantin::detail::articulated {
namespace {

/// One row: axis p of body a and axis s of body b stay perpendicular.
struct RowAxes {
  int p, s;
};
constexpr RowAxes kHingeRows[] = {{1, 0}, {2, 0}}, kUniversalRows[] = {{1, 2}},
                  kFixedRows[] = {{1, 0}, {2, 0}, {1, 2}};

std::span<const RowAxes> rows_of(JointKind kind) {
  switch (turns_of(kind)) {
    case Turns::about_x:
      return kHingeRows;
    case Turns::about_two:
      return kUniversalRows;
    case Turns::nowhere:
      return kFixedRows;
    case Turns::freely:
    case Turns::own:  // does not occur here
      break;
  }
  return {};
}

}  // namespace

JointRows find_rows(const PackedJoint& j, const Directions& d, Unknown unknown) {
  JointRows rows;
  const Real sign = j.own_is_a ? -1 : 1;
  for (const RowAxes& axes : rows_of(j.joint.kind)) {
    const Vec3 p = d.a1[axes.p], s = d.b1[axes.s];
    const Vec3 mean_p = 0.5 * (d.a0[axes.p] + p), mean_s = 0.5 * (d.b0[axes.s] + s);
    PANTIN_ASSERT(rows.count < 3);
    const std::size_t n = rows.count++;
    rows.gradient[n] = sign * glm::cross(s, p);
    rows.torque[n] =
        unknown == Unknown::velocity ? rows.gradient[n] : sign * glm::cross(mean_s, mean_p);
    rows.off[n] = unknown == Unknown::velocity ? 0 : glm::dot(p, s);
  }
  return rows;
}

std::size_t find_free(const Vec3 (&rows)[3], std::size_t count, Vec3 (&free)[3]) {
  if (count == 0) {
    std::copy(std::begin(kAxes), std::end(kAxes), free);
    return 3;
  }
  if (count == 2) {
    free[0] = glm::normalize(glm::cross(rows[0], rows[1]));
    return 1;
  }
  PANTIN_ASSERT(count == 1 || count == 3);
  if (count == 3) return 0;
  const Vec3 n = glm::normalize(rows[0]);
  const int least = std::abs(n.x) < std::abs(n.y) ? (std::abs(n.x) < std::abs(n.z) ? 0 : 2)
                                                  : (std::abs(n.y) < std::abs(n.z) ? 1 : 2);
  free[0] = glm::normalize(glm::cross(n, kAxes[least]));
  free[1] = glm::cross(n, free[0]);
  return 2;
}

void invert_rows(const Vec3 (&rows)[3], std::size_t count, Vec3 (&columns)[3]) {
  if (count == 1) columns[0] = rows[0] / glm::dot(rows[0], rows[0]);
  if (count < 2) return;
  const Vec3 third = count == 3 ? rows[2] : glm::cross(rows[0], rows[1]);
  const Vec3 c0 = glm::cross(rows[1], third), c1 = glm::cross(third, rows[0]),
             c2 = glm::cross(rows[0], rows[1]);
  const Real per = 1 / glm::dot(rows[0], c0);
  columns[0] = per * c0, columns[1] = per * c1, columns[2] = per * c2;
}

Mat3 reduced_inverse(const Mat3& m, const Vec3 (&free)[3], const Vec3 (&to)[3], std::size_t count) {
  if (count == 0) return Mat3(0);
  if (count == 3) return glm::inverse(m);
  if (count == 1) return glm::outerProduct(free[0], to[0]) / glm::dot(to[0], m * free[0]);
  PANTIN_ASSERT(count == 2);
  const Vec3 m0 = m * free[0], m1 = m * free[1];
  const Real a = glm::dot(to[0], m0), b = glm::dot(to[0], m1), c = glm::dot(to[1], m0),
             d = glm::dot(to[1], m1), per = 1 / (a * d - b * c);
  return per * (glm::outerProduct(free[0], d * to[0] - b * to[1]) +
                glm::outerProduct(free[1], a * to[1] - c * to[0]));
}

Directions directions_of(const PackedJoint& j, const JointEnds& ends) {
  const auto axes = [](Quat body, Quat frame) { return glm::mat3_cast(body * frame); };
  const Quat fa = j.joint.frames.a(), fb = j.joint.frames.b();
  return j.own_is_a ? Directions{axes(ends.own0, fa), axes(ends.own1, fa), axes(ends.parent0, fb),
                                 axes(ends.parent1, fb)}
                    : Directions{axes(ends.parent0, fa), axes(ends.parent1, fa),
                                 axes(ends.own0, fb), axes(ends.own1, fb)};
}

RowTurn turn_of_rows(const PackedJoint& j, const Directions& d, const Real (&multipliers)[3]) {
  RowTurn turn;
  std::size_t n = 0;
  for (const RowAxes& axes : rows_of(j.joint.kind)) {
    const Vec3 p = d.a1[axes.p], s = d.b1[axes.s];
    const Vec3 mean_p = 0.5 * (d.a0[axes.p] + p), mean_s = 0.5 * (d.b0[axes.s] + s);
    const Real half = 0.5 * multipliers[n++] * (j.own_is_a ? -1 : 1);
    const Mat3 by_b = half * (glm::outerProduct(s, mean_p) - Mat3(glm::dot(s, mean_p)));
    const Mat3 by_a = half * (Mat3(glm::dot(mean_s, p)) - glm::outerProduct(p, mean_s));
    turn.own += j.own_is_a ? by_a : by_b, turn.parent += j.own_is_a ? by_b : by_a;
  }
  return turn;
}

}  // namespace pantin::detail::articulated
