#pragma once
/// Targets of corners and edges: the faces of a skin, the flat faces of a convex piece, or the
/// nearest points of any other shape.
#include <optional>

#include "engine/geometry/skin_model.hpp"

namespace pantin::detail {

/// Distances up to which features count, m.
struct Reach {
  Real margin, deepest, shallow, beside;

  Real farthest() const { return std::max(margin, deepest); }
};

/// For two closed bodies of these sizes (m).
Reach reach_between(Real margin, Real size_a, Real size_b);
/// For a body of a size (m) against a skin; behind an open patch the depth grows with that size.
Reach reach_into(const Surface& surface, Real size, Real margin);

/// Each target has foot(corner): the nearest face that a corner is over and may touch; holds(p):
/// whether a point is inside; is_round_near(box): whether edges near the box may touch between
/// their ends.
///
/// The faces of a skin, in its frame.
struct SkinTarget {
  const Surface& surface;
  Reach reach;

  bool holds(Vec3 p) const;
  bool is_round_near(const Aabb& box) const;
  std::optional<Foot> foot(const Corner& corner) const;

 private:
  std::optional<Foot> over(std::uint32_t tile, const Corner& corner) const;
  std::optional<std::uint32_t> tile_under(const Corner& corner, Real far) const;
};

/// The flat faces of a piece with corners.
struct ConvexTarget {
  const Convex& piece;
  Reach reach;

  bool holds(Vec3 p) const;
  bool is_round_near(const Aabb&) const { return false; }
  std::optional<Foot> foot(const Corner& corner) const;

 private:
  bool is_over(const Face& face, Vec3 p) const;
};

/// Any other shape, by its nearest points.
struct ShapeTarget {
  const PlacedShape& shape;
  Reach reach;

  bool holds(Vec3) const { return true; }
  bool is_round_near(const Aabb&) const { return is_convex(shape.shape.kind); }
  std::optional<Foot> foot(const Corner& corner) const;
};

}  // namespace pantin::detail
