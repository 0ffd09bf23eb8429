#include "engine/nurbs/closest.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/nurbs/trim.hpp"

namespace pantin::detail::nurbs {
namespace {

constexpr Real kAlike = 1e-12;       // of the least f: smaller differences count as equal
constexpr Real kNoDistance = 1e-30;  // of size^2: the same for f near 0
constexpr std::uint32_t kMostLooks = 20000;
constexpr int kMostSteps = 60;
constexpr Real kLong = 4;  // length to width: longer cells are cut across

/// f = |S - p|^2 / 2 at a place, with gradient and second derivatives by parameters scaled by `h`.
struct Height {
  Real f, gu, gv, huu, huv, hvv;

  Real least_bend() const {
    return (huu + hvv) / 2 - std::sqrt((huu - hvv) * (huu - hvv) / 4 + huv * huv);
  }
};

Height height_of(const Jet& j, Vec3 p, std::array<Real, 2> h) {
  const Vec3 d = j.s - p;
  return {glm::dot(d, d) / 2,
          glm::dot(d, j.u) * h[0],
          glm::dot(d, j.v) * h[1],
          (glm::dot(j.u, j.u) + glm::dot(d, j.uu)) * h[0] * h[0],
          (glm::dot(j.u, j.v) + glm::dot(d, j.uv)) * h[0] * h[1],
          (glm::dot(j.v, j.v) + glm::dot(d, j.vv)) * h[1] * h[1]};
}

struct Box {
  Range u, v;
  // For a cell: its polynomial piece.
  std::optional<Face::Piece> piece = std::nullopt;
};

Jet jet_in(const Face& face, const Box& box, std::array<Real, 2> at) {
  return box.piece ? face.at(*box.piece, at[0], at[1]) : face.at(at[0], at[1]);
}

// ---- Descent ------------------------------------------------------------------------------------

/// Newton's method for f within a box. Second derivatives that are not positive definite are
/// shifted until they are; steps are shortened until f falls.
class Descent {
 public:
  Descent(const Face& face, Vec3 p, Box box) : face_(face), p_(p), box_(box) {}

  NearestPoint from(std::array<Real, 2> start);

 private:
  std::array<Real, 2> step(const Height& h, std::array<Real, 2> at) const;
  std::array<Real, 2> downhill(const Height& h, std::array<Real, 2> at) const;
  std::array<Real, 2> inside(Real u, Real v) const {
    return {box_.u.clamped(u), box_.v.clamped(v)};
  }

