#pragma once
/// Curves and surfaces for tests: those of tests/data/nurbs.json, and random ones.
#include <algorithm>
#include <string>
#include <vector>

#include "engine/nurbs/spline.hpp"
#include "tests/base/random.hpp"

namespace pantin::test {

using namespace pantin::detail;

/// Knots over [0, 1] with `count` control points, clamped, some of them doubled.
inline nurbs::Knots random_knots(int degree, int count, Random& dice) {
  std::vector<Real> inner;
  while (static_cast<int>(inner.size()) < count - degree - 1) {
    inner.push_back(dice.between(0.05, 0.95));
    const bool has_room = static_cast<int>(inner.size()) < count - degree - 1;
    if (degree > 1 && has_room && dice.below(4) == 0) inner.push_back(inner.back());
  }
  std::sort(inner.begin(), inner.end());
  nurbs::Knots knots{.degree = degree, .values = {}};
  knots.values.assign(static_cast<std::size_t>(degree + 1), 0);
  knots.values.insert(knots.values.end(), inner.begin(), inner.end());
  knots.values.insert(knots.values.end(), static_cast<std::size_t>(degree + 1), 1);
  return knots;
}

/// The same number of control points on knots that increase all along: not clamped.
inline nurbs::Knots open_knots(int degree, int count, Random& dice) {
  nurbs::Knots knots{.degree = degree, .values = {}};
  Real t = -1;
  for (int i = 0; i < count + degree + 1; ++i) knots.values.push_back(t += dice.between(0.2, 0.5));
  return knots;
}

inline nurbs::Weighted random_point(Random& dice) {
  const Vec3 p = dice.in_cube(1);
  return {p, dice.between(0.5, 2)};
}

inline nurbs::Curve random_curve(int degree, int count, Random& dice) {
  nurbs::Curve curve{random_knots(degree, count, dice), {}};
  for (int i = 0; i < count; ++i) curve.points.push_back(random_point(dice));
  return curve;
}

inline nurbs::Surface random_surface(int p, int q, int rows, int columns, Random& dice) {
  nurbs::Surface surface{random_knots(p, rows, dice), random_knots(q, columns, dice), {}};
  for (int i = 0; i < rows * columns; ++i) surface.points.push_back(random_point(dice));
  return surface;
}

/// A graph over [-1, 1]^2 with bumps of `height`, u x v up.
inline nurbs::Surface bumpy_surface(int degree, int count, Real height, Random& dice) {
  nurbs::Surface s{nurbs::uniform_knots(degree, count), nurbs::uniform_knots(degree, count), {}};
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < count; ++j) {
      const Real z = dice.between(-height, height);
      const Vec3 p(-1 + 2.0 * i / (count - 1), -1 + 2.0 * j / (count - 1), z);
      s.points.push_back({p, dice.between(0.8, 1.25)});
    }
  return s;
}

/// The largest difference of two curves, or surfaces, over the domain of the second.
inline Real largest_difference(const nurbs::Curve& a, const nurbs::Curve& b) {
  Real most = 0;
  const nurbs::Range range = b.knots.domain();
  for (int i = 0; i <= 50; ++i) {
    const Real t = range.low + range.width() * i / 50;
    most = std::max(most, glm::distance(evaluate(a, t, 0)[0], evaluate(b, t, 0)[0]));
  }
  return most;
}
inline Real largest_difference(const nurbs::Surface& a, const nurbs::Surface& b) {
  Real most = 0;
  const nurbs::Range u = b.u.domain(), v = b.v.domain();
  for (int i = 0; i <= 12; ++i)
    for (int j = 0; j <= 12; ++j) {
      const Real x = u.low + u.width() * i / 12, y = v.low + v.width() * j / 12;
      most = std::max(most, glm::distance(evaluate(a, x, y, 0)[0][0], evaluate(b, x, y, 0)[0][0]));
    }
  return most;
}

}  // namespace pantin::test
