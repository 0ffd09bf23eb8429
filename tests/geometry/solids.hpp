#pragma once
// One shape of every kind for tests that hold for all, with a test of its own for what is inside.
#include <functional>
#include <vector>

#include "engine/geometry/kinds.hpp"
#include "engine/geometry/skin_model.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/nurbs/makers.hpp"
#include "tests/base/random.hpp"

namespace pantin::test {

using namespace detail;

struct Sample {
  Shape shape;
  std::function<bool(Vec3)> inside;  // by a formula that the engine does not use
};

/// An L of two blocks, along y: not convex.
inline std::shared_ptr<const Surface> corner_mesh() {
  const std::vector<Vec3> outline{{0, 0, 0},     {1, 0, 0},   {1, 0, 0.5},
                                  {0.5, 0, 0.5}, {0.5, 0, 1}, {0, 0, 1}};
  std::vector<Vec3> points;
  for (Real y : {-0.4, 0.4})
    for (Vec3 p : outline) points.push_back({p.x - 0.4, y, p.z - 0.4});
  std::vector<std::array<std::uint32_t, 3>> triangles;
  const std::array<std::uint32_t, 3> cap[] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}};
  for (auto t : cap) {
    triangles.push_back({t[0], t[1], t[2]});
    triangles.push_back({t[0] + 6, t[2] + 6, t[1] + 6});
  }
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t j = (i + 1) % 6;
    triangles.push_back({i, i + 6, j + 6});
    triangles.push_back({i, j + 6, j});
  }
  return *make_mesh(points, triangles);
}

/// About a line along z through (0.5, 0, 0): not convex.
inline std::shared_ptr<const Surface> torus_skin() {
  std::vector<nurbs::Surface> faces{nurbs::torus({{0.5, 0, 0}}, 0.5, 0.25)};
  return *make_skin(std::make_shared<nurbs::Skin>(std::move(faces), 1e-9));
}

/// Heights of a tilted ground.
inline Real slope(Real x, Real z) { return 0.3 * x - 0.2 * z; }

inline std::vector<Sample> samples() {
  const auto in_box = [](Vec3 half) {
    return [half](Vec3 p) {
      return std::abs(p.x) < half.x && std::abs(p.y) < half.y && std::abs(p.z) < half.z;
    };
  };
  std::vector<Sample> all;
  all.push_back(
      {{ShapeKind::sphere, {0.7, 0, 0}, {}, 0}, [](Vec3 p) { return glm::length(p) < 0.7; }});
  all.push_back({{ShapeKind::capsule, {0.3, 0.5, 0}, {}, 0}, [](Vec3 p) {
                   return glm::length(p - Vec3(0, glm::clamp(p.y, -0.5, 0.5), 0)) < 0.3;
                 }});
  all.push_back({{ShapeKind::box, {0.3, 0.6, 0.4}, {}, 0}, in_box({0.3, 0.6, 0.4})});
  // An octahedron.
  const std::vector<Vec3> tips{{0.8, 0, 0},  {-0.8, 0, 0}, {0, 0.8, 0},
                               {0, -0.8, 0}, {0, 0, 0.8},  {0, 0, -0.8}};
  all.push_back({{ShapeKind::hull, {}, {}, 0, *make_hull(tips)},
                 [](Vec3 p) { return std::abs(p.x) + std::abs(p.y) + std::abs(p.z) < 0.8; }});
  all.push_back({{ShapeKind::plane, {5, 0, 0}, {}, 0}, [](Vec3 p) { return p.y < 0; }});
  all.push_back({{ShapeKind::mesh, {}, {}, 0, corner_mesh()}, [](Vec3 p) {
                   const Real x = p.x + 0.4, z = p.z + 0.4;
                   if (!(std::abs(p.y) < 0.4 && x > 0 && z > 0 && x < 1 && z < 1)) return false;
                   return x < 0.5 || z < 0.5;
                 }});
  all.push_back({{ShapeKind::cylinder, {0.4, 0.5, 0}, {}, 0},
                 [](Vec3 p) { return p.x * p.x + p.z * p.z < 0.16 && std::abs(p.y) < 0.5; }});
  all.push_back({{ShapeKind::cone, {0.6, 0.5, 0}, {}, 0},
                 [](Vec3 p) { return p.y > -0.5 && std::hypot(p.x, p.z) < 0.6 * (0.5 - p.y); }});
  all.push_back({{ShapeKind::ellipsoid, {0.7, 0.3, 0.5}, {}, 0}, [](Vec3 p) {
                   return p.x * p.x / 0.49 + p.y * p.y / 0.09 + p.z * p.z / 0.25 < 1;
                 }});
  all.push_back({{ShapeKind::nurbs, {}, {}, 0, torus_skin()},
                 [](Vec3 p) { return std::hypot(std::hypot(p.x - 0.5, p.y) - 0.5, p.z) < 0.25; }});
  std::vector<Real> heights;
  for (int z = 0; z < 5; ++z)
    for (int x = 0; x < 6; ++x) heights.push_back(slope(0.5 * (x - 2.5), 0.4 * (z - 2)));
  all.push_back(
      {{ShapeKind::height_field, {}, {}, 0, *make_height_field({6, 5, 0.5, 0.4, heights})},
       [](Vec3 p) {
         return std::abs(p.x) < 1.25 && std::abs(p.z) < 0.8 && p.y < slope(p.x, p.z);
       }});
  return all;
}

}  // namespace pantin::test
