// Curves prepared for queries, and their nearest points.
#include <algorithm>
#include <cmath>

#include "engine/nurbs/check.hpp"
#include "engine/nurbs/closest.hpp"

namespace pantin::detail::nurbs {
namespace {

constexpr Real kAlike = 1e-12, kNoDistance = 1e-30, kSlack = 1e-13;
constexpr std::uint32_t kMostLooks = 20000;
constexpr int kMostCuts = 6, kMostSteps = 60;

// Bounds about the middle of a piece, its parameter from -1 to 1; by the quotient rule.
Wire::Leaf leaf_of(const Curve& piece) {
  constexpr Real kBinomial[4][4] = {{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 2, 1, 0}, {1, 3, 3, 1}};
  Wire::Leaf leaf{.t = piece.knots.domain()};
  leaf.centre = evaluate(piece, leaf.t.middle(), 0)[0];
  const int p = piece.knots.degree;
  std::vector<Weighted> net = piece.points;
  Real least = 1e300, a[4] = {}, w[4] = {}, s[4] = {};
  for (Weighted& point : net) {
    least = std::min(least, point.w);
    s[0] = std::max(s[0], glm::distance(point.point(), leaf.centre));
    const Vec3 moved = point.product() - point.w * leaf.centre;
    point = {moved.x, moved.y, moved.z, point.w};
  }
  Real scale = 1;
  for (int k = 1; k < 4 && k <= p; ++k) {
    scale *= (p - k + 1) / 2.0;
    for (std::size_t i = 0; i + 1 < net.size(); ++i) net[i] = net[i + 1] - net[i];
    net.pop_back();
    for (const Weighted& d : net) {
      a[k] = std::max(a[k], scale * glm::length(d.product()));
      w[k] = std::max(w[k], scale * std::abs(d.w));
    }
  }
  for (int k = 1; k < 4; ++k) {
    Real sum = a[k];
    for (int i = 1; i <= k; ++i) sum += kBinomial[k][i] * w[i] * s[k - i];
    s[k] = sum / least;
  }
  leaf.radius = s[0] * (1 + kSlack), leaf.first = s[1], leaf.second = s[2], leaf.third = s[3];
  return leaf;
}

}  // namespace

Wire::Wire(Curve curve) : curve_(std::move(curve)), size_(bounding_ball(curve_.points).radius) {
  std::vector<Ball> balls;
  struct Cut {
    Curve piece;
    int cuts;
  };
  std::vector<Cut> open;
  const std::vector<Curve> pieces = bezier_pieces(curve_);
  for (auto piece = pieces.rbegin(); piece != pieces.rend(); ++piece) open.push_back({*piece, 0});
  while (!open.empty()) {
    const Cut next = std::move(open.back());
    open.pop_back();
    const Leaf leaf = leaf_of(next.piece);
    const Real speed =
        glm::length(evaluate(next.piece, leaf.t.middle(), 1)[1]) * leaf.t.width() / 2;
    if (leaf.second < 0.3 * speed || next.cuts == kMostCuts) {
      leaves_.push_back(leaf);
      leaves_.back().span = curve_.knots.span_at(leaf.t.middle());
      balls.push_back({leaf.centre, leaf.radius});
      continue;
    }
    open.push_back({part_of(next.piece, {leaf.t.middle(), leaf.t.high}), next.cuts + 1});
    open.push_back({part_of(next.piece, {leaf.t.low, leaf.t.middle()}), next.cuts + 1});
  }
  tree_.build(balls);
  Hash hash;
  hash_fields(hash, curve_);
  fingerprint_ = hash.value();
}

const char* Wire::restored() {
  if (!errors_of(curve_, "curve").empty()) return "is a curve that cannot be evaluated";
  *this = Wire(std::move(curve_));
  return nullptr;
}

namespace {

class Search {
 public:
  Search(const Wire& wire, Vec3 p) : wire_(wire), p_(p) {}
  NearestPoint run();

