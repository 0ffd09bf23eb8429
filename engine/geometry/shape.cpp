#include "engine/geometry/shape.hpp"

#include <array>
#include <utility>

#include "engine/base/rotation.hpp"
#include "engine/geometry/kinds.hpp"
#include "engine/geometry/mass_properties.hpp"

namespace pantin {

using namespace detail;

namespace {

/// Moves a tensor from its mass centre to a point `offset` away (parallel axes).
Mat3 parallel_axis(Real mass, Vec3 offset) {
  return mass * (glm::dot(offset, offset) * Mat3(1) - glm::outerProduct(offset, offset));
}

}  // namespace

Real volume(const Shape& shape) {
  const ShapeTraits& kind = traits_of(shape.kind);
  if (kind.volume) return kind.volume(shape);
  return kind.enclosed && is_complete(shape) ? kind.enclosed(shape).mass : 0;
}

MassProperties mass_properties(const Shape& shape, Real density) {
  const ShapeTraits& kind = traits_of(shape.kind);
  if (kind.enclosed && is_complete(shape)) {
    const MassProperties inside = kind.enclosed(shape);
    const Mat3 turn = glm::mat3_cast(shape.local.rotation);
    return {density * inside.mass, to_world(shape.local, inside.centre),
            density * (turn * inside.inertia * glm::transpose(turn))};
  }
  const Real mass = density * volume(shape);
  const Vec3 moments = kind.unit_moments ? kind.unit_moments(shape) : Vec3(0);
  return {mass, shape.local.position, world_inertia(shape.local.rotation, mass * moments)};
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
      // Positive angles rotate axis p towards q; about y the order is z to x.
      rotation[axis] = (axis == 1 ? 1 : -1) * std::atan(t);
      const Quat step = from_rotation_vector(rotation);
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
  constexpr const char* kWrong = "has no surface data for its type";
  if (size.x < 0 || size.y < 0 || size.z < 0) return "has a negative size";
  const bool is_field = surface && surface->columns > 0;
  const bool is_mesh = surface && !surface->neighbours.empty();
  switch (traits_of(kind).source) {
    case SurfaceSource::skin:
      return surface && surface->skin ? nullptr : kWrong;
    case SurfaceSource::points:
      return surface && !is_field && !is_mesh && !surface->faces.empty() ? nullptr : kWrong;
    case SurfaceSource::triangles:
      return is_mesh ? nullptr : kWrong;
    case SurfaceSource::heights:
      return is_field ? nullptr : kWrong;
    case SurfaceSource::none:
      break;
  }
  return nullptr;
}

void detail::round_off(MassProperties& whole) {
  const Mat3& t = whole.inertia;
  const Real trace = t[0][0] + t[1][1] + t[2][2];
  const Real extent = std::sqrt(trace / whole.mass);
  for (int i = 0; i < 3; ++i) {
    if (std::abs(whole.centre[i]) < 1e-12 * extent) whole.centre[i] = 0;
    for (int j = 0; j < 3; ++j)
      if (i != j && std::abs(t[i][j]) < 1e-12 * trace) whole.inertia[i][j] = 0;
  }
}

}  // namespace pantin
