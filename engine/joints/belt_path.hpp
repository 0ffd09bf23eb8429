#pragma once
/// Path of a taut belt around pulleys in the plane of x and y.
///
/// A span is a common tangent of two outlines, each of which is on one side of it. Its direction u
/// and the points of contact p, p' follow from the outlines alone. Without slip, the belt between a
/// mark on one pulley and a mark on the next keeps its length:
///
///   C = |p' - p| + s S(psi) - s' S'(psi') - C_0,    dC/dt = u . (v' - v)
///
/// S(psi) is the length of the outline up to the outward normal at the angle psi in the pulley's
/// own axes, R psi of a circle; s = 1 where the belt runs anticlockwise round the pulley, else -1;
/// v, v' are the velocities of the pulleys at the points of contact. That is two outlines rolling
/// on a common tangent [Nelson & Cohen, Fig. 3]. The sum of all C is the length of the belt.
///
/// Internal (pantin::detail); installed because World::belts holds an outline.
#include <span>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin::detail {

/// A circle, or the convex hull of points, about the centre of a pulley; m, in the axes of the
/// pulley.
struct BeltOutline {
  Real radius = 0;            // of a circle; of a hull the largest
  std::vector<Vec3> corners;  // anticlockwise; none: a circle
  std::vector<Real> normals;  // rad, of the edges from them, ascending
  std::vector<Real> lengths;  // m, of the outline up to them, and of the whole

  static void fields(auto& self, auto&& field) {
    field("radius", self.radius);
    field("corners", self.corners);
    field("normals", self.normals);
    field("lengths", self.lengths);
  }
};

/// The hull of points in the plane, ignoring z; no corners if they are collinear.
BeltOutline hull_outline(std::span<const Vec3> points);

/// Perimeter of the outline that a belt can touch, m.
Real perimeter_of(const BeltOutline& outline);

/// Length of the outline up to an outward normal, m; each revolution adds the perimeter.
Real length_up_to(const BeltOutline& outline, Real normal);

/// A pulley at its current pose.
struct BeltPlace {
  const BeltOutline& outline;
  Vec3 centre{0};  // m
  Real angle = 0;  // rad, of its axes
  Real sense = 1;  // 1: the belt runs round it anticlockwise; -1
};

/// A straight part of a belt.
struct BeltSpan {
  Vec3 from{0}, to{0};    // m: where it leaves the first pulley and meets the second
  Vec3 along{1, 0, 0};    // from one to the other, of unit length
  Real length = 0;        // m
  Real angle = 0;         // rad, of `along`
  bool is_found = false;  // else the pulleys overlap, or one is inside the other
};

/// `near`: the angle before; the new one is within half a turn of it.
BeltSpan span_between(const BeltPlace& a, const BeltPlace& b, Real near);

/// The belt from a mark on the first pulley to one on the second, without C_0; m.
Real marked_length(const BeltPlace& a, const BeltPlace& b, const BeltSpan& span);

/// Length of the belt on a pulley between the directions in which it meets and leaves it, m.
Real wrapped_length(const BeltPlace& at, Real meets, Real leaves);

/// The directions in which a belt meets and leaves a pulley, rad.
struct BeltWrap {
  Real meets = 0, leaves = 0;
};
/// Appends points of the belt on a pulley in steps of no more than `turn` rad, m.
void trace_wrap(const BeltPlace& at, const BeltWrap& wrap, Real turn, std::vector<Vec3>& to);

}  // namespace pantin::detail
