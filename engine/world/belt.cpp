#include "engine/world/belt.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/joints/kinds.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {
namespace {

Real nearest(Real angle, Real near) { return near + std::remainder(angle - near, 2 * kPi); }

/// The geometry of a belt for the present poses of its pulleys.
struct Way {
  const Belt& belt;
  PulleyPoses bodies;

  std::size_t next(std::size_t i) const { return i + 1 < belt.pulleys.size() ? i + 1 : 0; }
  BeltPlace place(std::size_t i) const { return place_of(belt.pulleys[i], bodies[i]); }
  BeltSpan span(std::size_t i, Real near) const {
    return span_between(place(i), place(next(i)), near);
  }
  /// Direction in which the belt runs onto pulley i, rad, on the same branch as those that leave
  /// it.
  Real meets(std::size_t i) const {
    const std::size_t last = belt.pulleys.size() - 1;
    return i > 0 ? belt.pulleys[i - 1].direction : belt.pulleys[last].direction - belt.turning;
  }
  Real wrap(std::size_t i) const {
    return belt.pulleys[i].sense * (belt.pulleys[i].direction - meets(i));
  }
  Real length() const {
    Real sum = 0;
    for (std::size_t i = 0; i < belt.pulleys.size(); ++i)
      sum += span(i, belt.pulleys[i].direction).length +
             wrapped_length(place(i), meets(i), belt.pulleys[i].direction);
    return sum;
  }
};

/// Adds whole turns until the angle is ahead of `from` in the pulley's sense, by less than one
/// turn.
Real turned_on(Real angle, Real from, Real sense) {
  const Real way = sense * (angle - from);
  const Real on = way - 2 * kPi * std::floor(way / (2 * kPi));
  return from + sense * (on > 2 * kPi - 1e-9 ? 0 : on);
}

/// Whether two spans cross.
bool cross(const BeltSpan& p, const BeltSpan& q) {
  const auto side = [](const BeltSpan& of, Vec3 at) {
    const Vec3 d = at - of.from;
    return of.along.x * d.y - of.along.y * d.x;
  };
  return side(p, q.from) * side(p, q.to) < 0 && side(q, p.from) * side(q, p.to) < 0;
}

Real distance_to(const BeltSpan& span, Vec3 point) {
  const Real at = std::clamp(glm::dot(point - span.from, span.along), 0.0, span.length);
  return glm::length((span.from + at * span.along - point) * Vec3(1, 1, 0));
}

std::string number(Real x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", x);
  return text;
}
std::string pair(std::size_t i, std::size_t k) {
  return "pulleys " + std::to_string(i) + " and " + std::to_string(k);
}

/// The first fault of the route, in words: overlapping pulleys, crossing spans, a span through a
/// pulley.
std::string meeting_in(const Way& way, const std::vector<BeltSpan>& spans, Crossing crossing) {
  const std::size_t count = spans.size();
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = i + 1; k < count; ++k) {
      const BeltPlace p = way.place(i), q = way.place(k);
      const Real apart = glm::length((p.centre - q.centre) * Vec3(1, 1, 0)),
                 least = p.outline.radius + q.outline.radius;
      const bool is_round = p.outline.corners.empty() && q.outline.corners.empty();
      if (is_round ? apart < least : apart < 0.5 * least)
        return pair(i, k) + " " + number(apart) + " m apart, expected " + number(least) +
               " m or more: they overlap";
    }
  for (std::size_t i = 0; i < count && crossing == Crossing::refused; ++i)
    for (std::size_t k = i + 1; k < count; ++k)
      if (cross(spans[i], spans[k]))
        return "a belt whose spans after " + pair(i, k) +
               " cross, expected none that do, or \"crossed\": true";
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < count; ++k) {
      const BeltPlace p = way.place(k);
      if (k == i || k == way.next(i) || !p.outline.corners.empty()) continue;
      if (distance_to(spans[i], p.centre) < p.outline.radius)
        return "a belt whose span after pulley " + std::to_string(i) + " runs through pulley " +
               std::to_string(k) + ", expected it on one side of that";
    }
  return {};
}

}  // namespace

BeltPlace place_of(const BeltPulley& pulley, const Pose& body) {
  const Vec3 x = body.rotation * (pulley.frame * Vec3(1, 0, 0));
  return {pulley.outline, to_world(body, pulley.anchor) * Vec3(1, 1, 0),
          nearest(std::atan2(x.y, x.x), pulley.angle), pulley.sense};
}

