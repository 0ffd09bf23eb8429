#include "engine/geometry/collide.hpp"

#include <algorithm>
#include <tuple>

#include "engine/base/invariants.hpp"
#include "engine/geometry/smooth.hpp"

namespace pantin::detail {
namespace {

constexpr std::size_t kMostOnSurface = 16;
constexpr std::uint32_t kNone = UINT32_MAX;
constexpr std::uint64_t kFeatureBits = 18;  // of two convex pieces; the triangle goes above

constexpr std::uint64_t kFromWithin = 0x1ff << 9;  // differs from any side of a clipped corner

constexpr std::array<std::uint32_t, 3> kCorners{0, 1, 2};
constexpr std::array<std::array<std::uint32_t, 2>, 3> kEdges{{{0, 1}, {1, 2}, {2, 0}}};

/// One triangle of a surface as a convex piece.
struct Tile {
  Tile(const Surface& s, std::uint32_t number) : index(number), points(triangle_of(s, number)) {
    const Vec3 n = normal_of(s, number);
    face = {0, 3, n, glm::dot(n, points[0])};
  }

  /// The neighbours across its edges; evaluated only for nearby triangles.
  Facing facing(const Surface& s) const {
    Facing f;
    f.normal = face.normal;
    for (std::uint32_t e = 0; e < 3; ++e) {
      f.outward[e] = glm::normalize(glm::cross(points[(e + 1) % 3] - points[e], face.normal));
      const std::uint32_t beyond = neighbour_of(s, index, e);
      f.beyond[e] = beyond == kNone ? face.normal : normal_of(s, beyond);
    }
    return f;
  }

  Convex convex() const {
    const Vec3 centre = (points[0] + points[1] + points[2]) / 3.0;
    const Real size = std::sqrt(glm::max(glm::dot(points[0] - centre, points[0] - centre),
                                         glm::dot(points[1] - centre, points[1] - centre)));
    return {points, {&face, 1}, kCorners, kEdges, {}, 0, centre, size};
  }

