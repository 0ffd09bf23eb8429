#include <algorithm>
#include <cmath>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/render/marks.hpp"

namespace pantin::detail {
namespace {

constexpr Real kAtStop = 1e-3;  // rad, distance from a stop at which it counts as reached
constexpr int kRimPoints = 40;

const Vec3 kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1};

/// The joint that is being marked.
struct Marked {
  const Joint& joint;
  Vec3 at{0};     // world
  Quat a, b;      // its axes in each body, to the world
  Quat turn;      // b's axes in a's
  Real size = 0;  // m
};

bool is_locked(const AngleLimit& limit) { return limit.on && !(limit.high > limit.low); }
bool is_locked(const SwingLimit& limit) { return limit.on && limit.y <= 0 && limit.z <= 0; }

bool is_at_stop(const AngleLimit& limit, Real angle) {
  if (!limit.on || is_locked(limit) || limit.high - limit.low >= 2 * kPi) return false;
  const Real to = clamped(limit, angle);
  return std::abs(std::remainder(to - angle, 2 * kPi)) > kAtStop || to - limit.low < kAtStop ||
         limit.high - to < kAtStop;
}

bool is_at_stop(const SwingLimit& limit, Vec3 swing) {
  if (!limit.on || is_locked(limit)) return false;
  // At the stop if slightly more swing would be clamped.
  const Real size = glm::length(swing);
  if (size <= 0) return false;
  Vec3 more = swing * (1 + kAtStop / size);
  if (limit.y <= 0) more.y = 0;  // locked in this direction: always at that stop
  if (limit.z <= 0) more.z = 0;
  return glm::length(clamped(limit, more) - more) > 0;
}

/// The colour of a range, by the present angle or swing.
Vec3 range_colour(const auto& limit, const auto& turned) {
  return is_at_stop(limit, turned) ? ink::kWarning : ink::kRange;
}

/// A sector from the lowest to the highest angle, with a line at the present angle.
void add_sector(Pen& pen, const Arc& whole, const AngleLimit& limit, Real angle) {
  const Vec3 colour = range_colour(limit, angle);
  const auto way = [&](Real turned) {
    return whole.centre + from_rotation_vector(turned * whole.axis) * whole.zero;
  };
  Arc arc = whole;
  arc.low = limit.low, arc.high = std::min(limit.high, limit.low + 2 * kPi);
  const std::vector<Vec3> rim = points_of(arc);
  pen.fan(arc.centre, rim, colour);
  pen.path(rim, pen.fine(), {colour, 0.9});
  pen.line(arc.centre, rim.front(), pen.fine(), {colour, 0.9});
  pen.line(arc.centre, rim.back(), pen.fine(), {colour, 0.9});
  pen.line(arc.centre, way(angle), 1.8 * pen.fine(), colour);
  pen.dot(way(angle), 2.4 * pen.fine(), colour);
}

void add_axis(Pen& pen, const Marked& m, Vec3 axis) {
  pen.line(m.at - 0.45 * m.size * axis, m.at + 0.45 * m.size * axis, 1.8 * pen.fine(), ink::kHinge);
}

void add_lock(Pen& pen, const Marked& m) { pen.square(m.at, 2.6 * pen.fine(), ink::kLocked); }

/// The direction across `axis` towards the middle of body b, so that a sector's line follows the
/// limb.
Vec3 limb_across(const Marked& m, Vec3 axis) {
  const Vec3 limb = glm::conjugate(m.joint.frames.b()) * -m.joint.anchor_b;
  const Vec3 across = limb - glm::dot(limb, axis) * axis;
  const Real length = glm::length(across);
  return length > 1e-6 * glm::length(limb) && length > 0 ? across / length : kY;
}

void add_angle(Pen& pen, const Marked& m) {
  const AngleLimit& limit = m.joint.limits->angle;
  if (is_locked(limit)) return add_lock(pen, m);
  if (!limit.on) return;
  const Arc arc{m.at, m.a * kX, m.a * (m.size * limb_across(m, kX)), 0, 0};
  add_sector(pen, arc, limit, swing_twist(m.turn).twist);
}

void add_two_angles(Pen& pen, const Marked& m) {
  const JointLimits& limits = m.joint.limits;
  const UniversalAngles angles = universal_angles(m.turn);
  if (is_locked(limits.angle) || is_locked(limits.second)) add_lock(pen, m);
  const Quat between = m.a * from_rotation_vector({0, angles.first, 0});
  if (limits.angle.on && !is_locked(limits.angle))
    add_sector(pen, {m.at, m.a * kY, m.a * (m.size * kX), 0, 0}, limits.angle, angles.first);
  if (limits.second.on && !is_locked(limits.second))
    add_sector(pen, {m.at, between * kZ, between * (0.8 * m.size * kX), 0, 0}, limits.second,
               angles.second);
}

/// The cone that limits b's x axis, that axis, and a's x axis as a thin line.
void add_cone(Pen& pen, const Marked& m, Vec3 swing) {
  const SwingLimit& limit = m.joint.limits->swing;
  const Vec3 colour = range_colour(limit, swing);
  std::vector<Vec3> rim;
  for (int i = 0; i <= kRimPoints; ++i) {
    const Real t = 2 * kPi * i / kRimPoints;
    const Quat out = from_rotation_vector({0, limit.y * std::cos(t), limit.z * std::sin(t)});
    rim.push_back(m.at + m.a * (out * (m.size * kX)));
    if (i % (kRimPoints / 8) == 0) pen.line(m.at, rim.back(), 0.8 * pen.fine(), {colour, 0.45});
  }
  pen.fan(m.at, rim, colour);
  pen.path(rim, pen.fine(), {colour, 0.9});
  pen.line(m.at, m.at + m.a * (0.6 * m.size * kX), 0.8 * pen.fine(), {ink::kHinge, 0.8});
  const Vec3 tip = m.at + m.b * (m.size * kX);
  pen.line(m.at, tip, 1.8 * pen.fine(), colour);
  pen.dot(tip, 2.4 * pen.fine(), colour);
}

/// An arc about the end of b's x axis, with a line at the present twist.
void add_twist(Pen& pen, const Marked& m, const SwingTwist& at) {
  const AngleLimit& limit = m.joint.limits->angle;
  const Vec3 axis = m.b * kX, middle = m.at + 1.2 * m.size * axis;
  const Vec3 colour = range_colour(limit, at.twist);
  Arc arc{middle, axis, m.a * (from_rotation_vector(at.swing) * (0.36 * m.size * kY)), limit.low,
          0};
  arc.high = std::min(limit.high, limit.low + 2 * kPi);
  const std::vector<Vec3> rim = points_of(arc);
  pen.path(rim, 1.4 * pen.fine(), colour);
  for (const Vec3 end : {rim.front(), rim.back()})
    pen.line(middle + 0.75 * (end - middle), end, pen.fine(), colour);
  const Vec3 now = middle + from_rotation_vector(at.twist * axis) * arc.zero;
  pen.line(middle, now, 1.4 * pen.fine(), colour);
  pen.line(m.at, middle, pen.fine(), ink::kRange);
}

/// The axis of translation, with a dash at each end of the travel, and b's anchor on it; in the
/// warning colour at a stop.
void add_slide(Pen& pen, const Marked& m, Vec3 other) {
  constexpr Real kNear = 1e-3;  // relative to the mark's size
  const Vec3 axis = m.a * kX, side = 0.15 * m.size * (m.a * kY);
  const AngleLimit& travel = m.joint.parameters->travel;
  const Real along = glm::dot(other - m.at, axis);
  const bool at_stop =
      (along - travel.low < kNear * m.size || travel.high - along < kNear * m.size);
  const Vec3 colour = !travel.on ? ink::kTie : at_stop ? ink::kWarning : ink::kRange;
  const Real low = travel.on ? travel.low : std::min(along, Real(0)) - 0.45 * m.size;
  const Real high = travel.on ? travel.high : std::max(along, Real(0)) + 0.45 * m.size;
  pen.line(m.at + low * axis, m.at + high * axis, 1.8 * pen.fine(), ink::kTie);
  for (Real end : {low, high})
    if (travel.on)
      pen.line(m.at + end * axis - side, m.at + end * axis + side, 1.4 * pen.fine(), colour);
  pen.dot(m.at + along * axis, 2.4 * pen.fine(), colour);
}

void add_rod(Pen& pen, const Marked& m, Vec3 other) {
  pen.line(m.at, other, 2 * pen.fine(), ink::kTie);
}

/// `at`: b's anchor.
void add_slip(Pen& pen, const Marked& m, Vec3 at) {
  const Vec3 way = 0.45 * m.size * (m.b * kX);
  pen.line(at - way, at + way, 1.8 * pen.fine(), ink::kTie);
}

void add_zigzag(Pen& pen, const Marked& m, Vec3 other) {
  const Vec3 way = other - m.at;
  const Real length = glm::length(way);
  if (length <= 0) return add_rod(pen, m, other);
  constexpr int kTurns = 6;
  Vec3 side = glm::cross(way, pen.eye().forward);
  if (glm::length(side) < 1e-3 * length) side = glm::cross(way, pen.eye().up);
  side *= std::min(0.15 * m.size, 0.2 * length) / glm::length(side);
  std::vector<Vec3> points{m.at, m.at + 0.15 * way};
  for (int i = 0; i < 2 * kTurns; ++i)
    points.push_back(m.at + (0.15 + 0.7 * (i + 0.5) / (2 * kTurns)) * way +
                     (i % 2 == 0 ? side : -side));
  points.push_back(m.at + 0.85 * way), points.push_back(other);
  pen.path(points, 2 * pen.fine(), ink::kTie);
}

void add_cone_and_twist(Pen& pen, const Marked& m) {
  const JointLimits& limits = m.joint.limits;
  const SwingTwist at = swing_twist(m.turn);
  if (is_locked(limits.swing) || is_locked(limits.angle)) add_lock(pen, m);
  if (limits.swing.on && !is_locked(limits.swing)) add_cone(pen, m, at.swing);
  if (limits.angle.on && !is_locked(limits.angle)) add_twist(pen, m, at);
}

/// `other`: b's anchor.
void add_mark(Pen& pen, const Marked& m, Mark mark, Vec3 other) {
  switch (mark) {
    case Mark::axis_x:
      return add_axis(pen, m, m.a * kX);
    case Mark::axis_y:
      return add_axis(pen, m, m.a * kY);
    case Mark::axis_z:
      return add_axis(pen, m, m.b * kZ);
    case Mark::angle:
      return add_angle(pen, m);
    case Mark::two_angles:
      return add_two_angles(pen, m);
    case Mark::cone_and_twist:
      return add_cone_and_twist(pen, m);
    case Mark::lock:
      return add_lock(pen, m);
    case Mark::translation:
      return add_slide(pen, m, other);
    case Mark::rod:
      return add_rod(pen, m, other);
    case Mark::zigzag:
      return add_zigzag(pen, m, other);
    case Mark::slip:
      return add_slip(pen, m, other);
  }
}

}  // namespace

void add_turn_marks(const PosedWorld& scene, Pen& pen) {
  const World& world = scene.world;
  for (const Link& link : world.links.values()) {
    const Joint& joint = link.joint;
    const std::span<const Mark> marks = info_of(joint.kind).marks;
    const auto shows = [&](Mark mark) {
      return mark != Mark::cone_and_twist || joint.limits.any();
    };
    if (std::ranges::none_of(marks, shows)) continue;
    const auto at = scene.position_of(link.a, joint.anchor_a);
    const auto other = scene.position_of(link.b, joint.anchor_b);
    if (!at || !other) continue;
    const Real size = mark_size(scene, link, *at, pen);
    if (size <= 0) continue;
    const Quat a = scene.pose_of(world.bodies.slot(link.a)).rotation;
    const Quat b = scene.pose_of(world.bodies.slot(link.b)).rotation;
    const Marked m{
        joint, *at, a * joint.frames.a(), b * joint.frames.b(), relative_rotation(joint, a, b),
        size};
    for (const Mark mark : marks) add_mark(pen, m, mark, *other);
  }
}

}  // namespace pantin::detail
