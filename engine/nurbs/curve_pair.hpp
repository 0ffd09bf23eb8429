#pragma once
/// Common normals of curves: of two in a plane, and of one with a face.
#include "engine/nurbs/closest.hpp"
#include "engine/nurbs/common_normal.hpp"

namespace pantin::detail::nurbs {

/// A pair of a curve with a curve (`on_b` = (t, 0)) or with a place of a skin.
struct CurveContact {
  ContactStatus status = ContactStatus::lost;
  Real t = 0;                // of the curve a
  Place b;                   // of a curve b: u
  Vec3 on_a{0}, on_b{0};     // m, in the frame of b
  Vec3 normal{0};            // of b, outwards, unit
  Real gap = 0;              // m
  Real least_curvature = 0;  // of the gap where both points slide, 1/m
  int iterations = 0;
};

/// The pair near (t, b.u) of two curves with z = 0 that run anticlockwise around what they bound,
/// so that outwards is right of their way; `a_in_b` turns about z only. No heap.
CurveContact track_planar(const Wire& a, const Wire& b, const Pose& a_in_b,
                          std::array<Real, 2> from);

/// How a pair of curves of the plane moves while a does by `twist`: rates (t of a, none, t of b,
/// none).
struct CurveMotion {
  Pose a_in_b;
  PlacePair at;
  Twist twist;
};
Moving moving_planar(const Wire& a, const Wire& b, const CurveMotion& of);

/// A place on a curve and one on a skin.
struct OnCurve {
  Real t = 0;
  Place b;
};

/// The pair near `from` of a curve, such as an edge or a wire of no thickness, with a skin. No
/// heap.
CurveContact track_on_face(const Wire& a, const Skin& b, const Pose& a_in_b, const OnCurve& from);

/// How such a pair moves: rates (t of a, none, u and v of b).
Moving moving_on_face(const Wire& a, const Skin& b, const CurveMotion& of);

}  // namespace pantin::detail::nurbs
