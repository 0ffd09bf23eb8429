#include "engine/joints/belt_path.hpp"

#include <algorithm>
#include <cmath>

#include "engine/geometry/plane_hull.hpp"

namespace pantin::detail {
namespace {

constexpr int kMostTries = 64;

Vec3 flat(Vec3 v) { return {v.x, v.y, 0}; }
Vec3 unit(Real angle) { return {std::cos(angle), std::sin(angle), 0}; }
Vec3 turned(Vec3 v, Real angle) {
  const Real c = std::cos(angle), s = std::sin(angle);
  return {c * v.x - s * v.y, s * v.x + c * v.y, 0};
}

/// The support corner of a normal, and the normal's whole turns.
struct Support {
  std::size_t corner = 0;
  Real turns = 0;
};
Support support_of(const BeltOutline& o, Real normal) {
  const Real turns = std::floor((normal - o.normals.front()) / (2 * kPi));
  const Real within = normal - 2 * kPi * turns;
  const auto at = std::upper_bound(o.normals.begin(), o.normals.end(), within);
  return {static_cast<std::size_t>(at - o.normals.begin()), turns};
}

/// The outward normal at which a belt of a given direction touches, world, rad.
Real normal_at(const BeltPlace& p, Real direction) { return direction - p.sense * kPi / 2; }

Vec3 touch_of(const BeltPlace& p, Real direction) {
  const Real normal = normal_at(p, direction);
  if (p.outline.corners.empty()) return p.centre + p.outline.radius * unit(normal);
  const std::size_t at = support_of(p.outline, normal - p.angle).corner;
  return p.centre + turned(p.outline.corners[at % p.outline.corners.size()], p.angle);
}

Real nearest(Real angle, Real near) { return near + std::remainder(angle - near, 2 * kPi); }
Real angle_of(Vec3 v) { return std::atan2(v.y, v.x); }

/// Fixed-point iteration of the direction between the touching points. To first order these move
/// along the line only, so it converges like Newton's method.
Real aim(const BeltPlace& a, const BeltPlace& b, Real angle) {
  for (int i = 0; i < kMostTries; ++i) {
    const Real next = nearest(angle_of(touch_of(b, angle) - touch_of(a, angle)), angle);
    if (std::abs(next - angle) < 1e-15) break;
    angle = next;
  }
  return angle;
}

}  // namespace

BeltOutline hull_outline(std::span<const Vec3> points) {
  std::vector<Vec3> list;
  for (const Vec3& p : points) list.push_back(flat(p));
  BeltOutline o;
  o.corners = plane_hull(std::move(list));
  if (o.corners.empty()) return o;
  Real along = 0;
  for (std::size_t i = 0; i < o.corners.size(); ++i) {
    const Vec3 edge = o.corners[(i + 1) % o.corners.size()] - o.corners[i];
    Real normal = angle_of({edge.y, -edge.x, 0});
    if (i > 0) normal = o.normals.back() + std::remainder(normal - o.normals.back(), 2 * kPi);
    o.normals.push_back(normal), o.lengths.push_back(along);
    along += glm::length(edge), o.radius = std::max(o.radius, glm::length(o.corners[i]));
  }
  o.lengths.push_back(along);
  return o;
}

Real perimeter_of(const BeltOutline& o) {
  return o.corners.empty() ? 2 * kPi * o.radius : o.lengths.back();
}

Real length_up_to(const BeltOutline& o, Real normal) {
  if (o.corners.empty()) return o.radius * normal;
  const Support at = support_of(o, normal);
  return o.lengths.back() * at.turns + o.lengths[at.corner];
}

BeltSpan span_between(const BeltPlace& a, const BeltPlace& b, Real near) {
  BeltSpan span;
  const Vec3 d = flat(b.centre - a.centre);
  const Real distance = glm::length(d);
  const Real lean = a.sense * a.outline.radius - b.sense * b.outline.radius;
  const bool is_round = a.outline.corners.empty() && b.outline.corners.empty();
  if (!(distance > (is_round ? std::abs(lean) : 0))) return span;
  const Real first = angle_of(d) + std::asin(std::clamp(lean / distance, -1.0, 1.0));
  span.angle = nearest(is_round ? first : aim(a, b, first), near);
  span.from = touch_of(a, span.angle), span.to = touch_of(b, span.angle);
  const Vec3 way = flat(span.to - span.from);
  span.along = is_round ? unit(span.angle) : glm::normalize(way);
  span.length = glm::dot(way, span.along);
  span.is_found = span.length > 0 && glm::dot(span.along, d) > 0;
  return span;
}

Real marked_length(const BeltPlace& a, const BeltPlace& b, const BeltSpan& span) {
  return span.length + a.sense * length_up_to(a.outline, normal_at(a, span.angle) - a.angle) -
         b.sense * length_up_to(b.outline, normal_at(b, span.angle) - b.angle);
}

Real wrapped_length(const BeltPlace& at, Real meets, Real leaves) {
  return at.sense * (length_up_to(at.outline, normal_at(at, leaves) - at.angle) -
                     length_up_to(at.outline, normal_at(at, meets) - at.angle));
}

void trace_wrap(const BeltPlace& at, const BeltWrap& wrap, Real turn, std::vector<Vec3>& to) {
  const Real way = wrap.leaves - wrap.meets;
  const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(way) / turn)));
  for (int i = 0; i <= steps; ++i) to.push_back(touch_of(at, wrap.meets + way * i / steps));
}

}  // namespace pantin::detail
