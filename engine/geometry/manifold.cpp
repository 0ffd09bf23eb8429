#include "engine/geometry/manifold.hpp"

#include <algorithm>

#include "engine/geometry/smooth.hpp"

namespace pantin::detail {
namespace {

// Features: nine bits for each of two sides of a corner of the clipped face. Those of a are
// numbered from 0, those of b from 256.
constexpr std::uint32_t kOfB = 256;
constexpr std::uint64_t kClosest = 0x3ffff, kDeepest = 0x3fffe;

constexpr std::size_t kMostPoints = 8;     // of two convex pieces
constexpr std::size_t kMostCorners = 520;  // of a face of 256 cut by one of 256

/// A separating axis from b to a, with the separation of the cores.
struct Axis {
  enum class From : std::uint8_t { none, face_a, face_b, beyond, edges };
  Vec3 normal{0, 1, 0};
  Real gap = -1e300;  // m, below 0: overlap
  From from = From::none;
  std::uint32_t edge_a = 0, edge_b = 0;
};

// Tolerance for normals on the boundary of a triangle's wedge.
constexpr Real kWedgeTolerance = 1e-6;

}  // namespace

bool allows(const Facing& facing, Vec3 normal) {
  const Real up = glm::dot(normal, facing.normal);
  if (!(up > -kWedgeTolerance)) return false;
  for (int e = 0; e < 3; ++e) {
    const Real out = glm::dot(normal, facing.outward[e]);
    if (out <= kWedgeTolerance) continue;
    const Real rise = glm::dot(facing.beyond[e], facing.normal),
               lean = glm::dot(facing.beyond[e], facing.outward[e]);
    if (lean <= 0 || out * rise - up * lean > kWedgeTolerance) return false;
  }
  return true;
}

bool sticks_out(const Facing& facing, int edge) {
  return glm::dot(facing.beyond[edge], facing.outward[edge]) > 1e-6;
}

namespace {

// ---- Axis of least overlap ---------------------------------------------------------------------

Vec3 edge_of(const Convex& c, std::size_t e) {
  return c.points[c.edges[e][1]] - c.points[c.edges[e][0]];
}

void try_faces(const Convex& a, const Convex& b, const Facing* facing, Axis& best) {
  for (const Face& f : b.faces) {
    const Real gap = glm::dot(f.normal, a.points[a.farthest(-f.normal)]) - f.offset;
    if (gap > best.gap) best = {f.normal, gap, Axis::From::face_b, 0, 0};
  }
  // Of two equally good faces, that of b is preferred.
  const Real head_start = 1e-7 * (a.size + b.size);
  for (const Face& f : a.faces) {
    const Real gap = glm::dot(f.normal, b.points[b.farthest(-f.normal)]) - f.offset;
    if (gap > best.gap + head_start && (!facing || allows(*facing, -f.normal)))
      best = {-f.normal, gap, Axis::From::face_a, 0, 0};
  }
}

/// Normals of a triangle's neighbours are candidates at its edges.
void try_beyond(const Convex& a, const Convex& b, const Facing& facing, Axis& best) {
  for (int e = 0; e < 3; ++e) {
    if (!sticks_out(facing, e)) continue;
    const Vec3 n = facing.beyond[e];
    const Real gap = glm::dot(n, a.points[a.farthest(-n)] - b.points[static_cast<std::size_t>(e)]);
    if (gap > best.gap && allows(facing, n)) best = {n, gap, Axis::From::beyond, 0, 0};
  }
}

/// An edge with its adjacent faces, for the edge-edge test.
struct Ridge {
  Vec3 from, along;
  bool has_faces;          // false for a rod
  Vec3 left{0}, right{0};  // normals of the faces; zero for a rod
};

Ridge ridge_of(const Convex& c, std::size_t e) {
  Ridge r{c.points[c.edges[e][0]], edge_of(c, e), !c.sides.empty()};
  if (r.has_faces) r.left = c.faces[c.sides[e][0]].normal, r.right = c.faces[c.sides[e][1]].normal;
  return r;
}

/// Whether the arcs that two edges make on the sphere of normals cross, so that the edges make a
/// face of the difference of the solids. An edge without faces crosses wherever the other does.
/// [Gregorius 2013, "The separating axis test between convex polyhedra"]
bool arcs_cross(const Ridge& a, const Ridge& b) {
  const Real left_b = glm::dot(b.left, a.along);
  if (b.has_faces && left_b * glm::dot(b.right, a.along) >= 0) return false;
  const Real right_a = glm::dot(a.right, b.along);
  if (a.has_faces && glm::dot(a.left, b.along) * right_a >= 0) return false;
  return !(a.has_faces && b.has_faces && left_b * right_a >= 0);
}

/// The direction from b to a at right angles to both edges; zero if they are parallel, or if it
/// would lead through one of the solids. `outward` is of a triangle's edge, else zero.
Vec3 across_edges(const Ridge& a, const Ridge& b, Vec3 outward, Vec3 apart) {
  Vec3 n = glm::cross(a.along, b.along);
  const Real length = glm::length(n);
  if (!(length > 1e-6 * glm::length(a.along) * glm::length(b.along))) return Vec3(0);
  n /= length;
  const Vec3 out_a = a.left + a.right, out_b = b.left + b.right + outward;
  const Vec3 outer = out_b != Vec3(0) ? out_b : out_a != Vec3(0) ? -out_a : apart;
  if (glm::dot(n, outer) < 0) n = -n;
  return out_a != Vec3(0) && glm::dot(n, out_a) > 0 ? Vec3(0) : n;
}

void try_edges(const Convex& a, const Convex& b, const Facing* facing, Axis& best) {
  for (std::uint32_t j = 0; j < b.edges.size(); ++j) {
    const Ridge rb = ridge_of(b, j);
    for (std::uint32_t i = 0; i < a.edges.size(); ++i) {
      const Ridge ra = ridge_of(a, i);
      if (!arcs_cross(ra, rb)) continue;
      const Vec3 n =
          across_edges(ra, rb, facing ? facing->outward[j] : Vec3(0), a.centre - b.centre);
      if (n == Vec3(0)) continue;
      const Real gap = glm::dot(n, ra.from - rb.from);
      if (gap > best.gap && (!facing || allows(*facing, n)))
        best = {n, gap, Axis::From::edges, i, j};
    }
  }
}

/// A direction perpendicular to an edge, if there is one; mostly upwards.
Vec3 any_normal(const Convex& a, const Convex& b) {
  const Convex& c = a.edges.empty() ? b : a;
  if (c.edges.empty()) return {0, 1, 0};
  const Vec3 d = glm::normalize(edge_of(c, 0));
  const Vec3 side = std::abs(d.y) < 0.9 ? Vec3(0, 1, 0) : Vec3(1, 0, 0);
  return glm::normalize(side - glm::dot(side, d) * d);
}

/// The axis of least penetration of two cores (separating axis test).
Axis least_overlap(const Convex& a, const Convex& b, const Facing* facing) {
  Axis face, edges;
  try_faces(a, b, facing, face);
  if (facing) try_beyond(a, b, *facing, face);
  try_edges(a, b, facing, edges);
  // Face contacts give several persistent points, so an edge contact must be clearly better.
  const bool clear = edges.gap > face.gap + 0.01 * std::abs(face.gap) + 1e-7 * (a.size + b.size);
  if (edges.from != Axis::From::none && clear) return edges;
  if (face.from != Axis::From::none) return face;
  face.normal = any_normal(a, b);
  face.gap = glm::dot(face.normal, a.points[a.farthest(-face.normal)]) -
             glm::dot(face.normal, b.points[b.farthest(face.normal)]);
  return face;
}

// ---- Points ------------------------------------------------------------------------------------

/// A corner of the face that is cut, with the labels of its two sides.
struct Corner {
  Vec3 point;
  std::uint32_t in, out;
};

struct Polygon {
  Corner corners[kMostCorners];
  std::size_t count = 0;

