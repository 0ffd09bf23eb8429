#pragma once
/// Creases, rims and corners of a skin: its contact features besides smooth points.
#include <array>
#include <cstdint>
#include <vector>

#include "engine/base/math.hpp"
#include "engine/geometry/aabb_tree.hpp"
#include "engine/nurbs/skin.hpp"

namespace pantin::detail {

/// A point that may touch faces, and the directions in which its body extends from it. It may touch
/// a face if none of them leads behind the face: a corner of a block, or a point of a round edge.
struct Corner {
  static constexpr std::size_t kMostWays = 8;
  Vec3 point{0};
  std::array<Vec3, kMostWays> ways;  // unit, away from the point
  std::uint32_t count = 0;
  std::uint32_t number = 0;  // identifies the corner from step to step

  void add(Vec3 way) {
    if (count < kMostWays) ways[count++] = way;
  }
};

/// The point of a face above or below a corner.
struct Foot {
  Vec3 point, normal;  // m; outwards, unit
  Real gap;            // m, below 0 behind it
};

/// A line of a skin's face on which one parameter is constant, or part of a loop that trims it.
struct EdgeLine {
  int face = -1;
  nurbs::Along stays = nurbs::Along::u;
  Real fixed = 0;
  nurbs::Range along;  // of the other parameter, or of the loop's
  int loop = -1;       // which loop; below 0: a line
};

/// Part of a convex edge with little curvature: the outward normals of both faces, and the
/// directions from the edge into them. On a rim both belong to its one face.
struct EdgePart {
  Vec3 from{0}, to{0};  // m
  std::array<Vec3, 2> normals, into;
  std::uint32_t number = 0;
  bool is_straight = true;
  // Round edges only: the curve, and the corners at its ends, if there are any.
  EdgeLine line;
  std::array<std::uint32_t, 2> ends{UINT32_MAX, UINT32_MAX};
};

/// Derived from the skin; immutable. Points of round edges are among the corners.
struct SkinFeatures {
  std::vector<Corner> corners;
  std::vector<EdgePart> edges;
  AabbTree corner_tree, edge_tree;
};

/// Creases of less than about a degree count as smooth; concave ones cannot touch.
SkinFeatures features_of(const nurbs::Skin& skin);

/// A point of an edge of a skin and its derivative by `share`, which is 0 at `from`, 1 at `to`.
struct EdgePoint {
  Vec3 point{0}, rate{0};
};
EdgePoint point_of(const nurbs::Skin& skin, const EdgePart& edge, Real share);

}  // namespace pantin::detail
