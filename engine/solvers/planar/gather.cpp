// Fills the plane of a step from the World.
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/rotation.hpp"
#include "engine/contact/detect.hpp"
#include "engine/contact/memory.hpp"
#include "engine/joints/joint_force.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/planar/island.hpp"
#include "engine/solvers/planar/section.hpp"
#include "engine/world/flat.hpp"
#include "engine/world/joined.hpp"

namespace pantin::detail::planar {
namespace {

Vec3 flat(Vec3 v) { return {v.x, v.y, 0}; }

/// The size of a typical moving body: a power of two, so that it stays the same while bodies come
/// and go.
Real unit_of(const World& world, const Planar& all) {
  Real sum = 0, count = 0;
  for (const FlatBody& f : all.bodies) {
    if (f.island == kNobody || !f.solid) continue;
    const Shapes* shapes = world.shapes.find(f.body);
    const Real extent = shapes ? contact::extent_of(*shapes) : 0;
    if (!(extent > 0)) continue;
    sum += std::log2(extent), ++count;
  }
  return count > 0 ? std::exp2(std::round(sum / count)) : 1;
}

/// Sections of unrotated bodies: those of moving bodies are rotated with them, by the angle in the
/// state.
void cut_sections(const World& world, Planar& all) {
  Plane& plane = all.scratch.plane;
  plane.outlines.clear(), plane.corners.clear();
  plane.bodies.assign(all.bodies.size(), {});
  for (std::size_t i = 0; i < all.bodies.size(); ++i) {
    const FlatBody& f = all.bodies[i];
    PlaneBody& b = plane.bodies[i];
    b.first = static_cast<std::uint32_t>(plane.outlines.size());
    const Shapes* shapes = f.solid ? world.shapes.find(f.body) : nullptr;
    const Real z = world.bodies.values()[f.slot].pose.position.z;
    for (std::uint32_t k = 0; shapes && k < shapes->list.size(); ++k) {
      const std::size_t from = plane.outlines.size();
      append_section(shapes->list[k], {{0, 0, z}, f.tilt}, plane);
      for (std::size_t n = from; n < plane.outlines.size(); ++n) plane.outlines[n].shape = k;
    }
    b.count = static_cast<std::uint32_t>(plane.outlines.size()) - b.first;
  }
  plane.unit = unit_of(world, all);
  all.scratch.has_sections = true;
}

void gather_body(const World& world, const FlatBody& f, PlaneBody& b) {
  const Body& body = world.bodies.values()[f.slot];
  b.kind = f.island != kNobody                ? PlaneBody::dynamic
           : body.motion == Motion::kinematic ? PlaneBody::kinematic
                                              : PlaneBody::fixed;
  b.position = flat(body.pose.position), b.angle = f.turned;
  b.velocity = flat(body.velocity), b.spin = body.angular_velocity.z;
  b.gravity_scale = body.gravity_scale, b.island = f.island, b.slot = f.slot;
  b.force = Vec3(0), b.torque = 0;
  if (const Collision* c = world.collisions.find(f.body)) {
    b.groups = c->groups, b.with = c->with, b.self = c->self, b.others = c->others;
    b.friction = c->friction, b.restitution = c->restitution;
    b.entity = f.body, b.one_way = contact::one_way(world, f.body);
  }
  if (b.kind != PlaneBody::dynamic) return;
  b.mass = body.mass;
  b.inertia = world_inertia(body.pose.rotation, body.inertia)[2].z;
  if (const Force* push = world.forces.find(f.body))
    b.force = flat(push->force), b.torque = push->torque.z;
}

/// The range of a coordinate relative to its present value.
void limit(PlaneJoint& j, const AngleLimit& range, Real now, Real sign) {
  if (!range.on) return;
  j.limited = true;
  const Real low = range.low - now, high = range.high - now;
  j.low = sign > 0 ? low : -high, j.high = sign > 0 ? high : -low;
}

/// A coordinate and its rate, and its sign relative to the rotation of b.
struct Now {
  Real coordinate = 0, rate = 0, sign = 1;
};

void load(PlaneJoint& j, const Dof& dof, const Now& now) {
  if (!dof.any()) return;
  const LinearisedForce f = linearise(dof, now.coordinate, now.rate, Slope::secant);
  j.along = {f.stiffness, f.damping, now.sign * (f.force + f.damping * now.rate)};
}

struct Ends {
  const Body &a, &b;
};

void gather_hinge(const Joint& joint, const Ends& ends, FlatLink& l, PlaneJoint& j) {
  if (joint.kind == JointKind::ball) return;
  const Quat qa = ends.a.pose.rotation, qb = ends.b.pose.rotation;
  const Real sign = (qa * (joint.frames.a() * Vec3(1, 0, 0))).z > 0 ? 1 : -1;
  const Real near = angle_near(joint, l);
  const Real twist = swing_twist(relative_rotation(joint, qa, qb)).twist;
  const Real now = l.angle = near + std::remainder(twist - near, 2 * kPi);
  if (has_stops(joint)) limit(j, joint.limits->angle, now, sign);
  const Real rate = sign * (ends.b.angular_velocity.z - ends.a.angular_velocity.z);
  load(j, joint.parameters->rotation, {now, rate, sign});
}

void gather_slider(const Joint& joint, const Ends& ends, PlaneJoint& j) {
  j.axis = glm::normalize(flat(ends.a.pose.rotation * (joint.frames.a() * Vec3(1, 0, 0))));
  const Vec3 span = residual(joint, ends.a.pose, ends.b.pose);
  const Vec3 speed = ends.b.velocity + glm::cross(ends.b.angular_velocity, j.arm_b) -
                     ends.a.velocity - glm::cross(ends.a.angular_velocity, j.arm_a + flat(span));
  const Real now = glm::dot(span, j.axis);
  if (const AngleLimit& range = joint.parameters->travel; range.on)
    j.limited = true, j.low = range.low, j.high = range.high;
  load(j, joint.parameters->translation, {now, glm::dot(speed, j.axis), 1});
  // Box2D's spring is at rest where the anchors coincide.
  j.along.load += j.along.stiffness * now;
}

Real angle_error(const Joint& joint, const Ends& ends) {
  const Quat from = ends.a.pose.rotation * joint.frames.a(),
             to = ends.b.pose.rotation * joint.frames.b();
  return rotation_vector(to * glm::conjugate(from)).z;
}

void gather_link(const World& world, FlatLink& l, Planar& all) {
  const Joint& joint = world.links.values()[l.link].joint;
  const Ends ends{world.bodies.values()[all.bodies[l.a].slot],
                  world.bodies.values()[all.bodies[l.b].slot]};
  PANTIN_ASSERT(l.a < all.bodies.size() && l.b < all.bodies.size() && l.a != l.b);
  const FlatJoint kind = flat_kind(joint, ends.a.pose);
  all.scratch.joint_of.push_back(kind == FlatJoint::none
                                     ? kNobody
                                     : static_cast<std::uint32_t>(all.scratch.plane.joints.size()));
  if (kind == FlatJoint::none) return;
  PlaneJoint j;
  j.a = l.a, j.b = l.b;
  j.arm_a = flat(ends.a.pose.rotation * joint.anchor_a);
  j.arm_b = flat(ends.b.pose.rotation * joint.anchor_b);
  j.kind = kind == FlatJoint::hinge    ? PlaneJoint::hinge
           : kind == FlatJoint::weld   ? PlaneJoint::weld
           : kind == FlatJoint::slider ? PlaneJoint::slider
           : kind == FlatJoint::rod    ? PlaneJoint::rod
                                       : PlaneJoint::spring;
  if (j.kind == PlaneJoint::hinge) gather_hinge(joint, ends, l, j);
  if (j.kind == PlaneJoint::slider) gather_slider(joint, ends, j);
  if (j.kind == PlaneJoint::weld || j.kind == PlaneJoint::slider)
    j.angle_error = angle_error(joint, ends);
  j.length = joint.parameters->length;
  j.load = all.loads[&l - all.links.data()];
  if (j.kind == PlaneJoint::spring) {
    const SpringDamper& spring = joint.parameters->translation.spring;
    j.along = {spring.stiffness, spring.damping, 0}, j.length = spring.rest;
  }
  all.scratch.plane.joints.push_back(j);
}

/// A pin to a fixed target attaches the body to the last body of the plane, which is fixed.
void gather_pin(const World& world, const FlatPin& p, Planar& all) {
  PANTIN_ASSERT(all.scratch.plane.bodies.size() == all.bodies.size() + 1 &&
                p.body < all.bodies.size());
  const Pin& pin = world.pins.values()[p.pin];
  PlaneJoint j;
  j.a = p.to != kNobody ? p.to : static_cast<std::uint32_t>(all.bodies.size());
  j.b = p.body;
  j.arm_b = flat(world.bodies.values()[all.bodies[p.body].slot].pose.rotation * pin.anchor);
  j.arm_a = p.to != kNobody
                ? flat(world.bodies.values()[all.bodies[p.to].slot].pose.rotation * pin.target)
                : flat(pin.target) - all.scratch.plane.bodies.back().position;
  j.load = all.loads[all.links.size() + (&p - all.pins.data())];
  all.scratch.plane.joints.push_back(j);
}

}  // namespace

void gather(const World& world, Planar& all) {
  Plane& plane = all.scratch.plane;
  if (!all.scratch.has_sections) cut_sections(world, all);
  plane.bodies.resize(all.bodies.size());
  for (std::size_t i = 0; i < all.bodies.size(); ++i)
    gather_body(world, all.bodies[i], plane.bodies[i]);
  plane.bodies.push_back({});
  if (const std::uint64_t now = 1 + joined_version(world); plane.joined_for != now)
    list_joined(world, plane.joined), plane.joined_for = now;
  plane.gravity = flat(world.gravity);
  list_ignored(world, plane.ignored);
  plane.joints.clear(), all.scratch.joint_of.clear();
  for (FlatLink& l : all.links) gather_link(world, l, all);
  for (const FlatPin& p : all.pins) gather_pin(world, p, all);
}

}  // namespace pantin::detail::planar
