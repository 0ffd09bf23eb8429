#pragma once
/// Points of surfaces and curves that are nearest to a given one. Global, by branch and bound over
/// cells: each cell is discarded by a bound, or f is convex in it, so that a descent finds its
/// minimum.
///
/// Internal (pantin::detail); installed because a World holds surfaces.
#include <cstdint>

#include "engine/nurbs/face.hpp"

namespace pantin::detail::nurbs {

struct NearestPoint {
  Real u = 0, v = 0;  // of a curve t, 0
  Vec3 point{0};
  Real distance = 0;        // m
  bool is_on_edge = false;  // at the end of a direction that is not periodic, or on a trim
  bool is_certain = true;   // false: too many cells are undecided, as at a sphere's centre
  std::uint32_t looks = 0;  // evaluations, as a measure of cost
};

/// The nearest point of a face to p, in the face's frame: the global minimum, within 1e-12 of it.
/// Of a trimmed face by Trim::closest() where it is on a loop. No heap.
NearestPoint closest_point(const Face& face, Vec3 p);

/// The local minimum found by descent from (u, v), within the domain, whatever trims the face.
NearestPoint closest_from(const Face& face, Vec3 p, std::array<Real, 2> start);

/// A curve prepared for queries: bounds of its cells.
class Wire {
 public:
  /// No curve: for reading.
  Wire() = default;
  explicit Wire(Curve curve);
  const Curve& curve() const { return curve_; }
  const Knots& knots() const { return curve_.knots; }
  Real size() const { return size_; }

  struct Leaf {
    Range t;
    int span = 0;  // of the knots, by whose polynomials it is evaluated
    Vec3 centre{0};
    Real radius = 0;                        // m
    Real first = 0, second = 0, third = 0;  // as of a Leaf of a Face
  };
  const std::vector<Leaf>& leaves() const { return leaves_; }
  const BallTree& tree() const { return tree_; }
  std::uint64_t fingerprint() const { return fingerprint_; }

  static void fields(auto& self, auto&& field) {
    field("curve", self.curve_);
    field("leaves", derived(self.leaves_));
    field("tree", derived(self.tree_));
    field("size", derived(self.size_));
    field("fingerprint", derived(self.fingerprint_));
  }
  /// Makes the cells after reading; null, or the error.
  const char* restored();

 private:
  Curve curve_;
  std::vector<Leaf> leaves_;
  BallTree tree_;
  Real size_ = 0;
  std::uint64_t fingerprint_ = 0;
};

NearestPoint closest_point(const Wire& wire, Vec3 p);

}  // namespace pantin::detail::nurbs
