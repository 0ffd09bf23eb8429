#include "engine/render/surface_mesh.hpp"

#include <algorithm>
#include <array>

#include "engine/geometry/kinds.hpp"
#include "engine/geometry/skin_model.hpp"

namespace pantin::detail {
namespace {

std::uint32_t add_vertex(SurfaceMesh& to, Vec3 corner, Vec3 normal) {
  MeshVertex v{};
  for (int k = 0; k < 3; ++k) {
    v.corner[k] = static_cast<float>(corner[k]);
    v.normal[k] = static_cast<float>(normal[k]);
  }
  to.vertices.push_back(v);
  return static_cast<std::uint32_t>(to.vertices.size() - 1);
}

/// The normal of a smooth shape near a corner of a face, taken within the face.
Vec3 smooth_normal(const Shape& shape, Vec3 corner, Vec3 middle, Vec3 normal) {
  constexpr Real kInwards = 0.01, kAbove = 1e-4;
  const Vec3 at = corner + kInwards * (middle - corner);
  const auto near = closest(shape, at + kAbove * glm::distance(middle, corner) * normal, 1e300);
  return near ? near->normal : normal;
}

/// With the faces' own normals, or with those of the shape that they approximate.
void add_faces(const Surface& surface, const Shape* smooth, SurfaceMesh& to) {
  for (const Face& face : surface.faces) {
    const auto first = static_cast<std::uint32_t>(to.vertices.size());
    const auto corner = [&](std::uint32_t i) {
      return surface.points[surface.corners[face.first + i]];
    };
    Vec3 middle(0);
    for (std::uint32_t i = 0; i < face.count; ++i) middle += corner(i) / Real(face.count);
    for (std::uint32_t i = 0; i < face.count; ++i)
      add_vertex(to, corner(i),
                 smooth ? smooth_normal(*smooth, corner(i), middle, face.normal) : face.normal);
    for (std::uint32_t i = 2; i < face.count; ++i)
      to.indices.insert(to.indices.end(), {first, first + i - 1, first + i});
  }
}

/// The triangles of a height field, split as in triangle_of().
std::vector<std::uint32_t> ground_triangles(const Surface& field) {
  std::vector<std::uint32_t> corners;
  for (std::uint32_t row = 0; row + 1 < field.rows; ++row) {
    for (std::uint32_t column = 0; column + 1 < field.columns; ++column) {
      const std::uint32_t at = row * field.columns + column, below = at + field.columns;
      corners.insert(corners.end(), {at, below, below + 1, at, below + 1, at + 1});
    }
  }
  return corners;
}

/// A wall below a border segment, from one point to the next; the border runs clockwise seen from
/// above.
void add_wall(const Surface& field, std::uint32_t from, std::uint32_t next, SurfaceMesh& to) {
  const Vec3 a = field.points[from], b = field.points[next];
  const Real bottom = field.low.y - rim_of(field);
  const Vec3 normal = glm::normalize(Vec3{b.z - a.z, 0, a.x - b.x});
  const std::uint32_t first = add_vertex(to, a, normal);
  add_vertex(to, b, normal);
  add_vertex(to, {b.x, bottom, b.z}, normal);
  add_vertex(to, {a.x, bottom, a.z}, normal);
  to.indices.insert(to.indices.end(), {first, first + 1, first + 2, first, first + 2, first + 3});
}

void add_ground(const Surface& field, SurfaceMesh& to) {
  to.indices = ground_triangles(field);
  std::vector<Vec3> normals(field.points.size(), Vec3{0});
  for (std::size_t i = 0; i + 2 < to.indices.size(); i += 3) {
    const std::uint32_t* t = &to.indices[i];
    const Vec3 a = field.points[t[0]], b = field.points[t[1]], c = field.points[t[2]];
    const Vec3 wide = glm::cross(b - a, c - a);  // area-weighted
    for (int k = 0; k < 3; ++k) normals[t[k]] += wide;
  }
  for (std::size_t i = 0; i < field.points.size(); ++i) {
    const Real length = glm::length(normals[i]);
    add_vertex(to, field.points[i], length > 0 ? normals[i] / length : Vec3{0, 1, 0});
  }
  const std::uint32_t columns = field.columns, rows = field.rows;
  const std::uint32_t last = (rows - 1) * columns;
  for (std::uint32_t c = 0; c + 1 < columns; ++c) {
    add_wall(field, c, c + 1, to);
    add_wall(field, last + c + 1, last + c, to);
  }
  for (std::uint32_t r = 0; r + 1 < rows; ++r) {
    add_wall(field, (r + 1) * columns, r * columns, to);
    add_wall(field, (r + 1) * columns - 1, (r + 2) * columns - 1, to);
  }
}

}  // namespace

namespace {

/// Single-sided if the skin is closed, else double-sided.
void add_skin(const SkinModel& model, SurfaceMesh& to) {
  const nurbs::Tessellation& t = model.tiles;
  for (std::size_t i = 0; i < t.points.size(); ++i) add_vertex(to, t.points[i], t.normals[i]);
  for (const auto& tile : t.triangles)
    to.indices.insert(to.indices.end(), tile.begin(), tile.end());
  if (model.is_closed) return;
  const auto back = static_cast<std::uint32_t>(t.points.size());
  for (std::size_t i = 0; i < t.points.size(); ++i) add_vertex(to, t.points[i], -t.normals[i]);
  for (const auto& tile : t.triangles)
    to.indices.insert(to.indices.end(), {back + tile[0], back + tile[2], back + tile[1]});
}

void add_triangle(Surface& to, const std::array<std::uint32_t, 3>& corners) {
  const Vec3 a = to.points[corners[0]], b = to.points[corners[1]], c = to.points[corners[2]];
  const Vec3 wide = glm::cross(b - a, c - a);
  const Real area = glm::length(wide), size = glm::length(to.high - to.low);
  if (!(area > 1e-12 * size * size)) return;  // parameters that map to one point
  const Vec3 normal = wide / area;
  to.faces.push_back(
      {static_cast<std::uint32_t>(to.corners.size()), 3, normal, glm::dot(normal, a)});
  to.corners.insert(to.corners.end(), corners.begin(), corners.end());
}

}  // namespace

std::shared_ptr<const Surface> tessellate(const Shape& shape) {
  constexpr std::uint32_t kAround = 48,
                          kRows = 25;  // odd: no row of directions is horizontal, where straight
                                       // sides are ambiguous
  const auto support = traits_of(shape.kind).support;
  if (!support) return nullptr;
  const Aabb box = bounds_of(shape, Pose{});
  const Vec3 half = (box.high - box.low) / 2.0;
  if (!(half.x > 0 && half.y > 0 && half.z > 0)) return nullptr;
  const auto made = std::make_shared<Surface>();
  made->low = box.low, made->high = box.high;
  for (std::uint32_t row = 0; row <= kRows; ++row)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const Real rise = kPi * (Real(row) / kRows - 0.5), around = 2 * kPi * i / kAround;
      const bool is_pole = row == 0 || row == kRows;
      const Real out = is_pole ? 0 : std::cos(rise);
      const Vec3 d(out * std::cos(around), std::sin(rise), out * std::sin(around));
      made->points.push_back(support(shape, d / half));
    }
  for (std::uint32_t row = 0; row < kRows; ++row)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const std::uint32_t next = (i + 1) % kAround, low = row * kAround, high = low + kAround;
      add_triangle(*made, {low + i, high + i, high + next});
      add_triangle(*made, {low + i, high + next, low + next});
    }
  return made;
}

Real rim_of(const Surface& field) {
  return 0.03 * std::max(field.high.x - field.low.x, field.high.z - field.low.z);
}

SurfaceMesh make_surface_mesh(const Surface& surface, const Shape* smooth) {
  SurfaceMesh mesh;
  if (surface.model) {
    add_skin(*surface.model, mesh);
    return mesh;
  }
  const std::size_t grid = std::size_t{surface.columns} * surface.rows;
  if (grid > 0 && surface.points.size() == grid)
    add_ground(surface, mesh);
  else
    add_faces(surface, smooth, mesh);
  return mesh;
}

}  // namespace pantin::detail
