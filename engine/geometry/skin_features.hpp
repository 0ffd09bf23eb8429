#pragma once
/// Creases, rims and corners of a skin: what of it may touch besides its smooth places.
#include <array>
#include <cstdint>
#include <vector>

#include "engine/base/math.hpp"
#include "engine/geometry/aabb_tree.hpp"
#include "engine/nurbs/skin.hpp"

namespace pantin::detail {

/// A point that may touch faces, and the ways along which its body begins there. It may touch
/// where none of them leads behind the face: a corner of a block, or a place of a round edge.
struct Corner {
  static constexpr std::size_t kMostWays = 8;
  Vec3 point{0};
  std::array<Vec3, kMostWays> ways;  // unit, away from the point
  std::uint32_t count = 0;
  std::uint32_t number = 0;  // stays with the place of the body

  void add(Vec3 way) {
    if (count < kMostWays) ways[count++] = way;
  }
};

/// The place of a face that a corner is over, or below.
struct Foot {
  Vec3 point, normal;  // m; outwards, unit
  Real gap;            // m, below 0 behind it
};

/// The line of a face of a skin on which one of its parameters stays.
struct EdgeLine {
  int face = -1;
  nurbs::Along stays = nurbs::Along::u;
  Real fixed = 0;
  nurbs::Range along;  // of the other parameter
};

/// Part of a convex edge that turns little: the two faces' outward normals, and the ways into the
/// faces from it. Of a rim both are those of its one face.
struct EdgePart {
  Vec3 from{0}, to{0};  // m
  std::array<Vec3, 2> normals, into;
  std::uint32_t number = 0;
  bool is_straight = true;
  // Of one that is not straight: where it is, and the corners at its ends, if there are any.
  EdgeLine line;
  std::array<std::uint32_t, 2> ends{UINT32_MAX, UINT32_MAX};
};

/// Follows from the skin; immutable. Places of round edges are among the corners.
struct SkinFeatures {
  std::vector<Corner> corners;
  std::vector<EdgePart> edges;
  AabbTree corner_tree, edge_tree;
};

/// Creases of less than about a degree count as smooth, hollow ones cannot touch.
SkinFeatures features_of(const nurbs::Skin& skin);

/// A place of an edge of a skin, and how it moves with `share`, which is 0 at `from`, 1 at `to`.
struct EdgePoint {
  Vec3 point{0}, rate{0};
};
EdgePoint point_of(const nurbs::Skin& skin, const EdgePart& edge, Real share);

}  // namespace pantin::detail
