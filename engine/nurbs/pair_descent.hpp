#pragma once
/// Descent of the distance of two faces.
#include "engine/nurbs/common_normal.hpp"

namespace pantin::detail::nurbs {

/// A jet rotated by r and shifted by `origin`.
Jet in_frame(const Jet& j, const Mat3& r, Vec3 origin);

struct PairDescent {
  PlacePair at;
  Vec3 on_a{0}, on_b{0};
  Real distance = 0;
  bool is_on_edge = false;  // a parameter is at an active end of its domain
};

/// Local minimum of the distance near `from` on the same two faces, by damped steps within their
/// domains. [Levenberg 1944] Where the skins overlap, it ends on their curve of intersection. No
/// heap.
PairDescent descend(const Meeting& of, const PlacePair& from);

}  // namespace pantin::detail::nurbs
