#pragma once
/// Where two surfaces or curves touch at first, and why they cannot.
#include <span>
#include <string>

#include "engine/world/surface_contact.hpp"

namespace pantin::detail {

/// On which side of its way a curve has its outer side; of a closed one of the plane, which is
/// taken to run anticlockwise, right is outside.
enum class OuterSide : std::uint8_t { right, left };

/// A curve made ready to touch: right of its way is its outer side.
std::shared_ptr<const nurbs::Wire> contact_curve(const nurbs::Curve& curve, OuterSide side);

/// "found ..., expected ..." where nothing slides smoothly along a curve: corners, places without a
/// tangent; and where one of the plane crosses itself. Else nothing.
std::string curve_fault(const nurbs::Wire& curve);

/// How far apart pairs may be, m, and where they go.
struct PairReach {
  Real reach = 0;
  std::span<nurbs::CommonNormal> out;
};

/// All pairs of places that face one another with a gap that is a least one and no larger than the
/// reach, the nearest first; as many as there is room for. Returns how many there are.
std::size_t find_pairs(const SurfaceContact& contact, const Pose& a_in_b, const PairReach& to);

struct PairPoses {
  Pose a, b;  // of the bodies' mass-centre frames
};

/// At how many places surfaces like these may touch at once, where nobody says: one for those
/// without hollows and those that are held, else four.
std::uint8_t usual_spots(const SurfaceContact& contact);

/// Finds the pair of places whose gap is the smallest, with the bodies at these poses, and sets
/// SurfaceContact::at; leaves what is `known`. Returns "found ..., expected ..." where surfaces
/// that are held do not face one another within their size, where they fit one another, where
/// one has a crease, and where curves do not lie in one plane; else nothing.
std::string place_surfaces(SurfaceContact& contact, const PairPoses& bodies);

/// What there is to warn of: the sharpest crease between joined faces, which no contact crosses;
/// else nothing.
std::string crease_between(const ContactSurface& surface, const char* side);

/// The same of surfaces that may lift off: that they fit one another where they are nearest, or are
/// both flat, so that they never touch in one point. Takes milliseconds where they are far apart.
std::string fit_between(const SurfaceContact& contact, const PairPoses& bodies);

}  // namespace pantin::detail
