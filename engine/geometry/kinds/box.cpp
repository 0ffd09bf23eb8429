// A block: size is its half extents.
#include "engine/geometry/kinds/parts.hpp"

namespace pantin::detail::shape_kinds {
namespace {

constexpr SizeKey kSizes[] = {
    {"size", "Full edge lengths along x, y and z.", 0, 3, 0.5, 0, "the three edges of the box"}};

Real volume(const Shape& shape) { return 8 * shape.size.x * shape.size.y * shape.size.z; }

Vec3 unit_moments(const Shape& shape) {
  const Vec3 s = shape.size * shape.size / 3.0;
  return {s.y + s.z, s.x + s.z, s.x + s.y};
}

std::optional<RoundedBox> rounded(const Shape& shape) { return RoundedBox{shape.size, 0}; }

Vec3 support(const Shape& shape, Vec3 d) {
  const Vec3 s = shape.size;
  return {d.x < 0 ? -s.x : s.x, d.y < 0 ? -s.y : s.y, d.z < 0 ? -s.z : s.z};
}

Real inner_radius(const Shape& shape) {
  return glm::min(shape.size.x, glm::min(shape.size.y, shape.size.z));
}

Aabb bounds(const Shape& shape, const Pose& at) {
  const Vec3 half = spread(glm::mat3_cast(at.rotation), shape.size);
  return {at.position - half, at.position + half};
}

using Pair = std::array<std::uint32_t, 2>;

/// Topology of a box: corner i has the sign bits x = 1, y = 2, z = 4.
constexpr std::array<std::uint32_t, 24> kBoxCorners{0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4,
                                                    2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6};
constexpr std::array<Pair, 12> kBoxEdges{{{0, 1},
                                          {2, 3},
                                          {4, 5},
                                          {6, 7},
                                          {0, 2},
                                          {1, 3},
                                          {4, 6},
                                          {5, 7},
                                          {0, 4},
                                          {1, 5},
                                          {2, 6},
                                          {3, 7}}};

/// Faces of a box: 0, 1 at low and high x, and so on. The left face of an edge is the one whose
/// loop traverses it from its first corner to its second.
constexpr std::array<Pair, 12> box_sides() {
  std::array<Pair, 12> sides{};
  for (std::size_t e = 0; e < 12; ++e)
    for (std::uint32_t f = 0; f < 6; ++f)
      for (std::size_t i = 0; i < 4; ++i) {
        const std::uint32_t from = kBoxCorners[4 * f + i], to = kBoxCorners[4 * f + (i + 1) % 4];
        if (from == kBoxEdges[e][0] && to == kBoxEdges[e][1]) sides[e][0] = f;
        if (from == kBoxEdges[e][1] && to == kBoxEdges[e][0]) sides[e][1] = f;
      }
  return sides;
}
constexpr std::array<Pair, 12> kBoxSides = box_sides();

Convex convex_piece(const Shape& shape, const Pose& at, ConvexScratch& scratch) {
  const Vec3 half = shape.size;
  const Mat3 rotation = glm::mat3_cast(at.rotation);
  scratch.points.resize(8), scratch.faces.resize(6);
  const Vec3 x = half.x * rotation[0], y = half.y * rotation[1], z = half.z * rotation[2];
  for (std::uint32_t i = 0; i < 8; ++i)
    scratch.points[i] = at.position + ((i & 1 ? x : -x) + (i & 2 ? y : -y) + (i & 4 ? z : -z));
  for (std::uint32_t f = 0; f < 6; ++f) {
    const int axis = static_cast<int>(f / 2);
    const Vec3 normal = f % 2 ? rotation[axis] : -rotation[axis];
    scratch.faces[f] = {4 * f, 4, normal, glm::dot(normal, at.position) + half[axis]};
  }
  return {scratch.points, scratch.faces,    kBoxCorners, kBoxEdges, kBoxSides, 0,
          at.position,    glm::length(half)};
}

/// Slab test.
std::optional<RayEntry> cast(const Shape& shape, Vec3 from, Vec3 way, Real limit) {
  const auto [enter, leave] = ray_range(Aabb{-shape.size, shape.size}, from, way);
  if (enter > leave || enter < 0 || enter > limit) return std::nullopt;
  // The side that is entered last.
  RayEntry entry{enter, Vec3(0)};
  int axis = 0;
  Real last = -1e300;
  for (int i = 0; i < 3; ++i) {
    if (way[i] == 0) continue;
    const Real at = ((way[i] > 0 ? -shape.size[i] : shape.size[i]) - from[i]) / way[i];
    if (at > last) last = at, axis = i;
  }
  entry.normal[axis] = way[axis] > 0 ? -1 : 1;
  return entry;
}

}  // namespace

constinit const ShapeTraits box{
    .about = "A box.",
    .sizes = kSizes,
    .support = support,
    .volume = volume,
    .unit_moments = unit_moments,
    .rounded = rounded,
    .inner_radius = inner_radius,
    .bounds = bounds,
    .convex_piece = convex_piece,
    .cast = cast,
};

}  // namespace pantin::detail::shape_kinds
