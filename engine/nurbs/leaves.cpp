// Bounds of the cells of a surface, by the control points of its pieces.
#include <algorithm>
#include <cmath>

#include "engine/nurbs/face.hpp"

namespace pantin::detail::nurbs {
namespace {

constexpr Real kTurn = 0.5;     // rad: cells that turn no more are not cut
constexpr int kMostCuts = 8;    // of a piece, one after the other
constexpr Real kSlack = 1e-13;  // relative: what rounding may add
constexpr int kOrders = 4;

/// Bounds of the derivatives of a piece about its middle, both parameters from -1 to 1.
struct Bounds {
  Real s[kOrders][kOrders] = {};  // [k][l], m
};

// Largest product and weight among differences of a Bezier net: order k along u, l along v.
std::array<Real, 2> largest_difference(const Surface& piece, Vec3 about, int k, int l) {
  const int p = piece.u.degree, q = piece.v.degree;
  if (k > p || l > q) return {0, 0};
  const int columns = q + 1;
  std::vector<Weighted> net = piece.points;
  for (Weighted& w : net) {
    const Vec3 moved = w.product() - w.w * about;
    w = {moved.x, moved.y, moved.z, w.w};
  }
  const auto at = [&](int i, int j) -> Weighted& {
    return net[static_cast<std::size_t>(i * columns + j)];
  };
  Real scale = 1;
  for (int r = 0; r < k; ++r) {
    scale *= (p - r) / 2.0;
    for (int i = 0; i < p - r; ++i)
      for (int j = 0; j <= q; ++j) at(i, j) = at(i + 1, j) - at(i, j);
  }
  for (int r = 0; r < l; ++r) {
    scale *= (q - r) / 2.0;
    for (int i = 0; i <= p; ++i)
      for (int j = 0; j < q - r; ++j) at(i, j) = at(i, j + 1) - at(i, j);
  }
  std::array<Real, 2> most{0, 0};
  for (int i = 0; i <= p - k; ++i)
    for (int j = 0; j <= q - l; ++j) {
      most[0] = std::max(most[0], scale * glm::length(at(i, j).product()));
      most[1] = std::max(most[1], scale * std::abs(at(i, j).w));
    }
  return most;
}

// By the triangle inequality in the quotient rule.
Bounds bounds_of(const Surface& piece, Vec3 about) {
  constexpr Real kBinomial[4][4] = {{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 2, 1, 0}, {1, 3, 3, 1}};
  Real least = 1e300;
  Bounds b;
  for (const Weighted& w : piece.points) {
    least = std::min(least, w.w);
    b.s[0][0] = std::max(b.s[0][0], glm::distance(w.point(), about));
  }
  std::array<Real, 2> a[kOrders][kOrders] = {};
  for (int k = 0; k < kOrders; ++k)
    for (int l = 0; k + l < kOrders; ++l) {
      a[k][l] = largest_difference(piece, about, k, l);
      if (k + l == 0) continue;
      Real sum = a[k][l][0];
      for (int i = 0; i <= k; ++i)
        for (int j = i == 0 ? 1 : 0; j <= l; ++j)
          sum += kBinomial[k][i] * kBinomial[l][j] * a[i][j][1] * b.s[k - i][l - j];
      b.s[k][l] = sum / least;
    }
  return b;
}

// Bounds by the derivative at the middle and those of one order more are often the better ones: the
// triangle inequality counts twice what cancels.
void sharpen(Bounds& b, const Surface& piece, const Leaf& leaf) {
  const SurfaceDerivatives d = evaluate(piece, leaf.u.middle(), leaf.v.middle(), kOrders - 2);
  const Real hu = leaf.u.width() / 2, hv = leaf.v.width() / 2;
  for (int order = kOrders - 2; order > 0; --order)
    for (int k = 0; k <= order; ++k) {
      const int l = order - k;
      const Real middle = glm::length(d[static_cast<std::size_t>(k)][static_cast<std::size_t>(l)]) *
                          std::pow(hu, k) * std::pow(hv, l);
      b.s[k][l] = std::min(b.s[k][l], (1 + kSlack) * middle + b.s[k + 1][l] + b.s[k][l + 1]);
    }
}

struct CutPiece {
  Surface piece;
  int cuts = 0;
};

// The bounds of a piece as a leaf, and along which way it turns more.
Leaf leaf_of(const Surface& piece, Along& turns_along) {
  Leaf leaf;
  leaf.u = piece.u.domain(), leaf.v = piece.v.domain();
  const SurfaceDerivatives d = evaluate(piece, leaf.u.middle(), leaf.v.middle(), 1);
  leaf.centre = d[0][0];
  Bounds b = bounds_of(piece, leaf.centre);
  sharpen(b, piece, leaf);
  const auto& s = b.s;
  const Vec3 across = glm::cross(d[1][0], d[0][1]) * (leaf.u.width() * leaf.v.width() / 4);
  const Real area = glm::length(across);
  if (area > 0) leaf.normal = across / area;
  const Real along_u = s[2][0] * s[0][1] + s[1][0] * s[1][1];
  const Real along_v = s[1][1] * s[0][1] + s[1][0] * s[0][2];
  turns_along = along_u >= along_v ? Along::u : Along::v;
  const Real change = along_u + along_v;
  leaf.turn = change < area ? std::asin(change / area) : kPi;
  leaf.radius = s[0][0] * (1 + kSlack), leaf.half_thickness = kSlack * s[0][0];
  if (area > 0)
    for (const Weighted& w : piece.points)
      leaf.half_thickness =
          std::max(leaf.half_thickness,
                   (1 + kSlack) * std::abs(glm::dot(leaf.normal, w.point() - leaf.centre)));
  else
    leaf.half_thickness = leaf.radius;
  leaf.first = s[1][0] + s[0][1];
  leaf.second = s[2][0] + 2 * s[1][1] + s[0][2];
  leaf.third = s[3][0] + 3 * s[2][1] + 3 * s[1][2] + s[0][3];
  return leaf;
}

}  // namespace

void Face::make_leaves(const std::vector<Surface>& pieces) {
  std::vector<CutPiece> open;
  for (auto piece = pieces.rbegin(); piece != pieces.rend(); ++piece) open.push_back({*piece});
  std::vector<Ball> balls;
  while (!open.empty()) {
    const CutPiece next = std::move(open.back());
    open.pop_back();
    Along way = Along::u;
    const Leaf leaf = leaf_of(next.piece, way);
    if (leaf.turn <= kTurn || next.cuts == kMostCuts) {
      leaves_.push_back(leaf);
      balls.push_back({leaf.centre, leaf.radius});
      continue;
    }
    const Range range = knots_of(next.piece, way).domain();
    open.push_back({part_of(next.piece, way, {range.middle(), range.high}), next.cuts + 1});
    open.push_back({part_of(next.piece, way, {range.low, range.middle()}), next.cuts + 1});
  }
  tree_.build(balls);
}

// ---- The tree ----------------------------------------------------------------------------------

void BallTree::build(std::span<const Ball> balls) {
  nodes_.clear();
  if (balls.empty()) return;
  std::vector<std::uint32_t> things(balls.size());
  for (std::size_t i = 0; i < things.size(); ++i) things[i] = static_cast<std::uint32_t>(i);
  nodes_.push_back({});
  split(0, things, balls);
}

void BallTree::split(std::uint32_t node, std::span<std::uint32_t> things,
                     std::span<const Ball> balls) {
  Vec3 low(1e300), high(-1e300);
  for (std::uint32_t i : things)
    low = glm::min(low, balls[i].centre), high = glm::max(high, balls[i].centre);
  Ball ball{(low + high) / 2.0, 0};
  for (std::uint32_t i : things)
    ball.radius =
        std::max(ball.radius,
                 (1 + kSlack) * (glm::distance(ball.centre, balls[i].centre) + balls[i].radius));
  nodes_[node].ball = ball;
  if (things.size() == 1) {
    nodes_[node] = {balls[things[0]], things[0], true};
    return;
  }
  const Vec3 wide = high - low;
  const int axis = wide.x >= wide.y && wide.x >= wide.z ? 0 : (wide.y >= wide.z ? 1 : 2);
  const auto half = static_cast<std::ptrdiff_t>(things.size() / 2);
  std::nth_element(things.begin(), things.begin() + half, things.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     const Real x = balls[a].centre[axis], y = balls[b].centre[axis];
                     return x != y ? x < y : a < b;
                   });
  const auto first = static_cast<std::uint32_t>(nodes_.size());
  nodes_[node].first = first;
  nodes_.push_back({}), nodes_.push_back({});
  split(first, things.first(static_cast<std::size_t>(half)), balls);
  split(first + 1, things.subspan(static_cast<std::size_t>(half)), balls);
}

}  // namespace pantin::detail::nurbs
