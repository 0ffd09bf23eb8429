#pragma once
/// Triangles that stand for a skin, to a chord tolerance, and what the skin encloses.
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

/// Edges are within about `chord` (m) of the surface; at most 64 to a polynomial piece and way.
Tessellation tessellate(const Skin& skin, Real chord);

/// The outward normal of a face, unit; at a pole or a degenerate edge that of a place beside it.
Vec3 normal_at(const Face& face, Real u, Real v);

/// Whether a skin has no rim: every edge is joined, periodic or a single point.
bool is_closed(const Skin& skin);

/// What an integral took, and how far it is from what it should be: to rounding if `doubt` is 0.
struct Quadrature {
  // By how much wholes and their parts disagree where a skin folds so wildly that there was no end
  // to cutting; m^3 of a volume, m^2 of an area.
  Real doubt = 0;
  int looks = 0;  // evaluations
};

/// Integrals over what a closed skin encloses, by Gauss's theorem and quadrature, to rounding.
struct Enclosed {
  Real volume = 0;  // m^3
  Vec3 first{0};    // of x, m^4
  Mat3 second{0};   // of x x^T, m^5
  Quadrature by;
};
Enclosed enclosed_by(const Skin& skin);

/// Of all faces, m^2; charts of an ellipsoid count where they overlap but once.
Real area_of(const Skin& skin, Quadrature* by = nullptr);

}  // namespace pantin::detail::nurbs
