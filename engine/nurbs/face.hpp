#pragma once
/// A surface prepared for contact: fast evaluation of its pieces, and bounds for searches.
///
/// Internal (pantin::detail); installed because a World holds surfaces.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/nurbs/spline.hpp"

namespace pantin::detail::nurbs {

/// A point of a surface and its derivatives to order 2, in the surface's frame.
struct Jet {
  Vec3 s{0}, u{0}, v{0}, uu{0}, uv{0}, vv{0};
};

/// Bounds of one cell of a surface, within one polynomial piece. All are guaranteed.
struct Leaf {
  Range u, v;
  // The cell is within a disc about `centre`, its own middle: no farther than `radius` from it and
  // `half_thickness` from the plane across `normal`, m.
  Vec3 centre{0}, normal{0};
  Real radius = 0, half_thickness = 0;
  Real turn = kPi;  // its normals are within this angle of `normal`, rad
  // Derivatives by parameters from -1 to 1 over the cell, m: the first ones in its middle, and
  // bounds over the cell, for each order from pure u to pure v.
  Vec3 along_u{0}, along_v{0};
  Real first[2] = {}, second[3] = {}, third[4] = {};

  /// Largest distance of the cell from the parallelogram of its middle, m.
  Real sag() const { return (second[0] + 2 * second[1] + second[2]) / 2; }
  /// Lower bound of the distance by which d, from its centre, is outside along a unit vector.
  Real outside(Vec3 d, Vec3 axis) const {
    const Real extent =
        std::abs(glm::dot(along_u, axis)) + std::abs(glm::dot(along_v, axis)) + sag();
    return std::max(std::abs(glm::dot(d, axis)) - extent, 0.0);
  }
};

/// Bounds of a branch of the tree, in the surface's frame: extent and normals.
struct Region {
  Vec3 low{0}, high{0};
  Vec3 normal{0};
  Real turn = kPi;  // its normals are within this angle of `normal`, rad

  /// Distance of its box from p, m.
  Real distance(Vec3 p) const { return glm::length(p - glm::clamp(p, low, high)); }
};

/// A tree of bounding balls of numbered items.
class BallTree {
 public:
  struct Node {
    Ball ball;
    std::uint32_t first = 0;  // leaf: the item; branch: of its two nodes, side by side
    bool is_leaf = false;
  };

  void build(std::span<const Ball> balls);
  const std::vector<Node>& nodes() const { return nodes_; }

  /// Calls `found(item)` for items whose lower bound `least(node)` is at most `limit()`,
  /// approximately nearest first. `limit` is evaluated again every time.
  template <class Least, class Limit, class Found>
  void visit(Least&& least, Limit&& limit, Found&& found) const {
    if (nodes_.empty()) return;
    std::uint32_t stack[kDeepest], depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
      const std::uint32_t index = stack[--depth];
      const Node& node = nodes_[index];
      if (least(index) > limit()) continue;
      if (node.is_leaf) {
        found(node.first);
        continue;
      }
      const bool swap = least(node.first) > least(node.first + 1);
      stack[depth++] = node.first + (swap ? 0 : 1);
      stack[depth++] = node.first + (swap ? 1 : 0);
    }
  }

  /// The distance of a node's ball from p, m; below 0 within it.
  auto from(Vec3 p) const {
    return [this, p](std::uint32_t node) {
      return glm::distance(nodes_[node].ball.centre, p) - nodes_[node].ball.radius;
    };
  }

 private:
  static constexpr std::uint32_t kDeepest = 64;
  void split(std::uint32_t node, std::span<std::uint32_t> things, std::span<const Ball> balls);
  std::vector<Node> nodes_;
};

class Trim;

/// A surface that has passed errors_of(). Immutable: copies and threads share it.
class Face {
 public:
  explicit Face(Surface surface);

  const Surface& surface() const { return surface_; }
  const Knots& u() const { return surface_.u; }
  const Knots& v() const { return surface_.v; }
  /// Radius of a ball around it, m.
  Real size() const { return size_; }

  /// Point and derivatives; parameters within the domain. No heap.
  Jet at(Real u, Real v) const { return at(piece_at(u, v), u, v); }
  /// One of the polynomial pieces; the choice matters at knots where the surface has a crease.
  struct Piece {
    std::size_t u = 0, v = 0;
  };
  Piece piece_at(Real u, Real v) const { return {by_u_.find(u), by_v_.find(v)}; }
  Jet at(Piece piece, Real u, Real v) const;

  /// Its loops; null if it is not trimmed.
  const Trim* trim() const { return trim_.get(); }
  /// Whether a place is within the loops, which belong to the face.
  bool holds(Real u, Real v) const { return !trim_ || is_within_trim(u, v); }

  const std::vector<Leaf>& leaves() const { return leaves_; }
  const BallTree& tree() const { return tree_; }
  /// By node of the tree.
  const std::vector<Region>& regions() const { return regions_; }

 private:
  void make_pieces(const std::vector<Surface>& pieces);
  void make_leaves(const std::vector<Surface>& pieces);
  bool is_within_trim(Real u, Real v) const;

  /// Starts of the pieces of one direction; the local parameter in a piece is from -1/2 to 1/2.
  struct Pieces {
    std::vector<Real> starts;  // one for each piece
    std::vector<int> spans;
    std::vector<Real> middles, inverse;  // and of their widths
    std::size_t find(Real t) const;
  };

  Surface surface_;
  Pieces by_u_, by_v_;
  // Of degree 3 at most: for each piece the coefficients of u^i v^j, four numbers each.
  std::vector<Real> coefficients_;
  std::vector<Leaf> leaves_;
  BallTree tree_;
  std::vector<Region> regions_;
  std::shared_ptr<const Trim> trim_;
  Real size_ = 0;
};

}  // namespace pantin::detail::nurbs
