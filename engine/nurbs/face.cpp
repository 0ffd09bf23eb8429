#include "engine/nurbs/face.hpp"

#include <algorithm>

#include "engine/base/lanes.hpp"

namespace pantin::detail::nurbs {
namespace {

constexpr int kFastDegree = 3;

// Powers about the middle of a Bezier line, in place: coefficient k is derivative k by k!, with the
// parameter from -1/2 to 1/2.
void to_powers(std::span<Weighted> line) {
  const int p = static_cast<int>(line.size()) - 1;
  std::vector<Weighted> work;
  Real factor = 1;
  std::vector<Weighted> differences(line.begin(), line.end());
  for (int k = 0; k <= p; ++k) {
    work = differences;
    for (int r = p - k; r > 0; --r)
      for (int i = 0; i < r; ++i)
        work[static_cast<std::size_t>(i)] =
            0.5 * (work[static_cast<std::size_t>(i)] + work[static_cast<std::size_t>(i + 1)]);
    line[static_cast<std::size_t>(k)] = factor * work[0];
    factor = factor * (p - k) / (k + 1);
    for (std::size_t i = 0; i + 1 < differences.size(); ++i)
      differences[i] = differences[i + 1] - differences[i];
    differences.pop_back();
  }
}

}  // namespace

std::size_t Face::Pieces::find(Real t) const {
  // Without branches, which would be guessed wrong half of the time.
  std::size_t first = 0, count = starts.size();
  while (count > 1) {
    const std::size_t half = count / 2;
    first += starts[first + half] <= t ? half : 0;
    count -= half;
  }
  return first;
}

Face::Face(Surface surface) : surface_(std::move(surface)) {
  const auto prepare = [](const Knots& k, Pieces& to) {
    for (int i : k.spans()) {
      to.starts.push_back(k[i]), to.spans.push_back(i);
      to.middles.push_back((k[i] + k[i + 1]) / 2);
      to.inverse.push_back(1 / (k[i + 1] - k[i]));
    }
  };
  prepare(surface_.u, by_u_), prepare(surface_.v, by_v_);
  size_ = bounding_ball(surface_.points).radius;
  const std::vector<Surface> pieces = bezier_pieces(surface_);
  if (std::max(surface_.u.degree, surface_.v.degree) <= kFastDegree) make_pieces(pieces);
  make_leaves(pieces);
}

void Face::make_pieces(const std::vector<Surface>& pieces) {
  const auto rows = static_cast<std::size_t>(surface_.u.degree + 1);
  const auto columns = static_cast<std::size_t>(surface_.v.degree + 1);
  std::vector<Weighted> line(rows);
  for (const Surface& piece : pieces) {
    std::vector<Weighted> net = piece.points;
    for (std::size_t i = 0; i < rows; ++i) to_powers(std::span(net).subspan(i * columns, columns));
    for (std::size_t j = 0; j < columns; ++j) {
      for (std::size_t i = 0; i < rows; ++i) line[i] = net[i * columns + j];
      to_powers(line);
      for (std::size_t i = 0; i < rows; ++i) net[i * columns + j] = line[i];
    }
    for (const Weighted& w : net) coefficients_.insert(coefficients_.end(), {w.x, w.y, w.z, w.w});
  }
}

// ---- Evaluation --------------------------------------------------------------------------------

namespace {

/// Sums over the powers of a parameter: value, derivative, half the second derivative.
template <int P>
struct Powers {
  Real t, square, cube, twice, thrice, triple_square;
  explicit Powers(Real at)
      : t(at),
        square(at * at),
        cube(square * at),
        twice(2 * at),
        thrice(3 * at),
        triple_square(3 * square) {}

