// All pairs of two curves, or of a curve and a face, that face one another.
#include <algorithm>
#include <cmath>

#include "engine/nurbs/curve_pair.hpp"

namespace pantin::detail::nurbs {
namespace {

// Of the smaller size: pairs nearer than this are one.
constexpr Real kSame = 1e-6;
// A turn beyond which a cell tells nothing of where its tangents point.
constexpr Real kAnyTurn = 0.95;

class Found {
 public:
  Found(CurveReach to, Real size) : to_(to), same_(kSame * size) {}

  /// Keeps a pair; of those that do not fit in, the nearest.
  void keep(const CurveContact& pair) {
    if (pair.status != ContactStatus::found || !(pair.least_curvature > 0)) return;
    if (!(std::abs(pair.gap) <= to_.reach) || is_known(pair)) return;
    std::size_t at = count_;
    const auto farther = [](const CurveContact& p, const CurveContact& q) {
      return std::abs(p.gap) > std::abs(q.gap);
    };
    if (count_ == to_.out.size()) {
      if (count_ == 0 || !farther(to_.out[count_ - 1], pair)) return;
      --at;
    } else {
      ++count_;
    }
    for (; at > 0 && farther(to_.out[at - 1], pair); --at) to_.out[at] = to_.out[at - 1];
    to_.out[at] = pair;
  }
  std::size_t count() const { return count_; }

 private:
  bool is_known(const CurveContact& pair) const {
    for (std::size_t i = 0; i < count_; ++i)
      if (glm::distance(to_.out[i].on_b, pair.on_b) < same_ &&
          glm::dot(to_.out[i].normal, pair.normal) > 0.5)
        return true;
    return false;
  }
  CurveReach to_;
  Real same_;
  std::size_t count_ = 0;
};

/// Where the tangents of a cell point.
struct Cone {
  Vec3 along{0};  // unit
  Real sine = 1;  // of the largest angle from it; above kAnyTurn: any
};
Cone cone_of(const Wire& wire, const Wire::Leaf& leaf) {
  const Vec3 tangent = evaluate(wire.curve(), leaf.t.middle(), 1)[1];
  const Real speed = glm::length(tangent);
  const Real change = leaf.second / (speed * leaf.t.width() / 2);
  return {tangent / speed, change < kAnyTurn ? change : 1};
}

bool may_oppose(const Cone& a, const Cone& b) {
  if (a.sine > kAnyTurn || b.sine > kAnyTurn) return true;
  const Real cosine = -glm::dot(a.along, b.along);
  return std::acos(std::clamp(cosine, -1.0, 1.0)) <= std::asin(a.sine) + std::asin(b.sine) + 1e-6;
}

/// May both have a common normal, of a curve's tangents with a face's normals?
bool may_touch(const Cone& a, Vec3 normal, Real turn) {
  if (a.sine > kAnyTurn || turn > kPi / 2) return true;
  const Real tilt = std::asin(std::min(std::abs(glm::dot(a.along, normal)), 1.0));
  return tilt <= std::asin(a.sine) + turn + 1e-6;
}

/// A cell of a's, from b.
struct Seen {
  Vec3 centre;
  Cone cone;
};
Seen seen(const Wire& a, const Wire::Leaf& cell, const Pose& a_in_b) {
  Seen at{to_world(a_in_b, cell.centre), cone_of(a, cell)};
  at.cone.along = a_in_b.rotation * at.cone.along;
  return at;
}

}  // namespace

std::size_t find_planar(const Wire& a, const Wire& b, const Pose& a_in_b, CurveReach reach) {
  Found found(reach, std::min(a.size(), b.size()));
  for (const Wire::Leaf& cell : a.leaves()) {
    const Seen here = seen(a, cell, a_in_b);
    b.tree().visit(
        here.centre, [&] { return cell.radius + reach.reach; },
        [&](std::uint32_t index) {
          const Wire::Leaf& other = b.leaves()[index];
          const Real apart = glm::distance(here.centre, other.centre) - cell.radius - other.radius;
          if (apart > reach.reach || !may_oppose(here.cone, cone_of(b, other))) return;
          found.keep(track_planar(a, b, a_in_b, {cell.t.middle(), other.t.middle()}));
        });
  }
  return found.count();
}

std::size_t find_on_face(const Wire& a, const Skin& b, const Pose& a_in_b, CurveReach reach) {
  Found found(reach, std::min(a.size(), b.size()));
  for (const Wire::Leaf& cell : a.leaves()) {
    const Seen here = seen(a, cell, a_in_b);
    for (int i = 0; i < static_cast<int>(b.faces().size()); ++i) {
      const Face& face = b.face(i);
      face.tree().visit(
          here.centre, [&] { return cell.radius + reach.reach; },
          [&](std::uint32_t index) {
            const Leaf& leaf = face.leaves()[index];
            if (glm::distance(here.centre, leaf.centre) - cell.radius - leaf.radius > reach.reach)
              return;
            if (!may_touch(here.cone, leaf.normal, leaf.turn)) return;
            const NearestPoint near =
                closest_from(face, here.centre, {leaf.u.middle(), leaf.v.middle()});
            found.keep(track_on_face(a, b, a_in_b, {cell.t.middle(), {i, near.u, near.v}}));
          });
    }
  }
  return found.count();
}

}  // namespace pantin::detail::nurbs
