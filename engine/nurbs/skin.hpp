#pragma once
/// The boundary of a body: faces, and the edges at which they join.
///
/// Internal (pantin::detail); installed because a World holds surfaces.
#include <optional>
#include <string>
#include <vector>

#include "engine/nurbs/check.hpp"
#include "engine/nurbs/face.hpp"

namespace pantin::detail::nurbs {

/// The ends of a face's parameters.
enum class Edge { u_low, u_high, v_low, v_high };
inline constexpr int kEdges = 4;

/// A point on a skin: face and parameters.
struct Place {
  int face = 0;
  Real u = 0, v = 0;

  static void fields(auto& self, auto&& field) {
    field("face", self.face);
    field("u", self.u);
    field("v", self.v);
  }
};

/// Faces whose outer side is outside the body; immutable once made or read.
class Skin {
 public:
  /// No faces: for reading.
  Skin() = default;
  /// Edges that coincide within `tolerance` (m) are joined, forward or backward.
  Skin(std::vector<Surface> faces, Real tolerance);
  /// An ellipsoid about the origin, by six charts without poles; with its outer side inwards, as
  /// the wall of a cavity.
  static Skin ellipsoid(Vec3 half_axes);
  static Skin ellipsoid_cavity(Vec3 half_axes);

  const std::vector<Face>& faces() const { return faces_; }
  const Face& face(int i) const { return faces_[static_cast<std::size_t>(i)]; }
  /// Radius of the largest face's ball, m.
  Real size() const { return size_; }
  /// Certainly convex: an ellipsoid by charts, or flat.
  bool is_convex() const { return is_solid_ellipsoid() || is_flat_; }
  /// Whether a place is within the trim of its face.
  bool holds(const Place& at) const { return face(at.face).holds(at.u, at.v); }
  /// The face across an edge; none at a rim.
  std::optional<int> neighbour(int face, Edge edge) const;

  /// Parameters on the neighbouring face after crossing an edge at (u, v); none at a rim.
  std::optional<Place> across(const Place& at, Edge edge) const;

  /// Tolerance for joining edges, m.
  Real tolerance() const { return tolerance_; }
  /// The half axes if it is an ellipsoid by charts, solid or a cavity.
  const std::optional<Vec3>& half_axes() const { return half_axes_; }
  bool is_ellipsoid_cavity() const { return is_cavity_; }
  bool is_solid_ellipsoid() const { return half_axes_ && !is_cavity_; }
  /// Hash of all that it is made of, for hashes of its users.
  std::uint64_t fingerprint() const { return fingerprint_; }

  static void fields(auto& self, auto&& field) {
    field("sources", self.sources_);
    field("tolerance", self.tolerance_);
    field("half_axes", self.half_axes_);
    field("is_cavity", self.is_cavity_);
    field("faces", derived(self.faces_));
    field("joins", derived(self.joins_));
    field("size", derived(self.size_));
    field("is_flat", derived(self.is_flat_));
    field("fingerprint", derived(self.fingerprint_));
  }
  /// Makes the faces after reading; null, or the error.
  const char* restored();

 private:
  enum class OuterSide : std::uint8_t { out, in };
  Skin(Vec3 half_axes, OuterSide side);
  void make_faces(const std::vector<Surface>& surfaces);
  struct Join {
    int face = -1;
    Edge edge = Edge::u_low;
    bool is_backward = false;
  };
  void join(Real tolerance);
  const Join& join_of(int face, Edge edge) const {
    return joins_[static_cast<std::size_t>(face * kEdges + static_cast<int>(edge))];
  }

  std::vector<Surface> sources_;  // of the faces; none of an ellipsoid by charts
  Real tolerance_ = 0;
  std::optional<Vec3> half_axes_;
  bool is_cavity_ = false;  // of the ellipsoid: its outer side is inwards
  std::vector<Face> faces_;
  std::vector<Join> joins_;  // [face * 4 + edge]
  Real size_ = 0;
  bool is_flat_ = false;
  std::uint64_t fingerprint_ = 0;
};

}  // namespace pantin::detail::nurbs
