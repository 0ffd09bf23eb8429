#pragma once
/// Triangles of a face without what its loops trim off.
#include <span>

#include "engine/nurbs/tessellate.hpp"

namespace pantin::detail::nurbs {

/// A face of a skin, and the first of its triangles, which are the last ones.
struct TilesOfFace {
  int face;
  std::size_t first;
};
/// Cuts the triangles of a face down to its trim: vertices along
/// the loops are on them, and chords leave them by at most about `chord` (m). Slivers thinner than
/// sixteen chords may be lost.
void trim_tiles(const Skin& skin, TilesOfFace of, Real chord, Tessellation& tiles);

/// Removes the vertices that belong to no triangle.
void drop_unused_points(Tessellation& tiles);

}  // namespace pantin::detail::nurbs
