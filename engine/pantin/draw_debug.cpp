// Lines of joints, limits, contacts, cables, pins and bounds.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <pantin/draw.hpp>
#include <pantin/measure.hpp>
#include <vector>

#include "engine/base/rotation.hpp"
#include "engine/contact/contact.hpp"
#include "engine/geometry/convex.hpp"
#include "engine/geometry/kinds.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/world/cable_route.hpp"

namespace pantin {

using namespace detail;

namespace {

constexpr Vec3 kAxes[] = {{0.92, 0.25, 0.22}, {0.25, 0.75, 0.28}, {0.25, 0.45, 0.95}};
constexpr Vec3 kOpen{1.0, 0.1, 0.1}, kRange{0.66, 0.50, 1.0}, kNow{1, 1, 1};
constexpr Vec3 kContact{0.45, 0.95, 0.30}, kForce{1.0, 0.50, 0.15}, kPin{0.98, 0.78, 0.12};
constexpr Vec3 kTaut{1.0, 0.75, 0.30}, kSlack{0.55, 0.35, 0.10}, kBounds{0.55, 0.62, 0.50};
constexpr Real kArcStep = 0.2;   // rad
constexpr Real kOpenGap = 1e-6;  // m, larger gaps are drawn as open
constexpr Real kSmall = 0.1;     // of DebugDraw::size: marks at points
constexpr int kRim = 24;         // points round a cone

/// Draws marks as lines.
struct Pen {
  const World& world;
  const DebugDraw& what;
  const std::function<void(const DebugLine&)>& line;

