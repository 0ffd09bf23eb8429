#pragma once
/// Cells of a face as pairs are searched by: a parallelogram, how far the cell strays from it, and
/// the cone of its normals. A cell is a leaf or a part of one; all bounds hold for certain.
#include <span>

#include "engine/nurbs/face.hpp"

namespace pantin::detail::nurbs {

/// A turn below which one start finds what there is in a cell, rad.
inline constexpr Real kStraight = 0.2;

/// Where a face stands in the frame in which cells meet.
struct Standing {
  Mat3 turn{1};
  Vec3 origin{0};
};

struct PatchCell {
  const Face* face = nullptr;
  const Leaf* leaf = nullptr;
  int index = 0;  // of the face in its skin
  Range u, v;
  Real share_u = 1, share_v = 1;  // of the leaf's widths
  Vec3 centre{0};
  Vec3 along_u{0}, along_v{0};  // from the centre to the sides of the parallelogram, m
  Vec3 normal{0};               // unit; 0 if there is none in the middle
  Vec3 sides[2]{};              // unit, across the normal and along_u, along_v; or 0
  Real sag = 0;                 // how far the cell is from its parallelogram at most, m
  Real turn = kPi;              // its normals are within this angle of `normal`, rad

  /// How far it reaches from its centre along a unit vector, to both sides, m.
  Real extent(Vec3 axis) const {
    return std::abs(glm::dot(along_u, axis)) + std::abs(glm::dot(along_v, axis)) + sag;
  }
  /// Whether it is to be cut before one start tells what it holds.
  bool is_bent() const { return turn > kStraight && is_large(); }
  Real width() const { return std::min(glm::length(along_u), glm::length(along_v)); }
  /// Whether it strays so far from flat that it hides one of such a width.
  bool is_curly(Real other_width) const {
    return sag > std::max(width(), other_width) && is_large();
  }

 private:
  bool is_large() const { return share_u * share_v > kSmallest; }
  static constexpr Real kSmallest = 1.0 / 16;  // at points without a normal
};

PatchCell cell_of(const Face& face, const Leaf& leaf, const Standing& at);
/// One half of a cell, across the direction along which its normals turn more; or bends more, of a
/// straight one. No heap.
PatchCell half_of(const PatchCell& cell, int which, const Standing& at);

/// Whether normals of two cells may be opposite, on one line through a point of each, the points no
/// farther apart than `reach`.
bool may_face(const PatchCell& a, const PatchCell& b, Real reach);

/// A lower bound of their distance. `toward` is a further direction to try, unit or 0.
Real least_distance(const PatchCell& a, const PatchCell& b, Vec3 toward);

/// How far to go along each way, from -1 to 1, so that d + sum of them gets short: from one cell's
/// parallelogram to another, each way a vector to a side. By a few rounds, one way after the other.
void approach(Vec3 d, std::span<const Vec3> ways, std::span<Real> shares);

/// May they face one another, and how far are they apart at least: of whole branches of the trees.
bool may_face(const Region& a, const Region& b, const Standing& a_in_b, Real reach);
Real least_distance(const Region& a, const Region& b, const Standing& a_in_b);

}  // namespace pantin::detail::nurbs
