#include "engine/geometry/convex.hpp"

#include "engine/geometry/simplex.hpp"

namespace pantin::detail {
namespace {

Nearest closest_points(const Convex& a, const Convex& b, const Simplex& s, Vec3 v) {
  Nearest n;
  for (int i = 0; i < s.count; ++i) {
    n.on_a += s.v[i].weight * a.points[s.v[i].a];
    n.on_b += s.v[i].weight * b.points[s.v[i].b];
  }
  n.distance = glm::length(v);
  n.normal = v / n.distance;
  return n;
}

}  // namespace

Nearest nearest(const Convex& a, const Convex& b, Real limit) {
  // Below this distance rounding errors make the direction meaningless.
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
    if (glm::dot(v, v) >= kept_distance) break;  // no progress: rounding errors dominate
    kept = s, last = v, kept_distance = glm::dot(v, v);
  }
  return closest_points(a, b, kept, last);
}

}  // namespace pantin::detail
