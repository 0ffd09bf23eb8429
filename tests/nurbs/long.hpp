#pragma once
/// Surfaces a hundred times as long as wide, and how bodies stand on them.
#include <vector>

#include "engine/nurbs/common_normal.hpp"
#include "engine/nurbs/makers.hpp"
#include "tests/base/random.hpp"

namespace pantin::test {

using namespace pantin::detail::nurbs;

inline Skin single(Surface s) { return Skin({std::move(s)}, 1e-9); }

/// A closed profile whose radius goes up and down.
inline Curve cam(int points, Real radius) {
  std::vector<Vec3> at;
  for (int i = 0; i < points; ++i) {
    const Real t = 2 * kPi * i / points,
               r = radius * (1 + 0.2 * std::cos(t) + 0.1 * std::cos(2 * t));
    at.emplace_back(r * std::cos(t), r * std::sin(t), 0);
  }
  return interpolated(at, 3, Ends::periodic).value();
}

inline Curve winding_path() {
  std::vector<Vec3> at;
  for (int i = 0; i < 12; ++i)
    at.emplace_back(0.2 * i, 0.05 * std::sin(Real(i)), 0.05 * std::cos(0.7 * i));
  return interpolated(at, 3, Ends::open).value();
}

struct Named {
  const char* name;
  Surface surface;
  Real reach;  // m, below its thickness
};

/// A hundred times as long as wide, or more; and a ruled one that twists.
inline std::vector<Named> long_surfaces() {
  Surface ruled = extruded(cam(20, 0.05), {0, 0, 1});
  for (std::size_t i = 1; i < ruled.points.size(); i += 2) {
    Weighted& p = ruled.points[i];
    p = Weighted(p.x * std::cos(0.5) - p.y * std::sin(0.5),
                 p.x * std::sin(0.5) + p.y * std::cos(0.5), p.z, p.w);
  }
  const Curve section = circle({{}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, 0.005);
  return {{"a cam of 10 mm by 2 m", extruded(cam(40, 0.005), {0, 0, 2}), 0.005},
          {"a wide cam", extruded(cam(40, 0.05), {0, 0, 2}), 0.02},
          {"a rod", cylinder({}, 0.005, 2), 0.005},
          {"a cone", cone({}, {0.005, 0.03}, 2), 0.005},
          {"a rail", inside_out(swept(section, winding_path())), 0.005},
          {"a pipe", inside_out(swept_turning(circle({}, 0.005), winding_path(), 40)), 0.005},
          {"a ruled one", ruled, 0.02}};
}

struct Spot {
  Vec3 at{0}, normal{0};
  Place place;
};
inline Spot spot_on(const Skin& skin, Random& dice) {
  const int index = dice.below(static_cast<int>(skin.faces().size()));
  const Face& face = skin.face(index);
  const Range u = face.u().domain(), v = face.v().domain();
  const Place at{index, u.low + u.width() * dice.between(0.05, 0.95),
                 v.low + v.width() * dice.between(0.1, 0.9)};
  const Jet j = face.at(at.u, at.v);
  return {j.s, glm::normalize(glm::cross(j.u, j.v)), at};
}

/// A stands on b, so far above it, both by a spot; turned by chance about the normal.
inline Pose standing(const Spot& on_a, const Spot& on_b, Real gap, Random& dice) {
  Quat turn = dice.orientation();
  const Vec3 from = turn * on_a.normal, axis = glm::cross(from, -on_b.normal);
  const Real sine = glm::length(axis);
  if (sine > 1e-9)
    turn = glm::angleAxis(std::atan2(sine, -glm::dot(from, on_b.normal)), axis / sine) * turn;
  turn = glm::normalize(turn);
  return {on_b.at + gap * on_b.normal - turn * on_a.at, turn};
}
inline Pose standing_on(const Skin& a, const Skin& b, Real gap, Random& dice) {
  const Spot on_a = spot_on(a, dice);
  return standing(on_a, spot_on(b, dice), gap, dice);
}

}  // namespace pantin::test
