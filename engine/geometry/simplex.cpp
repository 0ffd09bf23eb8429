#include "engine/geometry/simplex.hpp"

namespace pantin::detail {
namespace {

/// The part of a simplex nearest to the origin: its vertices by number, with weights.
struct Part {
  int count = 0;
  int at[3] = {0, 0, 0};
  Real weight[3] = {1, 1, 1};
  Vec3 point{0};
};

/// The part of an edge.
Part part_of_edge(const Simplex& s, int i, int j) {
  const Vec3 &a = s.v[i].w, d = s.v[j].w - a;
  const Real length = glm::dot(d, d), t = -glm::dot(a, d);
  if (!(t > 0)) return {1, {i}, {1}, a};
  if (!(t < length)) return {1, {j}, {1}, s.v[j].w};
  const Real of_j = t / length;
  return {2, {i, j}, {1 - of_j, of_j}, a + of_j * d};
}

/// The same of a triangle. [Ericson 2005, sec. 5.1.5]
Part part_of_triangle(const Simplex& s, int i, int j, int k) {
  const Vec3 &a = s.v[i].w, &b = s.v[j].w, &c = s.v[k].w, ab = b - a, ac = c - a;
  const Vec3 n = glm::cross(ab, ac);
  const Real area = glm::dot(n, n);
  const Real scale = glm::max(glm::dot(ab, ab), glm::dot(ac, ac));
  // Twice signed areas of the triangles that the origin makes with each edge.
  const Real wa = glm::dot(n, glm::cross(b, c)), wb = glm::dot(n, glm::cross(c, a)),
             wc = glm::dot(n, glm::cross(a, b));
  if (area > 1e-30 * scale * scale && wa > 0 && wb > 0 && wc > 0) {
    const Real sum = wa + wb + wc;
    return {3, {i, j, k}, {wa / sum, wb / sum, wc / sum}, glm::dot(n, a) / area * n};
  }
  // Nearest to an edge or a corner: the best of the three edges.
  Part best;
  Real least = 1e300;
  const int edges[3][2] = {{i, j}, {j, k}, {k, i}};
  for (const auto& [from, to] : edges) {
    const Part part = part_of_edge(s, from, to);
    if (const Real far = glm::dot(part.point, part.point); far < least) least = far, best = part;
  }
  return best;
}

/// The same of a tetrahedron; nothing if the origin is inside.
Part part_of_tetrahedron(const Simplex& s) {
  constexpr int kFaces[4][4] = {{0, 1, 2, 3}, {0, 3, 1, 2}, {0, 2, 3, 1}, {1, 3, 2, 0}};
  Part best;
  Real least = 1e300;
  for (const auto& f : kFaces) {
    const Vec3 &a = s.v[f[0]].w, &b = s.v[f[1]].w, &c = s.v[f[2]].w, &d = s.v[f[3]].w;
    const Vec3 n = glm::cross(b - a, c - a);
    const Real origin = -glm::dot(n, a), apex = glm::dot(n, d - a);
    const Real square = glm::dot(n, n) * glm::dot(d - a, d - a);
    const bool flat = apex * apex <= 1e-28 * square;
    if (!flat && origin * apex >= 0) continue;  // on the inner side
    const Part part = part_of_triangle(s, f[0], f[1], f[2]);
    if (const Real far = glm::dot(part.point, part.point); far < least) least = far, best = part;
  }
  return best;
}

/// Leaves only a part of a simplex. False if there is none.
bool keep(Simplex& s, const Part& part, Vec3& point) {
  const Vertex kept[3] = {s.v[part.at[0]], s.v[part.at[1]], s.v[part.at[2]]};
  s.count = part.count, point = part.point;
  for (int i = 0; i < part.count; ++i) s.v[i] = kept[i], s.v[i].weight = part.weight[i];
  return part.count > 0;
}

}  // namespace

bool shrink(Simplex& s, Vec3& point) {
  switch (s.count) {
    case 1:
      s.v[0].weight = 1;
      point = s.v[0].w;
      return true;
    case 2:
      return keep(s, part_of_edge(s, 0, 1), point);
    case 3:
      return keep(s, part_of_triangle(s, 0, 1, 2), point);
    default:  // 4
      return keep(s, part_of_tetrahedron(s), point);
  }
}

}  // namespace pantin::detail