  void add(const Corner& c) {
    if (count < kMostCorners) corners[count++] = c;
  }
};

const Face* face_towards(const Convex& c, Vec3 direction) {
  const Face* best = c.faces.empty() ? nullptr : &c.faces.front();  // even if all are NaN
  Real most = -2;
  for (const Face& f : c.faces)
    if (const Real m = glm::dot(f.normal, direction); m > most) most = m, best = &f;
  return best;
}

std::uint32_t corner_of(const Convex& c, const Face& f, std::uint32_t i) {
  return c.corners[f.first + i % f.count];
}

/// The face, edge or point of the core that faces `direction`.
void feature_towards(const Convex& c, Vec3 direction, std::uint32_t label, Polygon& p) {
  p.count = 0;
  if (const Face* f = face_towards(c, direction)) {
    for (std::uint32_t i = 0; i < f->count; ++i)
      p.add({c.points[corner_of(c, *f, i)], label + corner_of(c, *f, i + f->count - 1),
             label + corner_of(c, *f, i)});
    return;
  }
  for (std::uint32_t i = 0; i < c.points.size(); ++i) p.add({c.points[i], label + i, label + i});
}

/// The half-space side . x <= offset, by a face's edge.
struct EdgePlane {
  Vec3 side;            // unit, outwards
  Real offset;          // m
  Real slack;           // m: tolerance of the clip
  std::uint32_t label;  // of the edge
};

/// Clips a polygon to a half-space.
void cut(const Polygon& from, const EdgePlane& by, Polygon& to) {
  const Real slack = by.slack;
  const std::uint32_t label = by.label;
  to.count = 0;
  const std::size_t edges = from.count == 2 ? 1 : from.count;
  const auto height = [&](const Corner& c) { return glm::dot(by.side, c.point) - by.offset; };
  if (from.count == 2 && height(from.corners[0]) <= slack) to.add(from.corners[0]);
  for (std::size_t i = 0; i < edges; ++i) {
    const Corner &p = from.corners[i], &q = from.corners[(i + 1) % from.count];
    const Real hp = height(p), hq = height(q);
    if ((hp <= slack) != (hq <= slack)) {
      const Real t = glm::clamp(hp / (hp - hq), Real(0), Real(1));
      const bool leaving = hp <= slack;
      to.add({p.point + t * (q.point - p.point), leaving ? p.out : label, leaving ? label : p.out});
    }
    if (hq <= slack) to.add(q);
  }
}

struct Clip {
  const Convex& a;
  const Convex& b;
  Vec3 normal;  // from b to a
  Real margin;
  const Facing* facing;
  std::vector<ContactPoint>& out;
  // Points left to a neighbour of the triangle: whether there are any, and the deepest, unless the
  // piece covers the whole triangle.
  bool left_out = false;
  ContactPoint deepest{{}, {}, {}, 1e300, 0};
};

std::uint64_t feature_of(const Corner& c) { return static_cast<std::uint64_t>(c.in) << 9 | c.out; }

/// Whether a clipped corner also belongs to coplanar neighbours of the triangle.
bool goes_on(const Facing* facing, const Corner& c) {
  if (!facing) return false;
  const auto flat = [&](std::uint32_t side) {
    return 1 - glm::dot(facing->normal, facing->beyond[side - kOfB]) < 1e-9;
  };
  const bool in = c.in >= kOfB, out = c.out >= kOfB;
  return (in || out) && (!in || flat(c.in)) && (!out || flat(c.out));
}

/// The piece whose face clips the other's feature.
enum class Cutter : std::uint8_t { a, b };

/// Clips the feature of one piece that faces the other by the side planes of the other's face, and
/// measures gaps along the normal.
void clip_against(Clip& k, Cutter by) {
  const bool b_is_cutter = by == Cutter::b;
  const Convex& cutter = b_is_cutter ? k.b : k.a;
  const Convex& other = b_is_cutter ? k.a : k.b;
  const Vec3 out_of = b_is_cutter ? k.normal : -k.normal;
  const Face& face = *face_towards(cutter, out_of);
  const Real facing = glm::dot(face.normal, out_of);
  if (!(facing >= 0.05)) return;  // seen edge-on, or undefined
  Polygon polygons[2];
  Polygon *from = &polygons[0], *to = &polygons[1];
  feature_towards(other, -out_of, b_is_cutter ? 0 : kOfB, *from);
  const Real slack = 1e-9 * (k.a.size + k.b.size);
  for (std::uint32_t i = 0; i < face.count; ++i) {
    const std::uint32_t first = corner_of(cutter, face, i);
    const Vec3 u = cutter.points[first], v = cutter.points[corner_of(cutter, face, i + 1)];
    const Vec3 side = glm::normalize(glm::cross(v - u, out_of));
    cut(*from, {side, glm::dot(side, u), slack, (b_is_cutter ? kOfB : 0) + first}, *to);
    std::swap(from, to);
    if (from->count == 0) return;
  }
  std::size_t covered = 0;
  for (std::size_t i = 0; i < from->count; ++i) {
    const Corner& c = from->corners[i];
    const Real apart = (glm::dot(face.normal, c.point) - face.offset) / facing;
    const Real gap = apart - k.a.radius - k.b.radius;
    if (gap > k.margin) continue;
    const Vec3 opposite = c.point - apart * out_of;
    const Vec3 on_a = b_is_cutter ? c.point : opposite, on_b = b_is_cutter ? opposite : c.point;
    const ContactPoint p{on_a - k.a.radius * k.normal, on_b + k.b.radius * k.normal, k.normal, gap,
                         feature_of(c)};
    if (!goes_on(k.facing, c)) {
      k.out.push_back(p);
      continue;
    }
    k.left_out = true;
    covered += c.in >= kOfB && c.out >= kOfB;
    if (gap < k.deepest.gap) k.deepest = p;
  }
  if (covered == 3) k.deepest.gap = 1e300;
}

/// The point of segment p to q nearest to x.
Vec3 nearest_on(Vec3 p, Vec3 q, Vec3 x) {
  const Vec3 d = q - p;
  const Real length = glm::dot(d, d);
  return length > 0 ? p + glm::clamp(glm::dot(x - p, d) / length, Real(0), Real(1)) * d : p;
}

/// Two parallel capsules touch at both ends of their overlap, each end with its own normal.
void clip_rods(const Clip& k) {
  const Vec3 da = edge_of(k.a, 0), db = edge_of(k.b, 0);
  if (glm::length(glm::cross(da, db)) > 0.3 * glm::length(da) * glm::length(db)) return;
  const auto add = [&](Vec3 on_a, Vec3 on_b, std::uint64_t feature) {
    const Vec3 way = on_a - on_b;
    const Real apart = glm::length(way), gap = apart - k.a.radius - k.b.radius;
    if (!(apart > 1e-9 * (k.a.size + k.b.size)) || gap > k.margin) return;
    const Vec3 n = way / apart;
    k.out.push_back({on_a - k.a.radius * n, on_b + k.b.radius * n, n, gap, feature});
  };
  // An end counts where the other rod is beside it.
  const auto beside = [](Vec3 p, Vec3 q, Vec3 x) {
    const Vec3 d = q - p;
    const Real t = glm::dot(x - p, d) / glm::dot(d, d);
    return t >= -1e-9 && t <= 1 + 1e-9;
  };
  for (std::uint32_t i = 0; i < 2; ++i) {
    const Vec3 end = k.a.points[i];
    if (beside(k.b.points[0], k.b.points[1], end))
      add(end, nearest_on(k.b.points[0], k.b.points[1], end), i);
  }
  for (std::uint32_t i = 0; i < 2; ++i) {
    const Vec3 end = k.b.points[i];
    if (beside(k.a.points[0], k.a.points[1], end))
      add(nearest_on(k.a.points[0], k.a.points[1], end), end, kOfB + i);
  }
}

void clip(Clip& k) {
  if (k.a.points.size() < 2 || k.b.points.size() < 2) return;
  if (k.a.faces.empty() && k.b.faces.empty()) return clip_rods(k);
  if (k.a.faces.empty() || k.b.faces.empty())
    return clip_against(k, k.a.faces.empty() ? Cutter::b : Cutter::a);
  const Real facing_a = -glm::dot(face_towards(k.a, -k.normal)->normal, k.normal);
  const Real facing_b = glm::dot(face_towards(k.b, k.normal)->normal, k.normal);
  clip_against(k, facing_b + 0.01 >= facing_a ? Cutter::b : Cutter::a);
}

/// A point of each piece.
struct PointPair {
  Vec3 on_a, on_b;
};

/// The points of two lines that are nearest to each other, for edges that cross.
PointPair cross_edges(const Convex& a, const Convex& b, const Axis& axis) {
  const Vec3 pa = a.points[a.edges[axis.edge_a][0]], pb = b.points[b.edges[axis.edge_b][0]];
  const Vec3 da = edge_of(a, axis.edge_a), db = edge_of(b, axis.edge_b), r = pa - pb;
  const Real aa = glm::dot(da, da), bb = glm::dot(db, db), ab = glm::dot(da, db);
  const Real whole = aa * bb - ab * ab;
  const Real s = whole > 0 ? (ab * glm::dot(db, r) - bb * glm::dot(da, r)) / whole : 0;
  const Vec3 on_a = pa + glm::clamp(s, Real(0), Real(1)) * da;
  return {on_a, on_a - axis.gap * axis.normal};
}

/// The deepest points along an axis of overlap.
PointPair deepest_points(const Convex& a, const Convex& b, const Axis& axis) {
  const Vec3 n = axis.normal;
  if (axis.from == Axis::From::edges) return cross_edges(a, b, axis);
  if (axis.from == Axis::From::face_a) {
    const Vec3 on_b = b.points[b.farthest(n)];
    return {on_b + axis.gap * n, on_b};
  }
  const Vec3 on_a = a.points[a.farthest(-n)];
  return {on_a, on_a - axis.gap * n};
}

void collide_overlapping(const Convex& a, const Convex& b, const Facing* facing,
                         const PointsOut& out) {
  const auto& [margin, points] = out;
  const Axis axis = least_overlap(a, b, facing);
  const Vec3 n = axis.normal;
  const Real gap = axis.gap - a.radius - b.radius, slack = 1e-6 * (a.size + b.size);
  if (gap > margin) return;
  const std::size_t first = points.size();
  Clip k{a, b, n, margin, facing, points};
  if (axis.from != Axis::From::beyond) clip(k);
  Real least = 1e300;
  for (std::size_t i = first; i < points.size(); ++i) least = glm::min(least, points[i].gap);
  // A neighbour that a does not intersect cannot take over its points.
  if (k.deepest.gap < least - slack) points.push_back(k.deepest), least = k.deepest.gap;
  // The deepest vertex may be beside the reference face; then a neighbouring triangle has it.
  if (least > gap + slack && !(facing && (k.left_out || least < 1e300))) {
    const auto [on_a, on_b] = deepest_points(a, b, axis);
    points.push_back({on_a - a.radius * n, on_b + b.radius * n, n, gap, kDeepest});
  }
  reduce_points(points, first, kMostPoints);
}

/// Uses a face of either piece that is almost perpendicular to the line between the nearest points
/// and keeps the pieces as far apart: its normal has fewer rounding errors.
void snap_to_face(const Convex& a, const Convex& b, Nearest& near) {
  const Real slack = 1e-9 * near.distance + 1e-12 * (a.size + b.size);
  if (const Face* f = face_towards(b, near.normal);
      f && glm::dot(f->normal, near.normal) > 1 - 1e-9) {
    const Real gap = glm::dot(f->normal, a.points[a.farthest(-f->normal)]) - f->offset;
    if (gap >= near.distance - slack) {
      near.normal = f->normal, near.distance = gap;
      near.on_b = near.on_a - gap * f->normal;
      return;
    }
  }
  if (const Face* f = face_towards(a, -near.normal);
      f && glm::dot(f->normal, near.normal) < -1 + 1e-9) {
    const Real gap = glm::dot(f->normal, b.points[b.farthest(-f->normal)]) - f->offset;
    if (gap < near.distance - slack) return;
    near.normal = -f->normal, near.distance = gap;
    near.on_a = near.on_b - gap * f->normal;
  }
}

}  // namespace

void collide_convex(const Convex& a, const Convex& b, const Facing* facing, const PointsOut& out) {
  const auto& [margin, points] = out;
  if (a.smooth || b.smooth) return touch_smooth(a, b, facing, out);
  const Real radii = a.radius + b.radius;
  Nearest near = nearest(a, b, margin + radii);
  if (near.state == Nearest::State::beyond) return;
  if (near.state == Nearest::State::overlap) return collide_overlapping(a, b, facing, out);
  snap_to_face(a, b, near);
  const Real gap = near.distance - radii;
  if (gap > margin) return;
  const std::size_t first = points.size();
  if (facing && !allows(*facing, near.normal)) {
    // A concave or flat edge: only points above the triangle itself count.
    if (glm::dot(near.normal, facing->normal) < 0) return;
    Clip over{a, b, facing->normal, margin, facing, points};
    clip(over);
    return reduce_points(points, first, kMostPoints);
  }
  Clip k{a, b, near.normal, margin, facing, points};
  clip(k);
  Real least = 1e300;
  for (std::size_t i = first; i < points.size(); ++i) least = glm::min(least, points[i].gap);
  if (!k.left_out && least > gap + 1e-6 * (a.size + b.size))
    points.push_back({near.on_a - a.radius * near.normal, near.on_b + b.radius * near.normal,
                      near.normal, gap, kClosest});
  drop_duplicates(points, first, 1e-7 * (a.size + b.size));
  reduce_points(points, first, kMostPoints);
}

void collide_plane(const Convex& a, Vec3 n, Real offset, const PointsOut& out) {
  Patch scratch;
  const Corners corners = corners_towards(a, -n, out.margin, scratch);
  for (std::uint32_t i = 0; i < corners.points.size(); ++i) {
    const Vec3 p = corners.points[i];
    const Real height = glm::dot(n, p) - offset, gap = height - a.radius;
    if (gap <= out.margin)
      out.points.push_back({p - a.radius * n, p - height * n, n, gap, corners.number(i)});
  }
}

}  // namespace pantin::detail