  std::uint32_t index;
  std::array<Vec3, 3> points;
  Face face;
};

Aabb bounds_of(const Convex& c) {
  if (c.smooth)
    return detail::bounds_of(*c.smooth, {c.origin, glm::quat_cast(c.rotation)}).grown(c.radius);
  Aabb box;
  for (Vec3 p : c.points) box.add(p);
  return box.grown(c.radius);
}

struct OnSurface {
  const Convex& a;
  const Surface& surface;
  Real margin;
  Aabb reach;  // of a, grown by the margin
  std::vector<ContactPoint>& out;
};

void collide_triangle(const OnSurface& k, std::uint32_t index) {
  Aabb box;
  for (Vec3 p : triangle_of(k.surface, index)) box.add(p);
  if (!box.overlaps(k.reach)) return;
  const Tile tile(k.surface, index);
  const Face& f = tile.face;
  // Above its plane by more than the margin: no point is close enough.
  const Real above = glm::dot(f.normal, k.a.extreme(-f.normal)) - f.offset;
  if (above - k.a.radius > k.margin) return;
  // All of it below the plane: back face.
  if (glm::dot(f.normal, k.a.extreme(f.normal)) < f.offset) return;
  const Facing facing = tile.facing(k.surface);
  const std::size_t first = k.out.size();
  collide_convex(k.a, tile.convex(), &facing, {k.margin, k.out});
  for (std::size_t i = first; i < k.out.size(); ++i)
    k.out[i].feature |= static_cast<std::uint64_t>(index) << kFeatureBits;
}

/// Pushes a out along the normal of one triangle, whose plane is taken as unbounded.
void push_out(const OnSurface& k, std::uint32_t index) {
  const Tile tile(k.surface, index);
  const std::size_t first = k.out.size();
  collide_plane(k.a, tile.face.normal, tile.face.offset, {glm::min(k.margin, Real(0)), k.out});
  std::sort(k.out.begin() + static_cast<std::ptrdiff_t>(first), k.out.end(),
            [](const ContactPoint& p, const ContactPoint& q) {
              return std::tie(p.gap, p.feature) < std::tie(q.gap, q.feature);
            });
  k.out.resize(glm::min(k.out.size(), first + 4));
  for (std::size_t i = first; i < k.out.size(); ++i)
    k.out[i].feature |= static_cast<std::uint64_t>(index) << kFeatureBits | kFromWithin;
}

/// Merges points found on several triangles, and reduces their number.
void tidy(std::vector<ContactPoint>& out, std::size_t first, Real size) {
  std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(),
            [](const ContactPoint& p, const ContactPoint& q) { return p.feature < q.feature; });
  drop_duplicates(out, first, 1e-6 * size);
  reduce_points(out, first, kMostOnSurface);
}

void collide_mesh(const OnSurface& k, std::vector<std::uint32_t>& triangles) {
  const Vec3 c = k.a.centre;
  const Surface& s = k.surface;
  if (glm::all(glm::lessThan(s.low, c)) && glm::all(glm::lessThan(c, s.high)))
    if (const NearestTile at = nearest_tile(s, c); at.inside) return push_out(k, at.index);
  triangles.clear();
  s.tree.query(k.reach, [&](std::uint32_t t) { triangles.push_back(t); });
  std::sort(triangles.begin(), triangles.end());
  for (std::uint32_t t : triangles) collide_triangle(k, t);
}

/// Pushes up corners below the ground along the triangle over them, at any depth.
void lift_corners(const OnSurface& k) {
  const Surface& s = k.surface;
  Patch scratch;
  const Corners corners = corners_towards(k.a, {0, -1, 0}, k.margin, scratch);
  for (std::uint32_t i = 0; i < corners.points.size(); ++i) {
    const Vec3 p = corners.points[i];
    if (p.x < s.low.x || p.x > s.high.x || p.z < s.low.z || p.z > s.high.z || p.y > s.high.y)
      continue;
    const std::uint32_t over = tile_at(s, p);
    const Vec3 n = normal_of(s, over);
    const Real height = glm::dot(n, p - triangle_of(s, over)[0]), gap = height - k.a.radius;
    if (height < 0 && gap <= k.margin)
      k.out.push_back(
          {p - k.a.radius * n, p - height * n, n, gap,
           static_cast<std::uint64_t>(over) << kFeatureBits | kFromWithin | corners.number(i)});
  }
}

void collide_height_field(const OnSurface& k) {
  const Surface& s = k.surface;
  const Aabb& box = k.reach;
  if (box.high.x < s.low.x || box.low.x > s.high.x || box.high.z < s.low.z ||
      box.low.z > s.high.z || box.low.y > s.high.y)
    return;
  lift_corners(k);
  const std::uint32_t x0 = cell_at(box.low.x, s.spacing_x, s.columns),
                      x1 = cell_at(box.high.x, s.spacing_x, s.columns),
                      z0 = cell_at(box.low.z, s.spacing_z, s.rows),
                      z1 = cell_at(box.high.z, s.spacing_z, s.rows);
  for (std::uint32_t z = z0; z <= z1; ++z)
    for (std::uint32_t x = x0; x <= x1; ++x) {
      const Vec3* p = &s.points[static_cast<std::size_t>(z) * s.columns + x];
      const Real top =
          glm::max(glm::max(p[0].y, p[1].y), glm::max(p[s.columns].y, p[s.columns + 1].y));
      if (box.low.y > top) continue;
      const std::uint32_t cell = z * (s.columns - 1) + x;
      collide_triangle(k, 2 * cell), collide_triangle(k, 2 * cell + 1);
    }
}

/// Transforms points from b's frame to the world.
void to_outside(const Pose& at, std::vector<ContactPoint>& out, std::size_t first) {
  const Mat3 rotation = glm::mat3_cast(at.rotation);
  for (std::size_t i = first; i < out.size(); ++i) {
    ContactPoint& p = out[i];
    p.on_a = at.position + rotation * p.on_a, p.on_b = at.position + rotation * p.on_b;
    p.normal = rotation * p.normal;
    PANTIN_ASSERT(is_unit(p.normal));
  }
}

bool is_skin(const Shape& shape) { return traits_of(shape.kind).shape_class == ShapeClass::skin; }
/// A skin that is not a convex piece.
bool is_bent(const Shape& shape) { return is_skin(shape) && !is_convex(shape); }

/// Collides two shapes of which at least one is a skin that is not convex.
void collide_bent(const PlacedShape& a, const PlacedShape& b, NarrowPhaseScratch& scratch,
                  const PointsOut& out) {
  const std::size_t first = out.points.size();
  const bool b_is_skin = is_bent(b.shape);
  const PlacedShape &skin = b_is_skin ? b : a, &other = b_is_skin ? a : b;
  const Quat back = glm::conjugate(skin.at.rotation);
  const Pose within{back * (other.at.position - skin.at.position), back * other.at.rotation};
  if (is_skin(other.shape) && !other.shape.surface->skin->is_solid_ellipsoid())
    collide_skins({*other.shape.surface, *skin.shape.surface, within}, scratch.skin, out);
  else
    collide_skin(*skin.shape.surface, {other.shape, within}, scratch.skin, out);
  to_outside(skin.at, out.points, first);
  if (b_is_skin) return;
  for (std::size_t i = first; i < out.points.size(); ++i) {
    std::swap(out.points[i].on_a, out.points[i].on_b);
    out.points[i].normal = -out.points[i].normal;
  }
}

}  // namespace

void collide(const PlacedShape& a, const PlacedShape& b, NarrowPhaseScratch& scratch,
             const PointsOut& out) {
  PANTIN_ASSERT(can_move(a.shape.kind));
  PANTIN_ASSERT(is_unit(a.at) && is_unit(b.at));
  if (is_bent(a.shape) || is_bent(b.shape)) return collide_bent(a, b, scratch, out);
  // In b's own frame numbers stay small, and surfaces need not be moved.
  const Quat back = glm::conjugate(b.at.rotation);
  const Pose within{back * (a.at.position - b.at.position), back * a.at.rotation};
  const Convex piece = convex_piece(a.shape, within, scratch.a);
  const std::size_t first = out.points.size();
  switch (traits_of(b.shape.kind).shape_class) {
    case ShapeClass::half_space:
      collide_plane(piece, {0, 1, 0}, 0, out);
      break;
    case ShapeClass::mesh:
    case ShapeClass::heights: {
      const Aabb reach = bounds_of(piece).grown(glm::max(out.margin, Real(0)));
      const OnSurface k{piece, *b.shape.surface, out.margin, reach, out.points};
      if (traits_of(b.shape.kind).shape_class == ShapeClass::mesh)
        collide_mesh(k, scratch.triangles);
      else
        collide_height_field(k);
      tidy(out.points, first, piece.size);
      break;
    }
    case ShapeClass::convex:
    case ShapeClass::skin:
      collide_convex(piece, convex_piece(b.shape, Pose{}, scratch.b), nullptr, out);
      break;
  }
  to_outside(b.at, out.points, first);
}

}  // namespace pantin::detail
