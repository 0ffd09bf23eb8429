#pragma once
/// The distance of two faces, downhill.
#include "engine/nurbs/common_normal.hpp"

namespace pantin::detail::nurbs {

/// A jet turned by r and moved by `origin`.
Jet in_frame(const Jet& j, const Mat3& r, Vec3 origin);

struct PairDescent {
  PlacePair at;
  Vec3 on_a{0}, on_b{0};
  Real distance = 0;
  bool is_on_edge = false;  // a parameter is held by the end of its domain
};

/// Least distance near `from` on the same two faces, by damped steps kept within their domains.
/// [Levenberg 1944] Where the skins overlap it ends on the line in which they cut one another. No
/// heap.
PairDescent descend(const Meeting& of, const PlacePair& from);

}  // namespace pantin::detail::nurbs
