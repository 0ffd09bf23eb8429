#pragma once
/// Common normals of curves: of two in a plane, and of one with a face.
#include "engine/nurbs/closest.hpp"
#include "engine/nurbs/common_normal.hpp"
#include "engine/nurbs/curve_pieces.hpp"

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

/// Which pairs to find, and where to list them.
struct CurveReach {
  Real reach = 0;  // m
  std::span<CurveContact> out;
  SearchCost* cost = nullptr;  // of find_on_face: receives the cost
};

/// The pair near (t, b.u) of two curves with z = 0 that run anticlockwise around their interiors,
/// so that outwards is to the right; `a_in_b` rotates about z only. No heap.
CurveContact track_planar(const Wire& a, const Wire& b, const Pose& a_in_b,
                          std::array<Real, 2> from);
CurveContact track_planar(const CurvePieces& a, const CurvePieces& b, const Pose& a_in_b,
                          std::array<Real, 2> from);

/// All pairs of two such curves whose gap is a local minimum and from -reach to `reach` (m), the
/// least first; as many as `out` holds. Returns how many there are. Starts from every pair of cells
/// whose bounds allow them to face one another. No heap.
std::size_t find_planar(const Wire& a, const Wire& b, const Pose& a_in_b, CurveReach reach);

/// Rates of a pair of curves of the plane while a moves by `twist`: (t of a, none, t of b, none).
struct CurveMotion {
  Pose a_in_b;
  PlacePair at;
  Twist twist;
};
Moving moving_planar(const Wire& a, const Wire& b, const CurveMotion& of);

/// A point of a curve and one of a skin.
struct OnCurve {
  Real t = 0;
  Place b;
};

/// The pair near `from` of a curve, such as an edge or a wire of no thickness, with a skin. No
/// heap.
CurveContact track_on_face(const Wire& a, const Skin& b, const Pose& a_in_b, const OnCurve& from);

/// All such pairs, as find_planar() does; starts from the points closest to the cells of the curve.
std::size_t find_on_face(const Wire& a, const Skin& b, const Pose& a_in_b, CurveReach reach);

/// Rates of such a pair (t of a, none, u and v of b).
Moving moving_on_face(const Wire& a, const Skin& b, const CurveMotion& of);

}  // namespace pantin::detail::nurbs
