// The cells of a surface, and the trees over them.
#include <algorithm>
#include <cmath>

#include "engine/nurbs/bounds.hpp"
#include "engine/nurbs/cells.hpp"
#include "engine/nurbs/face.hpp"

namespace pantin::detail::nurbs {
namespace {

// rad: cells whose normals turn less are not cut; with many pieces, searches halve cells on demand.
constexpr Real kTurn = kStraight, kTurnOfMany = 1;
constexpr std::size_t kMany = 5000;
constexpr int kMostCuts = 8;    // of a piece, one after the other
constexpr Real kSlack = 1e-13;  // relative: allowance for rounding

struct CutPiece {
  Surface piece;
  int cuts = 0;
};

}  // namespace

void Face::make_leaves(const std::vector<Surface>& pieces) {
  const Real most = pieces.size() > kMany ? kTurnOfMany : kTurn;
  std::vector<CutPiece> open;
  for (auto piece = pieces.rbegin(); piece != pieces.rend(); ++piece) open.push_back({*piece});
  std::vector<Ball> balls;
  std::vector<Region> of_leaves;
  while (!open.empty()) {
    const CutPiece next = std::move(open.back());
    open.pop_back();
    const auto [leaf, region, way] = bounded(next.piece);
    if (leaf.turn <= most || next.cuts == kMostCuts) {
      leaves_.push_back(leaf);
      of_leaves.push_back(region);
      balls.push_back({leaf.centre, leaf.radius});
      continue;
    }
    const Range range = knots_of(next.piece, way).domain();
    open.push_back({part_of(next.piece, way, {range.middle(), range.high}), next.cuts + 1});
    open.push_back({part_of(next.piece, way, {range.low, range.middle()}), next.cuts + 1});
  }
  tree_.build(balls);
  // Branches precede their children.
  regions_.resize(tree_.nodes().size());
  for (std::size_t i = regions_.size(); i-- > 0;) {
    const BallTree::Node& node = tree_.nodes()[i];
    regions_[i] = node.is_leaf ? of_leaves[node.first]
                               : joined(regions_[node.first], regions_[node.first + 1]);
  }
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
