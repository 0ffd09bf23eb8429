#pragma once
/// Triangles that approximate a skin to a chord tolerance, and integrals over what it encloses.
#include <array>
#include <cstdint>
#include <vector>

#include "engine/nurbs/skin.hpp"

namespace pantin::detail::nurbs {

/// Vertices on the surface, each of one face, with that face's normal. Where faces join their
/// vertices coincide to the bit, so that there are no cracks.
struct Tessellation {
  std::vector<Vec3> points, normals;  // m; outwards, unit
  std::vector<Place> places;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // anticlockwise seen from outside
};

/// Chord errors are at most about `chord` (m); at most 64 cuts to a polynomial piece and direction.
Tessellation tessellate(const Skin& skin, Real chord);

/// The outward normal of a face, unit; at a pole or a degenerate edge that of a nearby point.
Vec3 normal_at(const Face& face, Real u, Real v);

/// Whether a skin has no rim: every edge is joined, periodic or a single point.
bool is_closed(const Skin& skin);

/// Cost of an integral, and its uncertainty: 0 if it is accurate to rounding.
struct Quadrature {
  // Difference between wholes and their parts where a skin is too folded to be subdivided to the
  // end; m^3 of a volume, m^2 of an area.
  Real doubt = 0;
  int looks = 0;  // evaluations
};

/// Integrals over the inside of a closed skin, by Gauss's theorem and quadrature, to rounding.
struct Enclosed {
  Real volume = 0;  // m^3
  Vec3 first{0};    // of x, m^4
  Mat3 second{0};   // of x x^T, m^5
  Quadrature by;
};
Enclosed enclosed_by(const Skin& skin);

/// Area of all faces, m^2; overlaps of an ellipsoid's charts count once.
Real area_of(const Skin& skin, Quadrature* by = nullptr);

}  // namespace pantin::detail::nurbs
