// Integrals over skins, by quadrature over their polynomial pieces.
#include <algorithm>
#include <cmath>

#include "engine/nurbs/makers.hpp"
#include "engine/nurbs/tessellate.hpp"
#include "engine/nurbs/trim.hpp"

namespace pantin::detail::nurbs {
namespace {

constexpr int kDeepest = 5;
/// For all patches of a skin: rounding or folds may keep the parts from adding up.
constexpr int kMostCuts = 300;
constexpr Real kAgree = 1e-13;

/// Gauss-Legendre points and weights on [-1, 1].
template <int Points>
struct Rule {
  std::array<Real, Points> at, weight;
  Rule() {
    for (int i = 0; i < Points; ++i) {
      Real x = std::cos(kPi * (i + 0.75) / (Points + 0.5)), slope = 1;
      for (int round = 0; round < 20; ++round) {
        Real before = 1, value = x;
        for (int n = 2; n <= Points; ++n) {
          const Real next = ((2 * n - 1) * x * value - (n - 1) * before) / n;
          before = value, value = next;
        }
        slope = Points * (x * value - before) / (x * x - 1);
        x -= value / slope;
      }
      at[static_cast<std::size_t>(i)] = x;
      weight[static_cast<std::size_t>(i)] = 2 / ((1 - x * x) * slope * slope);
    }
  }
};

/// Volume, 3 first and 6 second moments.
using Sums = std::array<Real, 10>;

/// The integrand at a point: by Gauss's theorem, with the outward vector n = S_u x S_v, the
/// integrals of x_k n_k and x_k x_l n_k without summation, as thirds of x.n, x x.n / 4 and x x^T
/// x.n / 5.
Sums sums_at(const Jet& j, Vec3 origin) {
  const Vec3 x = j.s - origin;
  const Real out = glm::dot(x, glm::cross(j.u, j.v));
  return {out / 3,
          x.x * out / 4,
          x.y * out / 4,
          x.z * out / 4,
          x.x * x.x * out / 5,
          x.y * x.y * out / 5,
          x.z * x.z * out / 5,
          x.x * x.y * out / 5,
          x.x * x.z * out / 5,
          x.y * x.z * out / 5};
}

struct Patch {
  Range u, v;
};

/// State of a quadrature over all patches of a skin: the cuts left, and its result's cost and
/// uncertainty.
struct Work {
  Quadrature by;
  int cuts_left = kMostCuts;
};

template <int Points, class Sum, class At>
Sum over(const Patch& patch, const At& at, Work& work) {
  work.by.looks += Points * Points;
  static const Rule<Points> rule;
  Sum sum{};
  for (std::size_t i = 0; i < Points; ++i)
    for (std::size_t j = 0; j < Points; ++j) {
      const Real u = patch.u.middle() + patch.u.width() / 2 * rule.at[i];
      const Real v = patch.v.middle() + patch.v.width() / 2 * rule.at[j];
      const Real w = rule.weight[i] * rule.weight[j] * patch.u.width() * patch.v.width() / 4;
      const Sum one = at(u, v);
      for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += w * one[k];
    }
  return sum;
}

template <class Sum>
bool agree(const Sum& a, const Sum& b, const Sum& scale) {
  for (std::size_t k = 0; k < a.size(); ++k)
    if (!(std::abs(a[k] - b[k]) <= kAgree * scale[k])) return false;
  return true;
}

/// Adaptive quadrature: cuts in four until the parts add up to the whole, or no cuts are left.
template <class Sum, class At>
struct Integral {
  const At& at;
  const Sum& scale;
  Work& work;

  // Rules of more and more points, which suffice for small pieces; then subdivision.
  Sum of_piece(const Patch& patch) {
    const Sum few = over<4, Sum>(patch, at, work), more = over<8, Sum>(patch, at, work);
    if (agree(few, more, scale)) return more;
    const Sum most = over<12, Sum>(patch, at, work);
    if (agree(more, most, scale)) return most;
    if (work.cuts_left > 0) return in_parts(patch, most, 0);
    work.by.doubt += std::abs(most[0] - more[0]);
    return most;
  }

  Sum in_parts(const Patch& patch, const Sum& whole, int depth) {
    const Range us[2] = {{patch.u.low, patch.u.middle()}, {patch.u.middle(), patch.u.high}};
    const Range vs[2] = {{patch.v.low, patch.v.middle()}, {patch.v.middle(), patch.v.high}};
    Patch quarters[4];
    Sum parts[4], sum{};
    for (std::size_t i = 0; i < 4; ++i) {
      quarters[i] = {us[i / 2], vs[i % 2]};
      parts[i] = over<16, Sum>(quarters[i], at, work);
      add(parts[i], sum);
    }
    if (agree(sum, whole, scale)) return sum;
    if (depth == kDeepest || work.cuts_left == 0) {
      work.by.doubt += std::abs(sum[0] - whole[0]);
      return sum;
    }
    --work.cuts_left;
    sum = {};
    for (std::size_t i = 0; i < 4; ++i) add(in_parts(quarters[i], parts[i], depth + 1), sum);
    return sum;
  }