  template <class Get>
  PANTIN_INLINE Four value(Get&& c) const {
    Four sum = c(0) + t * c(1);
    if constexpr (P >= 2) sum += square * c(2);
    if constexpr (P >= 3) sum += cube * c(3);
    return sum;
  }
  template <class Get>
  PANTIN_INLINE Four slope(Get&& c) const {
    Four sum = c(1);
    if constexpr (P >= 2) sum += twice * c(2);
    if constexpr (P >= 3) sum += triple_square * c(3);
    return sum;
  }
  template <class Get>
  PANTIN_INLINE Four half_bend(Get&& c) const {
    if constexpr (P >= 3)
      return c(2) + thrice * c(3);
    else if constexpr (P == 2)
      return c(2);
    else
      return 0.0 * c(0);
  }
};

/// A homogeneous point and its derivatives by the parameters of its piece.
struct Lifted {
  Four s, u, v, half_uu, uv, half_vv;
};

template <int P, int Q>
PANTIN_INLINE Lifted lifted(const Real* c, Real u, Real v) {
  const Powers<P> by_u(u);
  const Powers<Q> by_v(v);
  Four value[P + 1], slope[P + 1], half_bend[P + 1];
  for (int i = 0; i <= P; ++i) {
    const auto get = [&](int j) { return load_four(c + 4 * (i * (Q + 1) + j)); };
    value[i] = by_v.value(get), slope[i] = by_v.slope(get), half_bend[i] = by_v.half_bend(get);
  }
  const auto values = [&](int i) { return value[i]; };
  const auto slopes = [&](int i) { return slope[i]; };
  const auto bends = [&](int i) { return half_bend[i]; };
  return {by_u.value(values),     by_u.slope(values), by_u.value(slopes),
          by_u.half_bend(values), by_u.slope(slopes), by_u.value(bends)};
}

PANTIN_INLINE Vec3 xyz(Four a) { return {a[0], a[1], a[2]}; }

// The quotient rule; a and b are the inverse widths of the piece.
PANTIN_INLINE Jet projected(const Lifted& h, Real a, Real b) {
  const Real inverse = 1 / h.s[3];
  const Four s = inverse * h.s;
  const Real wu = h.u[3], wv = h.v[3];
  const Four u = inverse * (h.u - wu * s), v = inverse * (h.v - wv * s);
  const Four uu = (2 * inverse) * (h.half_uu - wu * u - h.half_uu[3] * s);
  const Four vv = (2 * inverse) * (h.half_vv - wv * v - h.half_vv[3] * s);
  const Four uv = inverse * (h.uv - wu * v - wv * u - h.uv[3] * s);
  return {xyz(s), xyz(a * u), xyz(b * v), xyz((a * a) * uu), xyz((a * b) * uv), xyz((b * b) * vv)};
}

}  // namespace

Jet Face::at(Piece piece, Real u, Real v) const {
  const auto [i, j] = piece;
  if (coefficients_.empty()) {
    const SurfaceDerivatives d = evaluate_on(surface_, {by_u_.spans[i], by_v_.spans[j]}, {u, v}, 2);
    return {d[0][0], d[1][0], d[0][1], d[2][0], d[1][1], d[0][2]};
  }
  const Real a = by_u_.inverse[i], b = by_v_.inverse[j];
  const Real s = (u - by_u_.middles[i]) * a, t = (v - by_v_.middles[j]) * b;
  const int p = surface_.u.degree, q = surface_.v.degree;
  const std::size_t stride = 4 * static_cast<std::size_t>((p + 1) * (q + 1));
  const Real* c = &coefficients_[(i * by_v_.starts.size() + j) * stride];
  switch (4 * p + q) {
    case 4 * 1 + 1:
      return projected(lifted<1, 1>(c, s, t), a, b);
    case 4 * 1 + 2:
      return projected(lifted<1, 2>(c, s, t), a, b);
    case 4 * 1 + 3:
      return projected(lifted<1, 3>(c, s, t), a, b);
    case 4 * 2 + 1:
      return projected(lifted<2, 1>(c, s, t), a, b);
    case 4 * 2 + 2:
      return projected(lifted<2, 2>(c, s, t), a, b);
    case 4 * 2 + 3:
      return projected(lifted<2, 3>(c, s, t), a, b);
    case 4 * 3 + 1:
      return projected(lifted<3, 1>(c, s, t), a, b);
    case 4 * 3 + 2:
      return projected(lifted<3, 2>(c, s, t), a, b);
    default:
      return projected(lifted<3, 3>(c, s, t), a, b);
  }
}

}  // namespace pantin::detail::nurbs