  const Face& face_;
  Vec3 p_;
  Box box_;
};

// In parameters scaled to the box. Parameters at an active bound do not move.
std::array<Real, 2> Descent::step(const Height& h, std::array<Real, 2> at) const {
  const bool holds_u = box_.u.width() == 0 || (at[0] <= box_.u.low && h.gu > 0) ||
                       (at[0] >= box_.u.high && h.gu < 0);
  const bool holds_v = box_.v.width() == 0 || (at[1] <= box_.v.low && h.gv > 0) ||
                       (at[1] >= box_.v.high && h.gv < 0);
  const Real size = std::max(std::abs(h.huu), std::abs(h.hvv)) + std::abs(h.huv);
  if (holds_u && holds_v) return {0, 0};
  const auto single = [&](Real g, Real bend) {
    return -g / std::max(std::abs(bend), 1e-12 * size);
  };
  if (holds_u) return {0, size > 0 ? single(h.gv, h.hvv) : 0};
  if (holds_v) return {size > 0 ? single(h.gu, h.huu) : 0, 0};
  const Real least = h.least_bend(), raised = least < 1e-10 * size ? 1e-6 * size - least : 0;
  const Real a = h.huu + raised, b = h.huv, c = h.hvv + raised, determinant = a * c - b * b;
  if (!(determinant > 0)) return {0, 0};
  return {(b * h.gv - c * h.gu) / determinant, (b * h.gu - a * h.gv) / determinant};
}

/// Against the gradient, each parameter scaled by its own second derivative; within the box.
std::array<Real, 2> Descent::downhill(const Height& h, std::array<Real, 2> at) const {
  const Real least = 1e-6 * (std::abs(h.huu) + std::abs(h.hvv));
  const auto along = [&](Real g, Real bend, Real t, const Range& r) {
    const bool holds = r.width() == 0 || (t <= r.low && g > 0) || (t >= r.high && g < 0);
    const Real scale = std::max(std::abs(bend), least);
    return holds || !(scale > 0) ? 0 : -g / scale;
  };
  return {along(h.gu, h.huu, at[0], box_.u), along(h.gv, h.hvv, at[1], box_.v)};
}

NearestPoint Descent::from(std::array<Real, 2> start) {
  const std::array<Real, 2> width{box_.u.width(), box_.v.width()};
  NearestPoint best;
  auto at = inside(start[0], start[1]);
  Jet jet = jet_in(face_, box_, at);
  Height h = height_of(jet, p_, width);
  ++best.looks;
  // Moves along a direction, shortened until f falls. The last steps are not tested, since f no
  // longer resolves them.
  enum class Step : std::uint8_t { falls, as_it_is };
  const auto go = [&](std::array<Real, 2> way, Real longest, Step kind) {
    for (Real part = std::min(1.0, 0.5 / longest); part > 1e-9; part /= 4) {
      const auto to = inside(at[0] + part * way[0] * width[0], at[1] + part * way[1] * width[1]);
      if (to == at) break;
      const Jet there = jet_in(face_, box_, to);
      const Height h_there = height_of(there, p_, width);
      ++best.looks;
      if (kind == Step::falls && !(h_there.f < h.f)) continue;
      at = to, jet = there, h = h_there;
      return true;
    }
    return false;
  };
  for (int round = 0; round < kMostSteps; ++round) {
    const auto way = step(h, at);
    const Real longest = std::max(std::abs(way[0]), std::abs(way[1]));
    if (!(longest > 1e-16)) break;
    const bool is_last = longest < 1e-7;
    bool has_moved = go(way, longest, is_last ? Step::as_it_is : Step::falls);
    // A step shortened by a bound may lead uphill; a gradient step never does.
    if (!has_moved && !is_last) {
      const auto down = downhill(h, at);
      const Real most = std::max(std::abs(down[0]), std::abs(down[1]));
      has_moved = most > 1e-13 && go(down, most, Step::falls);
    }
    if (!has_moved || longest < 1e-13) break;
  }
  best.u = at[0], best.v = at[1], best.point = jet.s;
  best.distance = glm::distance(jet.s, p_);
  return best;
}

Box domain_of(const Face& face) { return {face.u().domain(), face.v().domain()}; }

bool is_at_end(const Knots& k, Real t) { return !k.is_periodic && (t <= k.low() || t >= k.high()); }

// ---- Branch and bound --------------------------------------------------------------------------

// Lower bound of the distance, by a disc and by a box about the cell's parallelogram.
Real least_distance(const Leaf& leaf, Vec3 p) {
  const Vec3 d = p - leaf.centre;
  const Real height = glm::dot(d, leaf.normal), square = glm::dot(d, d);
  const Real above = std::max(std::abs(height) - leaf.half_thickness, 0.0);
  Real beside = std::max(std::sqrt(std::max(square - height * height, 0.0)) - leaf.radius, 0.0);
  const bool is_long_u =
      glm::dot(leaf.along_u, leaf.along_u) > glm::dot(leaf.along_v, leaf.along_v);
  const Vec3 side = is_long_u ? leaf.along_u : leaf.along_v;
  const Real length = glm::length(side);
  if (length > 0 && leaf.normal != Vec3(0)) {
    const Vec3 along = side / length;
    const Real x = leaf.outside(d, along), y = leaf.outside(d, glm::cross(leaf.normal, along));
    beside = std::max(beside, std::sqrt(x * x + y * y));
  }
  return std::sqrt(above * above + beside * beside) * (1 - 1e-12);
}

class Search {
 public:
  Search(const Face& face, Vec3 p) : face_(face), p_(p) {}
  NearestPoint run();

