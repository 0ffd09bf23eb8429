#pragma once
/// The initial contact of two surfaces or curves, and the reasons why it is invalid.
#include <span>
#include <string>

#include "engine/world/surface_contact.hpp"

namespace pantin::detail {

/// The side of its direction on which a curve is outside. A closed planar curve counts as
/// anticlockwise, so its right side is outside.
enum class OuterSide : std::uint8_t { right, left };

/// Prepares a curve for contact: the right of its direction is outside.
std::shared_ptr<const nurbs::Wire> contact_curve(const nurbs::Curve& curve, OuterSide side);

/// "found ..., expected ..." if nothing can slide smoothly along a curve: it has corners or points
/// without a tangent, or a planar one crosses itself. Otherwise empty.
std::string curve_fault(const nurbs::Wire& curve);

/// The largest gap of pairs, m, and the buffer for them.
struct PairReach {
  Real reach = 0;
  std::span<nurbs::CommonNormal> out;
};

/// Finds all pairs of points that face one another with a locally minimal gap within the reach,
/// nearest first, up to the capacity of the buffer. Returns their number.
std::size_t find_pairs(const SurfaceContact& contact, const Pose& a_in_b, const PairReach& to);

struct PairPoses {
  Pose a, b;  // of the bodies' mass-centre frames
};

/// The default number of simultaneous contact points: one for convex surfaces and for bilateral
/// contacts, otherwise four.
std::uint8_t usual_spots(const SurfaceContact& contact);

/// Finds the pair of points with the smallest gap at these poses and sets SurfaceContact::at,
/// unless it is `known`. Returns "found ..., expected ..." if bilateral surfaces do not face one
/// another within their size, if they are conforming, if one has a crease, and if curves are not in
/// one plane; otherwise an empty string.
std::string place_surfaces(SurfaceContact& contact, const PairPoses& bodies);

/// Why the place of a contact that was found at these poses is uncertain: the surfaces nearly
/// conform there, so that small displacements move it far, or another pair of points has nearly the
/// same gap. Otherwise, and where no contact was found, empty.
std::string doubt_of_place(const SurfaceContact& contact, const PairPoses& bodies);

/// Whether surfaces nearly conform at a pair of this curvature of the gap (1/m): rounding decides
/// where they touch.
bool is_place_uncertain(const SurfaceContact& contact, Real least_curvature);

/// A warning about the sharpest crease between joined faces, which no contact can cross; otherwise
/// empty.
std::string crease_between(const ContactSurface& surface, const char* side);

/// The same for unilateral surfaces that are conforming where they are nearest, or both flat, so
/// that they never touch in one point. Takes milliseconds if they are far apart.
std::string fit_between(const SurfaceContact& contact, const PairPoses& bodies);

}  // namespace pantin::detail
