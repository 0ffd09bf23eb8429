#include "engine/geometry/shape.hpp"

#include <array>
#include <utility>

#include "engine/base/rotation.hpp"
#include "engine/geometry/surface.hpp"

namespace pantin {
namespace {

/// Moves a tensor from its mass centre to a point `offset` away (parallel axes).
Mat3 parallel_axis(Real mass, Vec3 offset) {
  return mass * (glm::dot(offset, offset) * Mat3(1) - glm::outerProduct(offset, offset));
}

Vec3 unit_moments(const Shape& shape) {
  const Real r = shape.size.x;
  switch (shape.kind) {
    case ShapeKind::sphere:
      return Vec3(0.4 * r * r);
    case ShapeKind::capsule: {
      // A cylinder and two half balls, weighted by their volumes.
      const Real c = shape.size.y;
      const Real cylinder = 2 * c * r * r, balls = 4.0 / 3 * r * r * r;  // both over pi
      const Real whole = cylinder + balls;
      const Real along = (cylinder * r * r / 2 + balls * 0.4 * r * r) / whole;
      const Real across =
          (cylinder * (r * r / 4 + c * c / 3) + balls * (0.4 * r * r + c * c + 0.75 * c * r)) /
          whole;
      return {across, along, across};
    }
    case ShapeKind::box: {
      const Vec3 s = shape.size * shape.size / 3.0;
      return {s.y + s.z, s.x + s.z, s.x + s.y};
    }
    default:
      return Vec3(0);
  }
}

bool has_faces(const Shape& shape) {
  return (shape.kind == ShapeKind::hull || shape.kind == ShapeKind::mesh) && shape.surface;
}

/// Of density 1, in the surface's own frame: signed tetrahedra from one of its points.
MassProperties enclosed(const Surface& surface) {
  const Vec3 apex = (surface.low + surface.high) / 2.0;
  Real volume = 0;
  Vec3 first(0);   // integral of x
  Mat3 second(0);  // integral of x x^T
  for (const Face& face : surface.faces)
    for (std::uint32_t i = 1; i + 1 < face.count; ++i) {
      const Vec3 a = surface.points[surface.corners[face.first]] - apex,
                 b = surface.points[surface.corners[face.first + i]] - apex,
                 c = surface.points[surface.corners[face.first + i + 1]] - apex, sum = a + b + c;
      const Real v = glm::dot(a, glm::cross(b, c)) / 6;
      volume += v, first += v / 4 * sum;
      second += v / 20 * (glm::outerProduct(a, a) + glm::outerProduct(b, b) +
                          glm::outerProduct(c, c) + glm::outerProduct(sum, sum));
    }
  const Vec3 centre = first / volume;
  second -= volume * glm::outerProduct(centre, centre);
  const Real trace = second[0][0] + second[1][1] + second[2][2];
  return {volume, apex + centre, trace * Mat3(1) - second};
}

}  // namespace

Real volume(const Shape& shape) {
  const Real r = shape.size.x;
  switch (shape.kind) {
    case ShapeKind::sphere:
      return 4.0 / 3 * kPi * r * r * r;
    case ShapeKind::capsule:
      return kPi * r * r * (2 * shape.size.y + 4.0 / 3 * r);
    case ShapeKind::box:
      return 8 * shape.size.x * shape.size.y * shape.size.z;
    default:
      return has_faces(shape) ? enclosed(*shape.surface).mass : 0;
  }
}

MassProperties mass_properties(const Shape& shape, Real density) {
  if (has_faces(shape)) {
    const MassProperties inside = enclosed(*shape.surface);
    const Mat3 turn = glm::mat3_cast(shape.local.rotation);
    return {density * inside.mass, to_world(shape.local, inside.centre),
            density * (turn * inside.inertia * glm::transpose(turn))};
  }
  const Real mass = density * volume(shape);
  return {mass, shape.local.position,
          world_inertia(shape.local.rotation, mass * unit_moments(shape))};
}

MassProperties combine(const MassProperties& a, const MassProperties& b) {
  if (a.mass == 0) return b;
  if (b.mass == 0) return a;
  const Real mass = a.mass + b.mass;
  const Vec3 centre = (a.mass * a.centre + b.mass * b.centre) / mass;
  return {mass, centre,
          a.inertia + parallel_axis(a.mass, a.centre - centre) + b.inertia +
              parallel_axis(b.mass, b.centre - centre)};
}

PrincipalInertia principal_inertia(const Mat3& tensor) {
  Mat3 d = tensor;
  Quat turn{1, 0, 0, 0};
  constexpr std::array<std::pair<int, int>, 3> kPlanes{{{0, 1}, {0, 2}, {1, 2}}};
  for (int round = 0; round < 32; ++round) {
    Real off = 0;
    for (auto [p, q] : kPlanes) off += d[p][q] * d[p][q];
    const Real scale = d[0][0] * d[0][0] + d[1][1] * d[1][1] + d[2][2] * d[2][2];
    if (!(off > 1e-34 * scale)) break;
    for (auto [p, q] : kPlanes) {
      if (d[p][q] == 0) continue;
      const Real theta = (d[q][q] - d[p][p]) / (2 * d[p][q]);
      const Real t = (theta >= 0 ? 1.0 : -1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1));
      const int axis = 3 - p - q;
      Vec3 rotation(0);
      // Positive angles turn axis p towards q; about y that order is z to x.
      rotation[axis] = (axis == 1 ? 1 : -1) * std::atan(t);
      const Quat step = turn_by(rotation);
      const Mat3 r = glm::mat3_cast(step);
      d = glm::transpose(r) * d * r;
      turn = glm::normalize(turn * step);
    }
  }
  return {{d[0][0], d[1][1], d[2][2]}, turn};
}

bool is_possible_inertia(Vec3 m) {
  if (!is_finite(m) || !(m.x > 0 && m.y > 0 && m.z > 0)) return false;
  const Real slack = 1e-9 * (m.x + m.y + m.z);  // round-off of a diagonalised tensor
  return m.x <= m.y + m.z + slack && m.y <= m.x + m.z + slack && m.z <= m.x + m.y + slack;
}

const char* Shape::restored() const {
  constexpr const char* kWrong = "has no surface of its kind";
  const bool is_field = surface && surface->columns > 0;
  const bool is_mesh = surface && !surface->neighbours.empty();
  switch (kind) {
    case ShapeKind::hull:
      return surface && !is_field && !is_mesh ? nullptr : kWrong;
    case ShapeKind::mesh:
      return is_mesh ? nullptr : kWrong;
    case ShapeKind::height_field:
      return is_field ? nullptr : kWrong;
    default:
      return nullptr;
  }
}

}  // namespace pantin
