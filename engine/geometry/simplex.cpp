#include "engine/geometry/simplex.hpp"

namespace pantin::detail {
namespace {

/// Reduces an edge to its part nearest to the origin, with weights; returns the point.
Vec3 shrink_edge(Simplex& s) {
  const Vec3 d = s.v[1].w - s.v[0].w;
  const Real length = glm::dot(d, d), t = -glm::dot(s.v[0].w, d);
  if (!(t > 0)) {
    s.count = 1;
  } else if (!(t < length)) {
    s.v[0] = s.v[1], s.count = 1;
  } else {
    s.v[1].weight = t / length, s.v[0].weight = 1 - s.v[1].weight;
    return s.v[0].w + s.v[1].weight * d;
  }
  s.v[0].weight = 1;
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
    s.v[0].weight = wa / sum, s.v[1].weight = wb / sum, s.v[2].weight = wc / sum;
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

}  // namespace

bool shrink(Simplex& s, Vec3& point) {
  switch (s.count) {
    case 1:
      s.v[0].weight = 1;
      point = s.v[0].w;
      return true;
    case 2:
      point = shrink_edge(s);
      return true;
    case 3:
      point = shrink_triangle(s);
      return true;
    default:  // 4
      return shrink_tetrahedron(s, point);
  }
}

}  // namespace pantin::detail
