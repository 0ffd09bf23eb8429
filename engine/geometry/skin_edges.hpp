#pragma once
/// Corners and edges of bodies against one another and against faces: contacts of what is not
/// smooth, where one of the two is a skin.
#include "engine/geometry/skin_model.hpp"

namespace pantin::detail {

/// Appends corners of each at the faces of the other, edges across edges, and the places of edges
/// that are deepest in round faces; in b's frame.
void touch_edges(const SkinPair& pair, SkinScratch& scratch, const PointsOut& out);

/// The same of any other shape, which is a, with a skin, which is b, in the skin's frame. Of a
/// shape without corners only those of the skin.
void touch_edges(const Surface& skin, const PlacedShape& other, SkinScratch& scratch,
                 const PointsOut& out);

}  // namespace pantin::detail