bool lay_belt(Belt& belt, PulleyPoses bodies) {
  const Way way{belt, bodies};
  const std::size_t count = belt.pulleys.size();
  belt.turning = 0;
  for (std::size_t i = 0; i < count; ++i) {
    BeltPulley& p = belt.pulleys[i];
    p.angle = 0, p.angle = way.place(i).angle;
  }
  for (std::size_t i = 0; i < count; ++i) {
    BeltPulley& p = belt.pulleys[i];
    const BeltSpan span = way.span(i, 0);
    if (!span.is_found) return false;
    p.direction =
        i == 0 ? span.angle : turned_on(span.angle, belt.pulleys[i - 1].direction, p.sense);
    p.offset = marked_length(way.place(i), way.place(way.next(i)), way.span(i, p.direction));
  }
  const Real last = belt.pulleys[count - 1].direction, first = belt.pulleys[0].direction;
  const Real again = turned_on(first, last, belt.pulleys[0].sense);
  belt.turning = 2 * kPi * std::round((again - first) / (2 * kPi));
  belt.travel = belt.defect = 0;
  belt.length = way.length();
  return true;
}

void follow_belt(Belt& belt, PulleyPoses bodies, std::span<const Real> angles) {
  const Way way{belt, bodies};
  const std::size_t count = belt.pulleys.size();
  const BeltPulley& first = belt.pulleys[0];
  const auto gone = [&] {
    const Real normal = first.direction - first.sense * kPi / 2;
    return -first.sense * length_up_to(first.outline, normal - first.angle);
  };
  const Real before = gone();
  for (std::size_t i = 0; i < count; ++i) belt.pulleys[i].angle = angles[i];
  for (std::size_t i = 0; i < count; ++i) {
    BeltPulley& p = belt.pulleys[i];
    const BeltSpan span = way.span(i, p.direction);
    if (span.is_found) p.direction = span.angle;
  }
  belt.travel += gone() - before;
  const Real length = way.length();
  belt.defect += length - belt.length, belt.length = length;
}

void lay_mark(Belt& belt, std::size_t span, PulleyPoses bodies) {
  const Way way{belt, bodies};
  BeltPulley& p = belt.pulleys[span];
  p.offset = marked_length(way.place(span), way.place(way.next(span)), way.span(span, p.direction));
}

namespace {

/// The body that carries the axle of a pulley. None if the axle is fixed; the pulley itself if it
/// has no joint that acts as an axle.
Entity carrier_of(const World& world, Entity pulley) {
  const auto moves = [&](Entity e) {
    const Body* b = world.bodies.find(e);
    return b && b->motion != Motion::fixed;
  };
  if (!moves(pulley)) return {};
  for (const Link& link : world.links.values()) {
    if (link.a != pulley && link.b != pulley) continue;
    const JointKind kind = link.joint.kind;
    const Entity other = link.a == pulley ? link.b : link.a;
    if (kind == JointKind::hinge || kind == JointKind::ball || kind == JointKind::cylindrical)
      return moves(other) ? other : Entity{};
  }
  return pulley;
}

}  // namespace

std::size_t held_spans(const World& world, const Belt& belt) {
  const std::size_t count = belt.pulleys.size();
  const Entity first = carrier_of(world, belt.pulleys.front().body);
  for (const BeltPulley& p : belt.pulleys)
    if (carrier_of(world, p.body) != first) return count;
  return count - 1;
}

Real grip_of(const Belt& belt) {
  const Way way{belt, {}};
  Real least = way.wrap(0);
  for (std::size_t i = 1; i < belt.pulleys.size(); ++i) least = std::min(least, way.wrap(i));
  return 2 * belt.pretension * std::tanh(0.5 * belt.friction * least);
}

std::string fault_of(const Belt& belt, PulleyPoses bodies, Crossing crossing) {
  const Way way{belt, bodies};
  std::vector<BeltSpan> spans;
  for (std::size_t i = 0; i < belt.pulleys.size(); ++i)
    spans.push_back(way.span(i, belt.pulleys[i].direction));
  if (std::string why = meeting_in(way, spans, crossing); !why.empty()) return why;
  for (std::size_t i = 0; i < belt.pulleys.size(); ++i)
    if (way.wrap(i) < 1e-6 || way.wrap(i) > 1.75 * kPi)
      return "a belt that does not touch pulley " + std::to_string(i) +
             " from that side, expected one that wraps around it";
  const Real turns = std::abs(belt.turning) / (2 * kPi);
  if (crossing == Crossing::refused && std::abs(turns - 1) > 0.5)
    return "a belt that winds " + number(turns) +
           " times around its loop, expected one that closes after one turn";
  return {};
}

void trace_belt(const Belt& belt, PulleyPoses bodies, Real turn, std::vector<Vec3>& to) {
  const Way way{belt, bodies};
  for (std::size_t i = 0; i < belt.pulleys.size(); ++i)
    trace_wrap(way.place(i), {way.meets(i), belt.pulleys[i].direction}, turn, to);
}

}  // namespace pantin::detail