 private:
  struct Height {
    Vec3 point;
    Real f, slope, bend;
  };
  // By the polynomials of one span: beyond a kink they do not hold.
  Height height_at(int span, Real t, Real h) {
    const CurveDerivatives c = evaluate_on(wire_.curve(), span, t, 2);
    ++best_.looks;
    const Vec3 d = c[0] - p_;
    return {c[0], glm::dot(d, d) / 2, glm::dot(d, c[1]) * h,
            (glm::dot(c[1], c[1]) + glm::dot(d, c[2])) * h * h};
  }
  void keep(Real t, const Height& h) {
    const Real distance = std::sqrt(2 * h.f);
    if (distance < best_.distance) best_.u = t, best_.point = h.point, best_.distance = distance;
  }
  void descend(const Wire::Leaf& leaf, Range range, Real t);
  void look_into(const Wire::Leaf& leaf);
  Real wanted() const {
    return best_.distance * best_.distance / 2 * (1 - kAlike) -
           kNoDistance * wire_.size() * wire_.size();
  }

  const Wire& wire_;
  Vec3 p_;
  NearestPoint best_{.distance = 1e300};
};

// Newton's method within a range, with the parameter scaled to it.
void Search::descend(const Wire::Leaf& leaf, Range range, Real t) {
  const Real width = range.width();
  const int span = leaf.span;
  Height h = height_at(span, t, width);
  for (int round = 0; round < kMostSteps; ++round) {
    const Real way = -h.slope / std::max(std::abs(h.bend), 1e-300), length = std::abs(way);
    if (!(length > 1e-16)) break;
    bool has_moved = false;
    for (Real part = std::min(1.0, 0.5 / length); part > 1e-9; part /= 4) {
      const Real to = range.clamped(t + part * way * width);
      if (to == t) break;
      const Height there = height_at(span, to, width);
      if (length >= 1e-7 && !(there.f < h.f)) continue;
      t = to, h = there, has_moved = true;
      break;
    }
    if (!has_moved || length < 1e-13) break;
  }
  keep(t, h);
}

void Search::look_into(const Wire::Leaf& leaf) {
  struct Open {
    Range t;
    Real scale;
  };
  constexpr std::size_t kRoom = 64;
  Open stack[kRoom];
  std::size_t depth = 0;
  stack[depth++] = {leaf.t, 1};
  const Real reach = glm::distance(leaf.centre, p_) + leaf.radius;
  const int span = leaf.span;
  while (depth > 0) {
    const Open cell = stack[--depth];
    const Real t = cell.t.middle(), scale = cell.scale;
    const Height h = height_at(span, t, cell.t.width() / 2);
    keep(t, h);
    const Real twist = (3 * leaf.first * leaf.second + reach * leaf.third) * scale * scale * scale;
    const bool is_convex = h.bend > twist;
    const Real sag = is_convex ? 0 : std::min(0.0, h.bend) / 2 - twist / 6;
    if (h.f - std::abs(h.slope) + sag >= wanted()) continue;
    if (is_convex) {
      descend(leaf, cell.t, t);
      continue;
    }
    // Where f is monotonic, its minimum is at that end.
    if (std::abs(h.slope) > std::abs(h.bend) + twist / 2) {
      const Real end = h.slope > 0 ? cell.t.low : cell.t.high;
      keep(end, height_at(span, end, 1));
      continue;
    }
    const bool is_small = leaf.first * scale < 1e-8 * wire_.size();
    if (is_small || depth + 2 > kRoom || best_.looks > kMostLooks) {
      if (!is_small) best_.is_certain = false;
      continue;
    }
    stack[depth++] = {{cell.t.low, t}, scale / 2};
    stack[depth++] = {{t, cell.t.high}, scale / 2};
  }
}

NearestPoint Search::run() {
  wire_.tree().visit(
      wire_.tree().from(p_), [&] { return best_.distance; },
      [&](std::uint32_t index) {
        const Wire::Leaf& leaf = wire_.leaves()[index];
        if (best_.distance == 1e300) descend(leaf, leaf.t, leaf.t.middle());
        look_into(leaf);
      });
  const Knots& k = wire_.knots();
  best_.is_on_edge = !k.is_periodic && (best_.u <= k.low() || best_.u >= k.high());
  return best_;
}

}  // namespace

NearestPoint closest_point(const Wire& wire, Vec3 p) { return Search(wire, p).run(); }

}  // namespace pantin::detail::nurbs
