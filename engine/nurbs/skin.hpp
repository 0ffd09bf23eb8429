#pragma once
/// What surrounds a body: faces, and across which edges they join.
#include <optional>
#include <string>
#include <vector>

#include "engine/nurbs/check.hpp"
#include "engine/nurbs/face.hpp"

namespace pantin::detail::nurbs {

/// The ends of a face's parameters.
enum class Edge { u_low, u_high, v_low, v_high };
inline constexpr int kEdges = 4;

/// A place on a skin.
struct Place {
  int face = 0;
  Real u = 0, v = 0;
};

/// Faces whose outer side is outside the body; immutable after it is made.
class Skin {
 public:
  /// Edges that coincide within `tolerance` (m) are joined, forward or backward.
  Skin(std::vector<Surface> faces, Real tolerance);
  /// An ellipsoid about the origin, by six charts without poles.
  static Skin ellipsoid(Vec3 half_axes);

  const std::vector<Face>& faces() const { return faces_; }
  const Face& face(int i) const { return faces_[static_cast<std::size_t>(i)]; }
  /// Radius of the largest face's ball, m.
  Real size() const { return size_; }
  /// The face across an edge; none at a rim.
  std::optional<int> neighbour(int face, Edge edge) const;

  /// Where one arrives who leaves a face across an edge at (u, v) on it; none at a rim.
  std::optional<Place> across(const Place& at, Edge edge) const;

 private:
  explicit Skin(Vec3 half_axes);
  struct Join {
    int face = -1;
    Edge edge = Edge::u_low;
    bool is_backward = false;
  };
  void join(Real tolerance);
  const Join& join_of(int face, Edge edge) const {
    return joins_[static_cast<std::size_t>(face * kEdges + static_cast<int>(edge))];
  }

  std::vector<Face> faces_;
  std::vector<Join> joins_;  // [face * 4 + edge]
  std::optional<Vec3> half_axes_;
  Real size_ = 0;
};

}  // namespace pantin::detail::nurbs
