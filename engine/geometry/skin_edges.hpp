#pragma once
/// Contacts of corners and edges with faces and with one another, where at least one of the two
/// bodies is a skin.
#include "engine/geometry/skin_model.hpp"

namespace pantin::detail {

/// Appends, in b's frame, the corners of each on faces of the other, edges across edges, and the
/// points of edges that are deepest in round faces.
void touch_edges(const SkinPair& pair, SkinScratch& scratch, const PointsOut& out);

/// The same for any other shape, which is a, and a skin, which is b, in the skin's frame. A smooth
/// shape contributes its support features; one that is not convex contributes none.
void touch_edges(const Surface& skin, const PlacedShape& other, SkinScratch& scratch,
                 const PointsOut& out);

}  // namespace pantin::detail
