#pragma once
// Solids of NURBS faces that meet at creases, each with what it is by a formula.
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "engine/geometry/collide.hpp"
#include "engine/geometry/kinds.hpp"
#include "engine/geometry/skin_model.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/nurbs/makers.hpp"

namespace pantin::test {

using namespace detail;

/// A solid, places on its surface, and how far a point is from it, m, below 0 inside: exact
/// outside and near its surface.
struct Creased {
  Shape skin;
  std::vector<Shape> boxes;  // the same as blocks, where it is made of such
  std::vector<Vec3> places;
  std::function<Real(Vec3)> distance;
};

inline Shape skin_shape(std::vector<nurbs::Surface> faces) {
  Shape shape;
  shape.kind = ShapeKind::nurbs;
  shape.surface = *make_skin(std::make_shared<nurbs::Skin>(std::move(faces), 1e-9));
  return shape;
}

/// A flat face by its corners, anticlockwise seen from outside.
inline nurbs::Surface quad(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
  nurbs::Surface s;
  s.u = s.v = {1, {0, 0, 1, 1}};
  s.points = {{a, 1}, {d, 1}, {b, 1}, {c, 1}};
  return s;
}

struct Block {
  Vec3 low, high;
};

inline Real from_block(const Block& b, Vec3 p) {
  const Vec3 out = glm::max(b.low - p, p - b.high);
  const Real inside = std::max({out.x, out.y, out.z});
  return inside > 0 ? glm::length(glm::max(out, Vec3(0))) : inside;
}

/// Blocks grown together. Their faces lie on the planes of all their faces, so that what is seen
/// is flat, square, and joined edge to edge.
inline Creased grown_together(const std::vector<Block>& blocks) {
  std::array<std::vector<Real>, 3> cuts;
  for (const Block& b : blocks)
    for (int k = 0; k < 3; ++k) cuts[k].push_back(b.low[k]), cuts[k].push_back(b.high[k]);
  for (auto& c : cuts) {
    std::sort(c.begin(), c.end());
    c.erase(std::unique(c.begin(), c.end()), c.end());
  }
  const auto is_solid = [&](std::array<int, 3> cell) {
    Vec3 middle;
    for (int k = 0; k < 3; ++k) {
      if (cell[k] < 0 || cell[k] + 1 >= static_cast<int>(cuts[k].size())) return false;
      const auto i = static_cast<std::size_t>(cell[k]);
      middle[k] = (cuts[k][i] + cuts[k][i + 1]) / 2;
    }
    return std::any_of(blocks.begin(), blocks.end(),
                       [&](const Block& b) { return from_block(b, middle) < 0; });
  };
  Creased made;
  std::vector<nurbs::Surface> faces;
  const auto add_side = [&](std::array<int, 3> cell, int axis, int way) {
    std::array<int, 3> beyond = cell;
    beyond[axis] += way;
    if (!is_solid(cell) || is_solid(beyond)) return;
    Vec3 low, high;
    for (int k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>(cell[k]);
      low[k] = cuts[k][i], high[k] = cuts[k][i + 1];
    }
    low[axis] = high[axis] = way > 0 ? high[axis] : low[axis];
    const int x = (axis + 1) % 3, y = (axis + 2) % 3;
    Vec3 b = low, d = low;
    b[x] = high[x], d[y] = high[y];
    faces.push_back(way > 0 ? quad(low, b, high, d) : quad(low, d, high, b));
    constexpr int kRows = 8;
    for (int i = 0; i <= kRows; ++i)
      for (int j = 0; j <= kRows; ++j)
        made.places.push_back(low + (b - low) * (Real(i) / kRows) + (d - low) * (Real(j) / kRows));
  };
  for (int i = 0; i + 1 < static_cast<int>(cuts[0].size()); ++i)
    for (int j = 0; j + 1 < static_cast<int>(cuts[1].size()); ++j)
      for (int k = 0; k + 1 < static_cast<int>(cuts[2].size()); ++k)
        for (int axis = 0; axis < 3; ++axis)
          for (const int way : {-1, 1}) add_side({i, j, k}, axis, way);
  made.skin = skin_shape(std::move(faces));
  for (const Block& b : blocks) {
    Shape s;
    s.kind = ShapeKind::box, s.size = (b.high - b.low) / 2.0;
    s.local.position = (b.high + b.low) / 2.0;
    made.boxes.push_back(s);
  }
  made.distance = [blocks](Vec3 p) {
    Real least = 1e300;
    for (const Block& b : blocks) least = std::min(least, from_block(b, p));
    return least;
  };
  return made;
}

/// A closed polygon of radius and height, the solid to its left, turned about y.
inline Creased turned(std::vector<std::array<Real, 2>> outline) {
  Creased made;
  std::vector<nurbs::Surface> faces;
  const nurbs::Frame upright{Vec3(0), {0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const auto p = outline[i], q = outline[(i + 1) % outline.size()];
    if (p[0] == 0 && q[0] == 0) continue;
    const auto at = [](std::array<Real, 2> a) { return Vec3(0, a[1], a[0]); };
    faces.push_back(nurbs::revolved(nurbs::line(at(p), at(q)), upright, 2 * kPi));
    constexpr int kRows = 12, kAround = 48;
    for (int j = 0; j <= kRows; ++j)
      for (int k = 0; k < kAround; ++k) {
        const Real t = Real(j) / kRows, r = p[0] + t * (q[0] - p[0]), a = 2 * kPi * k / kAround;
        made.places.push_back({r * std::cos(a), p[1] + t * (q[1] - p[1]), r * std::sin(a)});
      }
  }
  made.skin = skin_shape(std::move(faces));
  made.distance = [outline](Vec3 p) {
    const Real x = std::hypot(p.x, p.z), y = p.y;
    Real least = 1e300;
    bool is_inside = false;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const auto a = outline[i], b = outline[(i + 1) % outline.size()];
      const Real dx = b[0] - a[0], dy = b[1] - a[1];
      if (!(a[0] == 0 && b[0] == 0)) {
        const Real t =
            std::clamp(((x - a[0]) * dx + (y - a[1]) * dy) / (dx * dx + dy * dy), Real(0), Real(1));
        least = std::min(least, std::hypot(x - a[0] - t * dx, y - a[1] - t * dy));
      }
      if ((a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / dy * dx) is_inside = !is_inside;
    }
    return is_inside ? -least : least;
  };
  return made;
}

// ---- Parts
// ---------------------------------------------------------------------------------------

inline Creased block_of(Vec3 half) { return grown_together({{-half, half}}); }
/// An L of two plates 0.03 m thick, 0.2 m long, 0.16 m wide.
inline Creased bracket() {
  return grown_together(
      {{{-0.1, -0.05, -0.08}, {0.1, -0.02, 0.08}}, {{-0.1, -0.05, -0.08}, {-0.07, 0.15, 0.08}}});
}
/// A rail 0.6 m long with a slot like a T, open above.
inline Creased t_slot() {
  return grown_together({{{-0.1, 0, -0.3}, {0.1, 0.02, 0.3}},
                         {{-0.1, 0, -0.3}, {-0.06, 0.1, 0.3}},
                         {{0.06, 0, -0.3}, {0.1, 0.1, 0.3}},
                         {{-0.1, 0.06, -0.3}, {-0.03, 0.1, 0.3}},
                         {{0.03, 0.06, -0.3}, {0.1, 0.1, 0.3}}});
}
/// What fits in it with a millimetre to spare.
inline Creased slider() {
  return grown_together({{{-0.059, -0.0195, -0.05}, {0.059, 0.0195, 0.05}},
                         {{-0.029, -0.0195, -0.05}, {0.029, 0.08, 0.05}}});
}
inline Creased disc(Real radius, Real half) {
  return turned({{0, -half}, {radius, -half}, {radius, half}, {0, half}});
}
/// A plate with a round hole.
inline Creased washer(Real inner, Real outer, Real half) {
  return turned({{inner, -half}, {outer, -half}, {outer, half}, {inner, half}});
}
/// A cup with a foot ring, 0.1 m wide.
inline Creased cup() {
  return turned({{0, 0.01},
                 {0.03, 0.01},
                 {0.03, 0},
                 {0.04, 0},
                 {0.05, 0.1},
                 {0.042, 0.1},
                 {0.035, 0.02},
                 {0, 0.02}});
}
/// A shallow dish with a rim.
inline Creased dish() {
  return turned({{0, 0}, {0.15, 0}, {0.2, 0.03}, {0.19, 0.035}, {0.145, 0.01}, {0, 0.005}});
}

/// What two shapes touch by, and the deepest of it.
struct Found {
  std::vector<ContactPoint> points;
  NarrowPhaseScratch scratch;

  const ContactPoint* touch(const PlacedShape& a, const PlacedShape& b, Real margin) {
    points.clear();
    collide(a, b, scratch, {margin, points});
    const ContactPoint* deepest = nullptr;
    for (const ContactPoint& p : points)
      if (!deepest || p.gap < deepest->gap) deepest = &p;
    return deepest;
  }
};

}  // namespace pantin::test