  static void add(const Sum& one, Sum& to) {
    for (std::size_t k = 0; k < to.size(); ++k) to[k] += one[k];
  }
};

template <class Sum, class At>
Sum over_pieces(const Skin& skin, const At& at, const Sum& scale, Quadrature& by) {
  Sum sum{};
  Work work;
  for (const Face& face : skin.faces()) {
    if (face.trim()) continue;  // is open, and measured along its loops
    Face::Piece piece;
    const auto at_place = [&](Real u, Real v) { return at(face.at(piece, u, v)); };
    Integral<Sum, decltype(at_place)> integral{at_place, scale, work};
    const std::vector<Real> us = face.u().breaks(), vs = face.v().breaks();
    for (std::size_t i = 0; i + 1 < us.size(); ++i)
      for (std::size_t j = 0; j + 1 < vs.size(); ++j) {
        piece = {i, j};
        integral.add(integral.of_piece({{us[i], us[i + 1]}, {vs[j], vs[j + 1]}}), sum);
      }
  }
  by = work.by;
  return sum;
}

Enclosed of_ellipsoid(Vec3 half) {
  Enclosed in;
  in.volume = 4 * kPi / 3 * half.x * half.y * half.z;
  for (int k = 0; k < 3; ++k) in.second[k][k] = in.volume / 5 * half[k] * half[k];
  return in;
}

}  // namespace

Enclosed enclosed_by(const Skin& skin) {
  if (skin.half_axes()) {
    Enclosed in = of_ellipsoid(*skin.half_axes());
    if (skin.is_ellipsoid_cavity()) in.volume = -in.volume, in.second = -in.second;
    return in;
  }
  // About a centre of its own, so that a skin far from the origin loses no digits.
  Vec3 origin(0);
  for (const Face& face : skin.faces())
    origin += bounding_ball(face.surface().points).centre / Real(skin.faces().size());
  Sums scale;
  const Real size = skin.size();
  for (std::size_t k = 0; k < scale.size(); ++k)
    scale[k] = size * size * size * (k == 0 ? 1 : k < 4 ? size : size * size);
  Enclosed in;
  const auto at = [&](const Jet& j) { return sums_at(j, origin); };
  const Sums s = over_pieces<Sums>(skin, at, scale, in.by);
  const Vec3 about(s[1], s[2], s[3]);
  in.volume = s[0], in.first = about + s[0] * origin;
  in.second = Mat3(s[4], s[7], s[8], s[7], s[5], s[9], s[8], s[9], s[6]);
  in.second += glm::outerProduct(about, origin) + glm::outerProduct(origin, about) +
               s[0] * glm::outerProduct(origin, origin);
  return in;
}

Real area_of(const Skin& skin, Quadrature* by) {
  using One = std::array<Real, 1>;
  if (skin.half_axes()) {
    const Skin whole({ellipsoid({}, *skin.half_axes())}, 0);
    return area_of(whole, by);
  }
  const auto at = [](const Jet& j) { return One{glm::length(glm::cross(j.u, j.v))}; };
  Quadrature own;
  const One area = over_pieces<One>(skin, at, One{skin.size() * skin.size()}, own);
  if (by != nullptr) *by = own;
  Real sum = area[0];
  for (const Face& face : skin.faces())
    if (face.trim()) sum += face.trim()->area(face);
  return sum;
}

bool is_closed(const Skin& skin) {
  if (skin.half_axes()) return true;
  for (int f = 0; f < static_cast<int>(skin.faces().size()); ++f) {
    const Face& face = skin.face(f);
    if (face.trim()) return false;
    for (int k = 0; k < kEdges; ++k) {
      const auto edge = static_cast<Edge>(k);
      const bool is_u = edge == Edge::u_low || edge == Edge::u_high;
      const Knots& own = is_u ? face.u() : face.v();
      if (own.is_periodic || skin.neighbour(f, edge)) continue;
      const bool is_low = edge == Edge::u_low || edge == Edge::v_low;
      const Curve line =
          isoline(face.surface(), is_u ? Along::u : Along::v, is_low ? own.low() : own.high());
      if (bounding_ball(line.points).radius > 1e-9 * skin.size() + skin.tolerance()) return false;
    }
  }
  return true;
}

}  // namespace pantin::detail::nurbs
