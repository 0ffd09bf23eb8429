// All pairs of two curves, or of a curve and a face, that face one another.
#include <algorithm>
#include <cmath>

#include "engine/nurbs/cells.hpp"
#include "engine/nurbs/curve_pair.hpp"

namespace pantin::detail::nurbs {
namespace {

// Fraction of the smaller size: closer pairs are merged.
constexpr Real kSame = 1e-6;
// Sine of a turn beyond which a cell does not bound its tangents.
constexpr Real kAnyTurn = 0.95;
constexpr Real kSlack = 1e-12;  // relative: allowance for rounding

class Found {
 public:
  Found(CurveReach to, Real size) : to_(to), same_(kSame * size) {}

  /// Keeps a pair; if there is no room, the closest ones.
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

/// Bound of the directions of a cell's tangents.
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

/// A cell of a, in the frame of b.
struct Seen {
  Vec3 centre;
  Cone cone;
};
Seen seen(const Wire& a, const Wire::Leaf& cell, const Pose& a_in_b) {
  Seen at{to_world(a_in_b, cell.centre), cone_of(a, cell)};
  at.cone.along = a_in_b.rotation * at.cone.along;
  return at;
}

/// A cell of a curve that may touch a face: a segment, and a bound of the curve's deviation from
/// it.
struct Segment {
  Vec3 centre, half;
  Cone cone;
  Real sag, radius;

  Real extent(Vec3 axis) const { return std::min(std::abs(glm::dot(half, axis)) + sag, radius); }
  bool may_lean_on(Vec3 normal, Real turn) const {
    if (cone.sine > kAnyTurn || turn > kPi / 2) return true;
    const Real tilt = std::asin(std::min(std::abs(glm::dot(cone.along, normal)), 1.0));
    return tilt <= std::asin(cone.sine) + turn + 1e-6;
  }
};
Segment segment_of(const Wire& a, const Wire::Leaf& cell, const Pose& a_in_b) {
  const Seen at = seen(a, cell, a_in_b);
  const Vec3 tangent = a_in_b.rotation * evaluate(a.curve(), cell.t.middle(), 1)[1];
  return {at.centre, tangent * (cell.t.width() / 2), at.cone,
          cell.second / 2 + kSlack * cell.radius, cell.radius};
}

// Lower bound of the distance of a segment from a region; huge if no tangent can be perpendicular
// to a normal.
Real least_distance(const Segment& a, const Region& b) {
  if (!a.may_lean_on(b.normal, b.turn)) return 1e300;
  const Vec3 d = a.centre - (b.low + b.high) / 2.0, room = (b.high - b.low) / 2.0;
  Real least = 0;
  for (int k = 0; k < 3; ++k) {
    Vec3 axis(0);
    axis[k] = 1;
    least = std::max(least, std::abs(d[k]) - room[k] - a.extent(axis));
  }
  return least;
}

bool may_touch(const Segment& a, const PatchCell& b, Real reach) {
  if (!a.may_lean_on(b.normal, b.turn)) return false;
  const Vec3 d = a.centre - b.centre;
  const auto is_apart = [&](Vec3 axis, Real within) {
    return std::abs(glm::dot(d, axis)) > a.extent(axis) + b.extent(axis) + within;
  };
  const Real room = reach + kSlack * (glm::length(d) + a.radius);
  if (is_apart(b.normal, room)) return false;
  // The line between the points is along a normal.
  const Real beside = b.turn < kPi / 2 ? room * std::sin(b.turn) + (room - reach) : room;
  const Vec3 across = glm::cross(b.normal, a.cone.along);
  const Real length = glm::length(across);
  if (length > 0 && is_apart(across / length, beside)) return false;
  return !is_apart(b.sides[0], beside) && !is_apart(b.sides[1], beside);
}

// Calls `found(cell)` for the straight parts of a cell that a segment may touch.
template <class Asked, class Found>
void for_each_part(const PatchCell& cell, Asked& asked, Found& found) {
  if (!asked(cell)) return;
  if (!cell.is_bent()) {
    found(cell);
    return;
  }
  for (int k = 0; k < 2; ++k) for_each_part(half_of(cell, k, {}), asked, found);
}

}  // namespace

std::size_t find_planar(const Wire& a, const Wire& b, const Pose& a_in_b, CurveReach reach) {
  Found found(reach, std::min(a.size(), b.size()));
  for (const Wire::Leaf& cell : a.leaves()) {
    const Seen here = seen(a, cell, a_in_b);
    b.tree().visit(
        b.tree().from(here.centre), [&] { return cell.radius + reach.reach; },
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
  SearchCost cost;
  for (const Wire::Leaf& leaf : a.leaves()) {
    const Segment here = segment_of(a, leaf, a_in_b);
    for (int i = 0; i < static_cast<int>(b.faces().size()); ++i) {
      const Face& face = b.face(i);
      const auto asked = [&](const PatchCell& cell) {
        ++cost.pairs;
        return may_touch(here, cell, reach.reach);
      };
      const auto start = [&](const PatchCell& cell) {
        ++cost.starts;
        const Vec3 ways[3] = {here.half, -cell.along_u, -cell.along_v};
        Real shares[3] = {};
        approach(here.centre - cell.centre, ways, shares);
        const Real t = leaf.t.middle() + shares[0] * leaf.t.width() / 2;
        const Vec3 at = to_world(a_in_b, evaluate(a.curve(), t, 0)[0]);
        const NearestPoint near = closest_from(face, at,
                                               {cell.u.middle() + shares[1] * cell.u.width() / 2,
                                                cell.v.middle() + shares[2] * cell.v.width() / 2});
        found.keep(track_on_face(a, b, a_in_b, {t, {i, near.u, near.v}}));
      };
      const auto least = [&](std::uint32_t node) {
        ++cost.pairs;
        return least_distance(here, face.regions()[node]);
      };
      face.tree().visit(
          least, [&] { return reach.reach; },
          [&](std::uint32_t index) {
            for_each_part(cell_of(face, face.leaves()[index], {}), asked, start);
          });
    }
  }
  if (reach.cost != nullptr) *reach.cost = cost;
  return found.count();
}

}  // namespace pantin::detail::nurbs