  void add(Vec3 from, Vec3 to, Vec3 colour) const {
    if (is_finite(from) && is_finite(to)) line({from, to, colour});
  }
  void path(std::span<const Vec3> points, Vec3 colour) const {
    for (std::size_t i = 1; i < points.size(); ++i) add(points[i - 1], points[i], colour);
  }
  void cross(Vec3 at, Vec3 colour) const {
    for (int k = 0; k < 3; ++k) {
      Vec3 arm(0);
      arm[k] = kSmall * what.size;
      add(at - arm, at + arm, colour);
    }
  }
  const Pose* pose_of(Entity body) const {
    const Body* b = world.bodies.find(body);
    return b && is_finite(b->pose) ? &b->pose : nullptr;
  }
};

/// A joint at present: its axes on both sides, in the world.
struct Placed {
  const Joint& joint;
  Pose a, b;
};

void draw_axes(const Pen& pen, const Placed& at) {
  const bool is_line = info_of(at.joint.kind).is_line;
  for (const Pose* side : {&at.a, &at.b})
    for (int k = 0; !is_line && k < 3; ++k) {
      Vec3 tip(0);
      tip[k] = pen.what.size;
      pen.add(side->position, to_world(*side, tip), kAxes[k]);
    }
  const Vec3 apart = at.b.position - at.a.position;
  if (is_line)
    pen.add(at.a.position, at.b.position, kTaut);
  else if (holds_point(at.joint.kind) && glm::length(apart) > kOpenGap)
    pen.add(at.a.position, at.b.position, kOpen);
}

/// The range of a rotation about an axis: a sector, and the present angle.
struct Sector {
  Pose at;  // the axis is its x, angle 0 its y
  AngleLimit limit;
  Real now = 0;  // rad
};

void draw_sector(const Pen& pen, const Sector& sector) {
  const auto rim = [&](Real angle) {
    return to_world(sector.at, pen.what.size * Vec3(0, std::cos(angle), std::sin(angle)));
  };
  std::vector<Vec3> arc{sector.at.position};
  const Real wide = sector.limit.high - sector.limit.low;
  const Real span = wide > 0 ? std::min(wide, 2 * kPi) : 0;
  const int pieces = std::max(1, static_cast<int>(std::ceil(span / kArcStep)));
  for (int i = 0; i <= pieces; ++i) arc.push_back(rim(sector.limit.low + span * i / pieces));
  arc.push_back(sector.at.position);
  pen.path(arc, kRange);
  if (std::isfinite(sector.now)) pen.add(sector.at.position, rim(sector.now), kNow);
}

/// The cone that limits the swing of b's x axis about that of a, and the present direction.
void draw_cone(const Pen& pen, const Placed& at) {
  const JointLimits& limits = at.joint.limits;
  const SwingLimit swing = limits.swing;
  std::vector<Vec3> rim;
  for (int i = 0; i <= kRim; ++i) {
    const Real around = 2 * kPi * i / kRim;
    const Vec3 turn(0, swing.y * std::cos(around), swing.z * std::sin(around));
    rim.push_back(to_world(at.a, from_rotation_vector(turn) * Vec3(pen.what.size, 0, 0)));
    if (i % (kRim / 8) == 0) pen.add(at.a.position, rim.back(), kRange);
  }
  pen.path(rim, kRange);
  pen.add(at.a.position, to_world(at.b, {pen.what.size, 0, 0}), kNow);
}

void draw_travel(const Pen& pen, const Placed& at) {
  const AngleLimit& travel = at.joint.parameters->travel;
  const auto on_axis = [&](Real x) { return to_world(at.a, {x, 0, 0}); };
  pen.add(on_axis(travel.low), on_axis(travel.high), kRange);
  for (const Real end : {travel.low, travel.high}) pen.cross(on_axis(end), kRange);
  pen.cross(at.b.position, kNow);
}

void draw_limits(const Pen& pen, const Placed& at, Entity joint) {
  const JointLimits& limits = at.joint.limits;
  const bool is_two = turns_of(at.joint.kind) == Turns::about_two;
  if (limits.angle.on) {
    // The first angle of a universal joint rotates z towards x, about y.
    const Quat turned =
        is_two ? from_rotation_vector(2 * kPi / 3 / std::sqrt(3.0) * Vec3(1)) : kIdentity;
    draw_sector(
        pen,
        {{at.a.position, at.a.rotation * turned}, limits.angle, joint_angle(pen.world, joint)});
  }
  if (limits.second.on) {
    // In b's frame, a's y axis rotates towards x, about -z.
    const Quat turned = from_rotation_vector({0, kPi / 2, 0});
    draw_sector(pen, {{at.b.position, at.b.rotation * turned},
                      limits.second,
                      joint_second_angle(pen.world, joint)});
  }
  if (limits.swing.on) draw_cone(pen, at);
  if (at.joint.parameters->travel.on) draw_travel(pen, at);
}

void draw_joints(const Pen& pen) {
  for (std::size_t i = 0; i < pen.world.links.size(); ++i) {
    const Link& link = pen.world.links.values()[i];
    const Pose *a = pen.pose_of(link.a), *b = pen.pose_of(link.b);
    if (!a || !b || link.joint.kind == JointKind::custom) continue;
    const Placed at{link.joint, compose(*a, {link.joint.anchor_a, link.joint.frames.a()}),
                    compose(*b, {link.joint.anchor_b, link.joint.frames.b()})};
    if (pen.what.joints) draw_axes(pen, at);
    if (pen.what.limits && pen.what.size > 0) draw_limits(pen, at, pen.world.links.owners()[i]);
  }
}

void draw_contacts(const Pen& pen) {
  each_contact(pen.world, [&](const Contact& c) {
    if (c.slot_a >= pen.world.bodies.size()) return;
    const Vec3 at = to_world(pen.world.bodies.values()[c.slot_a].pose, c.point_a);
    if (pen.what.contacts) pen.cross(at, c.active ? kContact : kBounds);
    if (pen.what.contacts && c.active) pen.add(at, at + pen.what.size * c.normal, kContact);
    if (pen.what.forces && c.active) pen.add(at, at + pen.what.force_scale * c.force, kForce);
  });
}

void draw_cables(const Pen& pen) {
  std::vector<Vec3> points;
  for (const Cable& cable : pen.world.cables.values()) {
    points.clear();
    const auto route = route_of(cable, [&](Entity body) { return pen.pose_of(body); });
    if (!route.empty()) trace_path(route, kArcStep, points);
    pen.path(points, cable.tension > 0 ? kTaut : kSlack);
  }
}

void draw_pins(const Pen& pen) {
  for (const Pin& pin : pen.world.pins.values()) {
    const Pose *body = pen.pose_of(pin.body), *to = pin.to ? pen.pose_of(pin.to) : nullptr;
    if (!body || (pin.to && !to)) continue;
    const Vec3 target = to ? to_world(*to, pin.target) : pin.target;
    pen.cross(target, kPin);
    pen.add(to_world(*body, pin.anchor), target, kPin);
  }
}

void draw_box(const Pen& pen, Vec3 low, Vec3 high) {
  for (int k = 0; k < 3; ++k)  // four edges along each axis
    for (int side = 0; side < 4; ++side) {
      const int u = (k + 1) % 3, v = (k + 2) % 3;
      Vec3 from = low;
      from[u] = side & 1 ? high[u] : low[u], from[v] = side & 2 ? high[v] : low[v];
      Vec3 to = from;
      to[k] = high[k];
      pen.add(from, to, kBounds);
    }
}

void draw_bounds(const Pen& pen) {
  for (std::size_t i = 0; i < pen.world.shapes.size(); ++i) {
    const Pose* pose = pen.pose_of(pen.world.shapes.owners()[i]);
    if (!pose) continue;
    for (const Shape& shape : pen.world.shapes.values()[i].list) {
      if (is_ground(shape.kind) || !is_complete(shape)) continue;
      const Aabb box = bounds_of(shape, *pose);
      draw_box(pen, box.low, box.high);
    }
  }
}

}  // namespace

void draw_debug(const World& world, const DebugDraw& what,
                const std::function<void(const DebugLine&)>& line) {
  const Pen pen{world, what, line};
  if (what.joints || what.limits) draw_joints(pen);
  if (what.contacts || what.forces) draw_contacts(pen);
  if (what.cables) draw_cables(pen);
  if (what.pins) draw_pins(pen);
  if (what.bounds) draw_bounds(pen);
}

}  // namespace pantin
