#include "engine/geometry/convex.hpp"

#include "engine/base/check.hpp"

namespace pantin {
namespace {

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

/// Faces of a box: 0, 1 at low and high x, and so on. The left face is that in whose round the edge
/// runs from its first corner to its second.
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
constexpr std::array<Pair, 1> kCapsuleEdge{{{0, 1}}};

Convex place_box(Vec3 half, const Pose& at, ConvexRoom& room) {
  const Mat3 turn = glm::mat3_cast(at.rotation);
  room.points.resize(8), room.faces.resize(6);
  const Vec3 x = half.x * turn[0], y = half.y * turn[1], z = half.z * turn[2];
  for (std::uint32_t i = 0; i < 8; ++i)
    room.points[i] = at.position + ((i & 1 ? x : -x) + (i & 2 ? y : -y) + (i & 4 ? z : -z));
  for (std::uint32_t f = 0; f < 6; ++f) {
    const int axis = static_cast<int>(f / 2);
    const Vec3 normal = f % 2 ? turn[axis] : -turn[axis];
    room.faces[f] = {4 * f, 4, normal, glm::dot(normal, at.position) + half[axis]};
  }
  return {room.points, room.faces, kBoxCorners, kBoxEdges,
          kBoxSides,   0,          at.position, glm::length(half)};
}

Convex place_hull(const Surface& hull, const Pose& at, ConvexRoom& room) {
  const Mat3 turn = glm::mat3_cast(at.rotation);
  room.points.resize(hull.points.size()), room.faces.resize(hull.faces.size());
  for (std::size_t i = 0; i < hull.points.size(); ++i)
    room.points[i] = at.position + turn * hull.points[i];
  for (std::size_t f = 0; f < hull.faces.size(); ++f) {
    const Face& face = hull.faces[f];
    const Vec3 normal = turn * face.normal;
    room.faces[f] = {face.first, face.count, normal, face.offset + glm::dot(normal, at.position)};
  }
  return {room.points,
          room.faces,
          hull.corners,
          hull.edges,
          hull.sides,
          0,
          at.position + turn * ((hull.low + hull.high) / 2.0),
          glm::length(hull.high - hull.low) / 2};
}

}  // namespace

Convex place(const Shape& shape, const Pose& at, ConvexRoom& room) {
  switch (shape.kind) {
    case ShapeKind::box:
      return place_box(shape.size, at, room);
    case ShapeKind::hull:
      return place_hull(*shape.surface, at, room);
    case ShapeKind::capsule: {
      const Vec3 half = at.rotation * Vec3(0, shape.size.y, 0);
      if (half == Vec3(0)) break;
      room.points.assign({at.position - half, at.position + half});
      return {room.points, {},           {},          kCapsuleEdge,
              {},          shape.size.x, at.position, shape.size.x + shape.size.y};
    }
    default:
      break;
  }
  room.points.assign(1, at.position);
  return {room.points, {}, {}, {}, {}, shape.size.x, at.position, shape.size.x};
}

Box bounds_of(const Shape& shape, const Pose& at) {
  const Mat3 turn = glm::mat3_cast(at.rotation);
  Vec3 half(shape.size.x), middle = at.position;
  const auto spread = [&](Vec3 extent) {
    return Vec3(glm::dot(glm::abs(Vec3(turn[0].x, turn[1].x, turn[2].x)), extent),
                glm::dot(glm::abs(Vec3(turn[0].y, turn[1].y, turn[2].y)), extent),
                glm::dot(glm::abs(Vec3(turn[0].z, turn[1].z, turn[2].z)), extent));
  };
  switch (shape.kind) {
    case ShapeKind::sphere:
      break;
    case ShapeKind::capsule:
      half += glm::abs(turn[1]) * shape.size.y;
      break;
    case ShapeKind::box:
      half = spread(shape.size);
      break;
    case ShapeKind::plane:
      return {Vec3(-1e300), Vec3(1e300)};
    case ShapeKind::hull:
    case ShapeKind::mesh:
    case ShapeKind::height_field:
      half = spread((shape.surface->high - shape.surface->low) / 2.0);
      middle += turn * ((shape.surface->high + shape.surface->low) / 2.0);
      break;
  }
  return {middle - half, middle + half};
}

namespace {

struct Vertex {
  Vec3 w{0};  // of a less of b
  std::uint32_t a = 0, b = 0;
  Real share = 1;
};

struct Simplex {
  Vertex v[4];
  int count = 0;
};

/// Leaves the part of an edge that is nearest to the origin, with its shares; returns the point.
Vec3 shrink_edge(Simplex& s) {
  const Vec3 d = s.v[1].w - s.v[0].w;
  const Real length = glm::dot(d, d), t = -glm::dot(s.v[0].w, d);
  if (!(t > 0)) {
    s.count = 1;
  } else if (!(t < length)) {
    s.v[0] = s.v[1], s.count = 1;
  } else {
    s.v[1].share = t / length, s.v[0].share = 1 - s.v[1].share;
    return s.v[0].w + s.v[1].share * d;
  }
  s.v[0].share = 1;
  return s.v[0].w;
}

/// The same for a triangle. [Ericson 2005, sec. 5.1.5]
Vec3 shrink_triangle(Simplex& s) {
  const auto edge = [&](int i, int j) {
    const Vertex a = s.v[i], b = s.v[j];
    s.v[0] = a, s.v[1] = b, s.count = 2;
    return shrink_edge(s);
  };
  const Vec3 a = s.v[0].w, b = s.v[1].w, c = s.v[2].w, ab = b - a, ac = c - a;
  const Vec3 n = glm::cross(ab, ac);
  const Real area = glm::dot(n, n);
  const Real scale = glm::max(glm::dot(ab, ab), glm::dot(ac, ac));
  // Twice signed areas of the triangles that the origin makes with each edge.
  const Real wa = glm::dot(n, glm::cross(b, c)), wb = glm::dot(n, glm::cross(c, a)),
             wc = glm::dot(n, glm::cross(a, b));
  if (area > 1e-30 * scale * scale && wa > 0 && wb > 0 && wc > 0) {
    const Real sum = wa + wb + wc;
    s.v[0].share = wa / sum, s.v[1].share = wb / sum, s.v[2].share = wc / sum;
    return glm::dot(n, a) / area * n;
  }
  // Nearest to an edge or a corner: the best of the three edges.
  const Simplex whole = s;
  Simplex best;
  Vec3 best_point(0);
  Real least = 1e300;
  for (int e = 0; e < 3; ++e) {
    s = whole;
    const Vec3 p = edge(e, (e + 1) % 3);
    if (glm::dot(p, p) < least) least = glm::dot(p, p), best = s, best_point = p;
  }
  s = best;
  return best_point;
}

/// The same for a tetrahedron; false if the origin is inside.
bool shrink_tetrahedron(Simplex& s, Vec3& point) {
  constexpr int kFaces[4][4] = {{0, 1, 2, 3}, {0, 3, 1, 2}, {0, 2, 3, 1}, {1, 3, 2, 0}};
  const Simplex whole = s;
  Simplex best;
  Real least = 1e300;
  bool outside = false;
  for (const auto& f : kFaces) {
    const Vec3 a = whole.v[f[0]].w, b = whole.v[f[1]].w, c = whole.v[f[2]].w, d = whole.v[f[3]].w;
    const Vec3 n = glm::cross(b - a, c - a);
    const Real origin = -glm::dot(n, a), apex = glm::dot(n, d - a);
    const Real scale = glm::length(n) * glm::length(d - a);
    const bool flat = std::abs(apex) <= 1e-14 * scale;
    if (!flat && origin * apex >= 0) continue;  // on the inner side
    outside = true;
    s.v[0] = whole.v[f[0]], s.v[1] = whole.v[f[1]], s.v[2] = whole.v[f[2]], s.count = 3;
    const Vec3 p = shrink_triangle(s);
    if (glm::dot(p, p) < least) least = glm::dot(p, p), best = s, point = p;
  }
  s = best;
  return outside;
}

bool shrink(Simplex& s, Vec3& point) {
  switch (s.count) {
    case 1:
      s.v[0].share = 1;
      point = s.v[0].w;
      return true;
    case 2:
      point = shrink_edge(s);
      return true;
    case 3:
      point = shrink_triangle(s);
      return true;
    default:
      return shrink_tetrahedron(s, point);
  }
}

Nearest finish(const Convex& a, const Convex& b, const Simplex& s, Vec3 v) {
  Nearest n;
  for (int i = 0; i < s.count; ++i) {
    n.on_a += s.v[i].share * a.points[s.v[i].a];
    n.on_b += s.v[i].share * b.points[s.v[i].b];
  }
  n.distance = glm::length(v);
  n.normal = v / n.distance;
  return n;
}

}  // namespace

Nearest nearest(const Convex& a, const Convex& b, Real limit) {
  // Nearer than this, rounding leaves no direction worth having.
  const Real touching = 1e-9 * (a.size + b.size);
  Simplex s;
  Vec3 v = a.centre - b.centre, last(0);
  if (v == Vec3(0)) v = Vec3(0, 1, 0);
  Simplex kept;
  Real kept_distance = 1e300;
  for (int round = 0; round < 64; ++round) {
    Vertex next;
    next.a = a.farthest(-v), next.b = b.farthest(v);
    next.w = a.points[next.a] - b.points[next.b];
    const Real ahead = glm::dot(v, next.w), length = glm::length(v);
    if (ahead > limit * length) {
      Nearest n;
      n.normal = v / length, n.distance = ahead / length, n.state = Nearest::State::beyond;
      return n;
    }
    if (s.count > 0) {
      if (kept_distance - ahead <= 1e-15 * kept_distance + 1e-16 * length * (a.size + b.size))
        break;
      bool known = false;
      for (int i = 0; i < s.count; ++i) known |= s.v[i].a == next.a && s.v[i].b == next.b;
      if (known) break;
    }
    s.v[s.count++] = next;
    if (!shrink(s, v) || glm::dot(v, v) <= touching * touching) {
      Nearest n;
      n.state = Nearest::State::overlap;
      return n;
    }
    if (glm::dot(v, v) >= kept_distance) break;  // no progress: rounding has the word
    kept = s, last = v, kept_distance = glm::dot(v, v);
  }
  return finish(a, b, kept, last);
}

}  // namespace pantin
