#pragma once
/// Cells of a face for searches of pairs: a parallelogram, the deviation of the cell from it, and
/// the cone of its normals. A cell is a leaf or a part of one; all bounds are guaranteed.
#include <span>

#include "engine/nurbs/face.hpp"

namespace pantin::detail::nurbs {

/// rad: cells whose normals turn by less are searched from one start.
inline constexpr Real kStraight = 0.2;

/// Pose of a face in the frame in which cells are compared.
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
  Real sag = 0;                 // largest distance of the cell from its parallelogram, m
  Real turn = kPi;              // its normals are within this angle of `normal`, rad

  /// Half extent of the cell along a unit vector, m.
  Real extent(Vec3 axis) const {
    return std::abs(glm::dot(along_u, axis)) + std::abs(glm::dot(along_v, axis)) + sag;
  }
  /// Whether it has to be cut before one start finds all that it contains.
  bool is_bent() const { return turn > kStraight && is_large(); }
  Real width() const { return std::min(glm::length(along_u), glm::length(along_v)); }
  /// Whether it deviates so much from flat that a cell of the other width could hide in it.
  bool hides_other_cell(Real other_width) const {
    return sag > std::max(width(), other_width) && is_large();
  }

 private:
  bool is_large() const { return share_u * share_v > kSmallest; }
  static constexpr Real kSmallest = 1.0 / 16;  // at points without a normal
};

PatchCell cell_of(const Face& face, const Leaf& leaf, const Standing& at);
/// One half of a cell, cut across the direction along which its normals turn more; for a straight
/// cell, across the direction of more curvature. No heap.
PatchCell half_of(const PatchCell& cell, int which, const Standing& at);

/// Whether normals of two cells may be opposite, on one line through a point of each, with the
/// points no farther apart than `reach`.
bool may_face(const PatchCell& a, const PatchCell& b, Real reach);

/// A lower bound of the distance. `toward` is a further axis to test, unit or 0.
Real least_distance(const PatchCell& a, const PatchCell& b, Vec3 toward);

/// Finds shares from -1 to 1 that approximately minimise |d + sum of shares * ways|: the nearest
/// points of two cells' parallelograms, whose half edges are the ways. A few rounds of coordinate
/// descent.
void approach(Vec3 d, std::span<const Vec3> ways, std::span<Real> shares);

/// The same two bounds for whole branches of the trees.
bool may_face(const Region& a, const Region& b, const Standing& a_in_b, Real reach);
Real least_distance(const Region& a, const Region& b, const Standing& a_in_b);

}  // namespace pantin::detail::nurbs