 private:
  struct Open {
    Box box;
    Real share_u, share_v;  // of the leaf's widths
  };
  void keep(const NearestPoint& found) {
    best_.looks += found.looks;
    if (!(found.distance < best_.distance) || !face_.holds(found.u, found.v)) return;
    best_.u = found.u, best_.v = found.v, best_.point = found.point;
    best_.distance = found.distance;
  }
  Real twist_of(const Leaf& leaf, const Open& cell, const Jet& jet) const;
  bool narrow(const Leaf& leaf, const Height& h, Real twist, Box& box) const;
  bool is_open(const Leaf& leaf, Open& cell);
  void look_into(const Leaf& leaf);
  Real wanted() const {
    const Real f = best_.distance * best_.distance / 2;
    return f * (1 - kAlike) - kNoDistance * face_.size() * face_.size();
  }

  const Face& face_;
  Vec3 p_;
  NearestPoint best_{.distance = 1e300};
};

// Bound of the third derivative of f along any direction within a cell: three times the product of
// the derivatives of order 1 and 2 (as vectors, since they are perpendicular on straight lines),
// plus the distance times the derivative of order 3. Uses values in the middle and the leaf's
// bounds of the higher orders.
Real Search::twist_of(const Leaf& leaf, const Open& cell, const Jet& jet) const {
  const Real a = cell.share_u, b = cell.share_v;
  const Real u = cell.box.u.width() / 2, v = cell.box.v.width() / 2;
  const auto& of = leaf.third;
  const Real third = ((of[0] * a + 3 * of[1] * b) * a + 3 * of[2] * b * b) * a + of[3] * b * b * b;
  const Real middle =
      glm::length(jet.uu) * u * u + 2 * glm::length(jet.uv) * u * v + glm::length(jet.vv) * v * v;
  const Real second = std::min(
      (leaf.second[0] * a + 2 * leaf.second[1] * b) * a + leaf.second[2] * b * b, middle + third);
  const Real first = std::min(leaf.first[0] * a + leaf.first[1] * b,
                              glm::length(jet.u) * u + glm::length(jet.v) * v + second);
  const auto dot = [](Vec3 x, Vec3 y) { return std::abs(glm::dot(x, y)); };
  const Real dots =
      ((dot(jet.u, jet.uu) * u + (dot(jet.v, jet.uu) + 2 * dot(jet.u, jet.uv)) * v) * u +
       (dot(jet.u, jet.vv) + 2 * dot(jet.v, jet.uv)) * v * v) *
          u +
      dot(jet.v, jet.vv) * v * v * v;
  const Real product = std::min(first * second, dots + second * middle + first * third);
  return 3 * product + (glm::distance(jet.s, p_) + first) * third;
}

// Where f is monotonic in a cell, its minimum is on one side. The cell shrinks to that side if it
// is a side of the leaf; otherwise another cell contains it. False if nothing is left.
bool Search::narrow(const Leaf& leaf, const Height& h, Real twist, Box& box) const {
  const auto shrink = [](Real slope, Real change, const Range& whole, Range& range) {
    if (range.width() == 0 || !(std::abs(slope) > change)) return true;
    const Real side = slope > 0 ? range.low : range.high;
    range = {side, side};
    return side == whole.low || side == whole.high;
  };
  const Real rest = twist / 2 + std::abs(h.huv);
  return shrink(h.gu, std::abs(h.huu) + rest, leaf.u, box.u) &&
         shrink(h.gv, std::abs(h.hvv) + rest, leaf.v, box.v);
}

// Whether a cell has to be cut: not if it is farther than the best, nor if f is convex in it.
bool Search::is_open(const Leaf& leaf, Open& cell) {
  for (;;) {
    const std::array<Real, 2> at{cell.box.u.middle(), cell.box.v.middle()};
    const Jet jet = jet_in(face_, cell.box, at);
    const bool is_flat_u = cell.box.u.width() == 0, is_flat_v = cell.box.v.width() == 0;
    const Height h = height_of(jet, p_, {cell.box.u.width() / 2, cell.box.v.width() / 2});
    ++best_.looks;
    if (h.f < best_.distance * best_.distance / 2)
      keep({.u = at[0], .v = at[1], .point = jet.s, .distance = glm::distance(jet.s, p_)});
    if (is_flat_u && is_flat_v) return false;
    const Real twist = twist_of(leaf, cell, jet), slope = std::abs(h.gu) + std::abs(h.gv);
    const Real bend = is_flat_u ? h.hvv : (is_flat_v ? h.huu : h.least_bend());
    const bool is_convex = bend > twist;
    if (h.f - slope + (is_convex ? 0 : std::min(0.0, bend) - twist / 6) >= wanted()) return false;
    if (is_convex) {
      keep(Descent(face_, p_, cell.box).from(at));
      return false;
    }
    if (!narrow(leaf, h, twist, cell.box)) return false;
    if (cell.box.u.width() == 0) cell.share_u = 0;
    if (cell.box.v.width() == 0) cell.share_v = 0;
    const bool is_narrower =
        is_flat_u != (cell.box.u.width() == 0) || is_flat_v != (cell.box.v.width() == 0);
    if (!is_narrower) return true;
  }
}

void Search::look_into(const Leaf& leaf) {
  constexpr std::size_t kRoom = 128;
  Open stack[kRoom];
  std::size_t depth = 0;
  const Face::Piece piece = face_.piece_at(leaf.u.middle(), leaf.v.middle());
  stack[depth++] = {{leaf.u, leaf.v, piece}, 1, 1};
  while (depth > 0) {
    Open cell = stack[--depth];
    if (!is_open(leaf, cell)) continue;
    const Real long_u = leaf.first[0] * cell.share_u, long_v = leaf.first[1] * cell.share_v;
    const bool is_small = long_u + long_v < 1e-8 * face_.size();
    if (is_small || depth + 4 > kRoom || best_.looks > kMostLooks) {
      // f does not vary noticeably in a small cell. Without room or evaluations left, the result is
      // uncertain.
      if (!is_small) best_.is_certain = false;
      continue;
    }
    // Cut the long side only if it is much longer.
    const Range u = cell.box.u, v = cell.box.v;
    const bool cuts_u = u.width() > 0 && (v.width() == 0 || kLong * long_u > long_v);
    const bool cuts_v = v.width() > 0 && (u.width() == 0 || kLong * long_v > long_u);
    const Real share_u = cell.share_u / (cuts_u ? 2 : 1), share_v = cell.share_v / (cuts_v ? 2 : 1);
    const Range us[2] = {{u.low, cuts_u ? u.middle() : u.high}, {u.middle(), u.high}};
    const Range vs[2] = {{v.low, cuts_v ? v.middle() : v.high}, {v.middle(), v.high}};
    for (std::size_t i = 0; i < (cuts_u ? 2u : 1u); ++i)
      for (std::size_t j = 0; j < (cuts_v ? 2u : 1u); ++j)
        stack[depth++] = {{us[i], vs[j], piece}, share_u, share_v};
  }
}

NearestPoint Search::run() {
  if (face_.trim()) best_ = face_.trim()->closest(face_, p_, 1e300);
  const bool is_on_trim = face_.trim() != nullptr;
  const Real on_trim = best_.distance;
  bool is_first = true;
  const auto limit = [&] { return best_.distance; };
  const auto least_of = [&](std::uint32_t node) { return face_.regions()[node].distance(p_); };
  face_.tree().visit(least_of, limit, [&](std::uint32_t index) {
    const Leaf& leaf = face_.leaves()[index];
    const Real least = least_distance(leaf, p_);
    if (least * least / 2 > wanted() && !is_first) return;
    // A good start tightens all bounds.
    if (is_first)
      keep(Descent(face_, p_, domain_of(face_)).from({leaf.u.middle(), leaf.v.middle()}));
    is_first = false;
    look_into(leaf);
  });
  best_.is_on_edge = is_at_end(face_.u(), best_.u) || is_at_end(face_.v(), best_.v) ||
                     (is_on_trim && best_.distance == on_trim);
  return best_;
}

}  // namespace

NearestPoint closest_point(const Face& face, Vec3 p) { return Search(face, p).run(); }

NearestPoint closest_from(const Face& face, Vec3 p, std::array<Real, 2> start) {
  NearestPoint found = Descent(face, p, domain_of(face)).from(start);
  found.is_on_edge = is_at_end(face.u(), found.u) || is_at_end(face.v(), found.v);
  return found;
}

}  // namespace pantin::detail::nurbs
