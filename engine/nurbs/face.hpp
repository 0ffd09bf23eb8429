#pragma once
/// A surface made ready for contact: pieces that are evaluated fast, and bounds to search by.
///
/// Internal (pantin::detail); installed because a World holds surfaces.
#include <cstdint>
#include <vector>

#include "engine/nurbs/spline.hpp"

namespace pantin::detail::nurbs {

/// A point of a surface and its derivatives to order 2, in the surface's frame.
struct Jet {
  Vec3 s{0}, u{0}, v{0}, uu{0}, uv{0}, vv{0};
};

/// Bounds of one cell of a surface, within one polynomial piece. All hold for certain.
struct Leaf {
  Range u, v;
  // The cell lies within a disc about `centre`, its own middle: no farther than `radius` from it
  // and `half_thickness` from the plane across `normal`, m.
  Vec3 centre{0}, normal{0};
  Real radius = 0, half_thickness = 0;
  Real turn = kPi;  // its normals are within this angle of `normal`, rad
  // Bounds of the first, second and third derivative along any way that stays in the cell, with
  // both parameters from -1 to 1 over it, m.
  Real first = 0, second = 0, third = 0;
};

/// A tree of balls around numbered things.
class BallTree {
 public:
  struct Node {
    Ball ball;
    std::uint32_t first = 0;  // leaf: the thing; branch: of its two nodes, side by side
    bool is_leaf = false;
  };

  void build(std::span<const Ball> balls);
  const std::vector<Node>& nodes() const { return nodes_; }

  /// Calls `found(thing)` for those whose distance from p may be below `limit()`, nearest first as
  /// far as the balls tell; `limit` is asked again every time.
  template <class Limit, class Found>
  void visit(Vec3 p, Limit&& limit, Found&& found) const {
    if (nodes_.empty()) return;
    const auto least = [&](const Node& n) {
      return glm::distance(n.ball.centre, p) - n.ball.radius;
    };
    std::uint32_t stack[kDeepest], depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
      const Node& node = nodes_[stack[--depth]];
      if (least(node) > limit()) continue;
      if (node.is_leaf) {
        found(node.first);
        continue;
      }
      const bool swap = least(nodes_[node.first]) > least(nodes_[node.first + 1]);
      stack[depth++] = node.first + (swap ? 0 : 1);
      stack[depth++] = node.first + (swap ? 1 : 0);
    }
  }

 private:
  static constexpr std::uint32_t kDeepest = 64;
  void split(std::uint32_t node, std::span<std::uint32_t> things, std::span<const Ball> balls);
  std::vector<Node> nodes_;
};

/// A surface that has passed errors_of(). Immutable after it is made: copies and threads share it.
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
  /// One of the polynomial pieces; which it is matters at knots where the surface has a crease.
  struct Piece {
    std::size_t u = 0, v = 0;
  };
  Piece piece_at(Real u, Real v) const { return {by_u_.find(u), by_v_.find(v)}; }
  Jet at(Piece piece, Real u, Real v) const;

  const std::vector<Leaf>& leaves() const { return leaves_; }
  const BallTree& tree() const { return tree_; }

 private:
  void make_pieces(const std::vector<Surface>& pieces);
  void make_leaves(const std::vector<Surface>& pieces);

  /// Where the pieces of one direction begin; a parameter's place in its piece is from -1/2 to 1/2.
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
  Real size_ = 0;
};

}  // namespace pantin::detail::nurbs
