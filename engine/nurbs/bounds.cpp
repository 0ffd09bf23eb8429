#include "engine/nurbs/bounds.hpp"

#include <algorithm>
#include <cmath>

#include "engine/nurbs/bernstein.hpp"

namespace pantin::detail::nurbs {
namespace {

constexpr std::size_t kMostExact = 36;  // control points of a rational piece that is multiplied out
constexpr std::size_t kMostThird = 12;  // likewise, to order 3
constexpr std::size_t kMostCrosses = 6000;  // of two nets, as many products
constexpr Real kSlack = 1e-13;              // relative: allowance for rounding
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

// Triangle inequality in the quotient rule.
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

// Tightens bounds by the derivative at the middle and those of one order more: the triangle
// inequality counts terms twice that cancel.
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

Real largest(const Bernstein<Vec3>& of) {
  Real most = 0;
  for_each_coefficient(of, [&](Vec3 c) { most = std::max(most, glm::length(c)); });
  return most;
}

/// A piece about a point, weights from 0 to 1.
struct Parts {
  Bernstein<Vec3> product;
  Bernstein<Real> weight;
  Real least = 1e300;  // weight
  bool is_polynomial = true;
};
Parts parts_of(const Surface& piece, Vec3 about) {
  const int p = piece.u.degree, q = piece.v.degree;
  Parts parts{Bernstein<Vec3>(p, q), Bernstein<Real>(p, q)};
  const std::vector<Real> by_u = binomials(p), by_v = binomials(q);
  Real most = 0;
  for (const Weighted& w : piece.points) most = std::max(most, w.w);
  for (int i = 0; i <= p; ++i)
    for (int j = 0; j <= q; ++j) {
      const Weighted w = (1 / most) * piece.at(i, j);
      const Real scale = by_u[static_cast<std::size_t>(i)] * by_v[static_cast<std::size_t>(j)];
      parts.product.at(i, j) = scale * (w.product() - w.w * about);
      parts.weight.at(i, j) = scale * w.w;
      parts.least = std::min(parts.least, w.w);
      parts.is_polynomial = parts.is_polynomial && piece.at(i, j).w == most;
    }
  return parts;
}

// Tightens bounds where weights vary across a long piece, for which the triangle inequality in the
// quotient rule is too loose: by the hulls of the multiplied-out numerators of derivatives.
void sharpen_rational(const Parts& parts, Bounds& b) {
  const auto& w = parts.weight;
  const Real error = 10 * kSlack * b.s[0][0];
  const auto tighten = [&](const Bernstein<Vec3>& top, int power, Real& bound) {
    bound = std::min(bound, (largest(top) + error) / std::pow(parts.least, power) * (1 + kSlack));
  };
  const auto u = differentiated(parts.product, w, 1, Along::u);
  const auto v = differentiated(parts.product, w, 1, Along::v);
  tighten(u, 2, b.s[1][0]), tighten(v, 2, b.s[0][1]);
  const auto uu = differentiated(u, w, 2, Along::u), uv = differentiated(u, w, 2, Along::v);
  const auto vv = differentiated(v, w, 2, Along::v);
  tighten(uu, 3, b.s[2][0]), tighten(uv, 3, b.s[1][1]), tighten(vv, 3, b.s[0][2]);
  if (w.scaled.size() > kMostThird) return;
  tighten(differentiated(uu, w, 3, Along::u), 4, b.s[3][0]);
  tighten(differentiated(uu, w, 3, Along::v), 4, b.s[2][1]);
  tighten(differentiated(vv, w, 3, Along::u), 4, b.s[1][2]);
  tighten(differentiated(vv, w, 3, Along::v), 4, b.s[0][3]);
}

// The largest angle between an axis and the normals; pi if it may exceed a right angle. Normals are
// parallel to a polynomial, w^3 S_u x S_v = w P_u x P_v + w_v P x P_u + w_u P_v x P, bounded by its
// hull.
Real turn_of(const Parts& parts, Vec3 axis) {
  const auto cross = [](Vec3 x, Vec3 y) { return glm::cross(x, y); };
  const auto times = [](Real x, Vec3 y) { return x * y; };
  const auto &whole = parts.product, u = derivative(whole, Along::u),
             v = derivative(whole, Along::v);
  Bernstein<Vec3> normals = product(u, v, cross);
  const Real size = largest(whole), long_u = largest(u), long_v = largest(v);
  Real error = kSlack * (long_u * long_v + size * (long_u + long_v));
  if (!parts.is_polynomial) {
    normals = product(parts.weight, normals, times);
    const auto add = [&](const Bernstein<Vec3>& rest) {
      for (std::size_t i = 0; i < rest.scaled.size(); ++i) normals.scaled[i] += rest.scaled[i];
    };
    add(product(derivative(parts.weight, Along::v), product(whole, u, cross), times));
    add(product(derivative(parts.weight, Along::u), product(v, whole, cross), times));
  }
  Real turn = 0;
  for_each_coefficient(normals, [&](Vec3 n) {
    const Real length = glm::length(n);
    if (!(length > 100 * error)) {
      turn = kPi;
      return;
    }
    const Real along = glm::dot(axis, n), across = glm::length(glm::cross(axis, n));
    turn = std::max(turn, std::atan2(across, along) + 2 * error / length);
  });
  return turn < 0.49 * kPi ? turn : kPi;
}

}  // namespace

Bounded bounded(const Surface& piece) {
  Bounded out;
  Leaf& leaf = out.leaf;
  leaf.u = piece.u.domain(), leaf.v = piece.v.domain();
  const SurfaceDerivatives d = evaluate(piece, leaf.u.middle(), leaf.v.middle(), 1);
  leaf.centre = d[0][0];
  leaf.along_u = d[1][0] * (leaf.u.width() / 2), leaf.along_v = d[0][1] * (leaf.v.width() / 2);
  Bounds b = bounds_of(piece, leaf.centre);
  const Parts parts = parts_of(piece, leaf.centre);
  if (!parts.is_polynomial && piece.points.size() <= kMostExact) sharpen_rational(parts, b);
  sharpen(b, piece, leaf);
  const auto& s = b.s;
  const Vec3 across = glm::cross(leaf.along_u, leaf.along_v);
  const Real area = glm::length(across);
  if (area > 0) leaf.normal = across / area;
  const Real along_u = s[2][0] * s[0][1] + s[1][0] * s[1][1];
  const Real along_v = s[1][1] * s[0][1] + s[1][0] * s[0][2];
  out.turns_along = along_u >= along_v ? Along::u : Along::v;
  const Real change = along_u + along_v;
  leaf.turn = change < area ? std::asin(change / area) : kPi;
  const auto p = static_cast<std::size_t>(piece.u.degree),
             q = static_cast<std::size_t>(piece.v.degree);
  const bool is_small = p * (q + 1) * (p + 1) * q <= kMostCrosses;
  if (area > 0 && is_small) leaf.turn = std::min(leaf.turn, turn_of(parts, leaf.normal));
  leaf.radius = s[0][0] * (1 + kSlack), leaf.half_thickness = kSlack * s[0][0];
  if (area > 0)
    for (const Weighted& w : piece.points)
      leaf.half_thickness =
          std::max(leaf.half_thickness,
                   (1 + kSlack) * std::abs(glm::dot(leaf.normal, w.point() - leaf.centre)));
  else
    leaf.half_thickness = leaf.radius;
  for (std::size_t l = 0; l < kOrders; ++l) {
    if (l <= 1) leaf.first[l] = s[1 - l][l];
    if (l <= 2) leaf.second[l] = s[2 - l][l];
    leaf.third[l] = s[3 - l][l];
  }
  out.region = {Vec3(1e300), Vec3(-1e300), leaf.normal, leaf.turn};
  const Vec3 room(leaf.radius * kSlack);
  for (const Weighted& w : piece.points) {
    out.region.low = glm::min(out.region.low, w.point() - room);
    out.region.high = glm::max(out.region.high, w.point() + room);
  }
  return out;
}

Region joined(const Region& a, const Region& b) {
  Region out{glm::min(a.low, b.low), glm::max(a.high, b.high)};
  const Real apart =
      std::atan2(glm::length(glm::cross(a.normal, b.normal)), glm::dot(a.normal, b.normal));
  const Real turn = (apart + a.turn + b.turn) / 2 + kSlack;
  // One of two cones may contain the other.
  if (apart + b.turn <= a.turn || apart + a.turn <= b.turn) {
    const Region& wide = a.turn >= b.turn ? a : b;
    out.normal = wide.normal, out.turn = wide.turn;
  } else if (turn < kPi && apart < 3) {
    // Rotate from one axis towards the other by as much as the new cone is wider.
    const Real part = turn - a.turn;
    out.normal = (std::sin(apart - part) * a.normal + std::sin(part) * b.normal) / std::sin(apart);
    out.turn = turn + 1e-9;
  }
  return out;
}

}  // namespace pantin::detail::nurbs
