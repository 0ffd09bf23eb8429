#pragma once
/// A plane of bodies, outlines and joints, stepped by Box2D. The interface consists of plain
/// numbers, so that only box2d_plane.cpp depends on the library.
///
/// Vectors are in the plane z = 0, angles about z. SI units; world positions. The "start frame" of
/// a body has its origin at the mass centre and the world's axes at the start of the step: its
/// angle there is 0. The axes of a kinematic body are the world's at the end of the step.
#include <algorithm>
#include <array>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"
#include "engine/contact/near_pairs.hpp"
#include "engine/world/joined.hpp"

namespace pantin::detail::planar {

/// A convex piece of the section of a shape, in the body's axes before its rotation by `angle`.
struct Outline {
  enum Kind : std::uint8_t { disc, polygon, half_plane } kind = disc;
  std::uint32_t first = 0, count = 0;  // polygon: in Plane::corners, anticlockwise, at most 8
  Vec3 centre{0};                      // disc; half-plane: a point of its edge
  Vec3 normal{0, 1, 0};                // half-plane: outwards
  Real radius = 0;                     // m, of a disc
  Real low = 0, high = 0;              // m: z range, world, in which it is solid
  std::uint32_t material = 0;
  std::uint32_t shape = 0;  // among those of its body
};

/// Absent bodies take no part in the step: they have been moved already, and have no contacts.
struct PlaneBody {
  enum Kind : std::uint8_t { fixed, kinematic, dynamic, absent } kind = fixed;
  bool self = true, others = true;  // as of Collision
  Vec3 position{0}, velocity{0};    // m, m/s; of kinematic bodies the position at the end
  Real angle = 0;                   // rad, rotation of the outlines; likewise
  Real spin = 0;                    // rad/s
  Real mass = 1, inertia = 1;       // kg, kg m^2 about z
  Real gravity_scale = 1;
  Vec3 force{0};                                // N
  Real torque = 0;                              // N m
  std::uint32_t first = 0, count = 0;           // outlines
  std::uint32_t island = 0, slot = UINT32_MAX;  // in World::bodies
  std::uint32_t groups = 1, with = UINT32_MAX;
  Entity entity;
  Vec3 one_way{0};  // as of Collision, world axes, unit or zero
  Real friction = 0.5, restitution = 0;
  // Results, of dynamic bodies: changes in the step.
  Vec3 moved{0}, sped_up{0};
  Real turned = 0, spun_up = 0;
};

/// Force of a spring or motor along a joint's coordinate: load - stiffness x - damping rate, where
/// x is 0 now.
struct PlaneSpring {
  Real stiffness = 0, damping = 0, load = 0;
};

/// Force of a joint on its body b in the last step, opposite on a: the warm start of the next step.
struct JointLoad {
  Vec3 force{0};                // N, at the anchor
  Real torque = 0, spring = 0;  // N m, of a weld or slider; of the spring or motor of a hinge

  static void fields(auto& self, auto&& field) {
    field("force", self.force);
    field("torque", self.torque);
    field("spring", self.spring);
  }
};

/// An exact drive of a hinge or slider.
struct PlaneDrive {
  bool on = false;
  Real rate = 0;        // rad/s or m/s: of b relative to a, in the mean of the step
  Real most = 0;        // N m or N
  Real force = 0;       // likewise, result: the mean of the step
  bool capped = false;  // result
};

struct PlaneJoint {
  enum Kind : std::uint8_t { hinge, weld, slider, rod, spring } kind = hinge;
  std::uint32_t a = 0, b = 0;  // bodies
  Vec3 arm_a{0}, arm_b{0};     // anchors in the start frames, m
  Vec3 axis{1, 0, 0};          // slider: fixed to a, unit, in its start frame
  Real angle_error = 0;        // weld, slider: rad, of b to a, to be closed
  Real length = 0;             // rod, spring: m, at rest
  bool limited = false;        // hinge: angle, slider: travel
  Real low = 0, high = 0;      // rad, relative to the present angle; m, of the travel
  JointLoad load = {};         // of the last step; a result, too
  PlaneSpring along = {};      // the angle of a hinge, the travel of a slider, the line of a spring
  PlaneDrive drive = {};       // likewise
};

/// A contact point, kept from step to step: impulses for the warm start.
struct PlaneContact {
  std::uint32_t a = 0, b = 0;                  // bodies
  std::uint32_t outline_a = 0, outline_b = 0;  // of each body
  std::uint32_t feature = 0;
  float normal_impulse = 0, tangent_impulse = 0;  // kg m/s
  Vec3 point{0}, normal{0, 1, 0};                 // results, world; from b to a
  Real depth = 0;
  Vec3 impulse{0};                         // kg m/s, on a, of the whole step
  bool ended = false;                      // it had an impulse in the step, but ended in it
  std::uint32_t shape_a = 0, shape_b = 0;  // of each body

  static void fields(auto& self, auto&& field) {
    field("a", self.a);
    field("b", self.b);
    field("outline_a", self.outline_a);
    field("outline_b", self.outline_b);
    field("feature", self.feature);
    field("normal_impulse", self.normal_impulse);
    field("tangent_impulse", self.tangent_impulse);
    field("point", passive(self.point));
    field("normal", passive(self.normal));
    field("depth", passive(self.depth));
    field("impulse", passive(self.impulse));
    field("ended", passive(self.ended));
    field("shape_a", passive(self.shape_a));
    field("shape_b", passive(self.shape_b));
  }
};

/// The order that step_plane() needs.
inline bool comes_before(const PlaneContact& p, const PlaneContact& q) {
  const auto key = [](const PlaneContact& t) {
    return std::tie(t.a, t.b, t.outline_a, t.outline_b, t.feature);
  };
  return key(p) < key(q);
}

struct Plane {
  std::vector<PlaneBody> bodies;
  std::vector<Outline> outlines;
  std::vector<Vec3> corners;
  std::vector<PlaneJoint> joints;
  std::vector<std::uint64_t> joined, ignored;  // pairs of slots: see engine/world/joined.hpp
  std::uint64_t joined_for = 0;
  Vec3 gravity{0};  // m/s^2
  Real unit = 1;    // m: the size of a typical body
  // Decides which contact pairs collide; null: all permitted pairs do.
  contact::NearPairs* near = nullptr;
  const ContactFilter* filter = nullptr;
};

/// Whether the filters of two bodies permit contact.
inline bool may_touch(const Plane& plane, std::uint32_t number_a, std::uint32_t number_b) {
  const PlaneBody &a = plane.bodies[number_a], &b = plane.bodies[number_b];
  if (!(a.groups & b.with) || !(b.groups & a.with)) return false;
  if (are_joined(plane.joined, a.slot, b.slot)) return false;
  if (a.kind == PlaneBody::dynamic && b.kind == PlaneBody::dynamic)
    if (!(a.island == b.island ? a.self && b.self : a.others || b.others)) return false;
  return !are_joined(plane.ignored, a.slot, b.slot);
}

/// One step of `h` seconds by Box2D: a function of its arguments alone. Reads the contacts of the
/// last step, sorted, and replaces them by those of this one. Writes the results of the bodies.
void step_plane(Plane& plane, Real h, std::vector<PlaneContact>& touches);

/// The same for bodies at any distance: clusters far from one another are stepped separately.
void step_clusters(Plane& plane, Real h, std::vector<PlaneContact>& touches);

/// A body with a number, of itself or its joint, that Box2D cannot represent; UINT32_MAX: none.
std::uint32_t find_unfit(const Plane& plane);

}  // namespace pantin::detail::planar
