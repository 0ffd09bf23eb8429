#include "engine/nurbs/face.hpp"

#include <algorithm>
#include <cstring>

#include "engine/base/lanes.hpp"
#include "engine/nurbs/pieces.hpp"
#include "engine/nurbs/trim.hpp"

namespace pantin::detail::nurbs {
namespace {

constexpr int kFastDegree = 3;

}  // namespace

std::size_t Face::Pieces::find(Real t) const { return nurbs::piece_at(starts, t); }

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
  // Control points of small weight may be far off.
  if (!tree_.nodes().empty()) size_ = std::min(size_, tree_.nodes().front().ball.radius);
  if (!surface_.trims.empty()) trim_ = std::make_shared<const Trim>(*this);
}

bool Face::is_within_trim(Real u, Real v) const { return trim_->holds(u, v); }

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

/// Two of the four numbers of a homogeneous point: as many as keep all sums in registers.
PANTIN_INLINE Two load_two(const Real* p) {
  Two pair;
  std::memcpy(&pair, p, sizeof pair);
  return pair;
}

/// Two numbers of a homogeneous point and of its derivatives by the parameters of its piece.
struct Lifted {
  Two s, u, v, half_uu, uv, half_vv;
};

/// Powers of a parameter up to P, and of their derivatives.
struct Powers {
  Real value[4], slope[4], half_bend[4];
  explicit Powers(Real t)
      : value{1, t, t * t, t * t * t}, slope{0, 1, 2 * t, 3 * t * t}, half_bend{0, 0, 1, 3 * t} {}
};

template <int P, int Q>
PANTIN_INLINE Lifted lifted(const Real* c, const Powers& by_u, const Powers& by_v) {
  Lifted sum{};
  for (int i = 0; i <= P; ++i) {
    const Real* row = c + 4 * (Q + 1) * i;
    Two value = load_two(row) + by_v.value[1] * load_two(row + 4), slope = load_two(row + 4),
        bend{};
    if constexpr (Q >= 2) {
      const Two third = load_two(row + 8);
      value += by_v.value[2] * third, slope += by_v.slope[2] * third, bend = third;
    }
    if constexpr (Q >= 3) {
      const Two fourth = load_two(row + 12);
      value += by_v.value[3] * fourth, slope += by_v.slope[3] * fourth;
      bend += by_v.half_bend[3] * fourth;
    }
    sum.s += by_u.value[i] * value, sum.v += by_u.value[i] * slope;
    sum.half_vv += by_u.value[i] * bend;
    if (i >= 1) sum.u += by_u.slope[i] * value, sum.uv += by_u.slope[i] * slope;
    if (i >= 2) sum.half_uu += by_u.half_bend[i] * value;
  }
  return sum;
}

/// The quotient rule for two numbers; `w` holds the weight and its derivatives.
struct Weights {
  Real inverse, u, v, half_uu, uv, half_vv;
};
PANTIN_INLINE Lifted divided(const Lifted& h, const Weights& w) {
  Lifted d;
  d.s = w.inverse * h.s;
  d.u = w.inverse * (h.u - w.u * d.s), d.v = w.inverse * (h.v - w.v * d.s);
  d.half_uu = w.inverse * (h.half_uu - w.u * d.u - w.half_uu * d.s);
  d.half_vv = w.inverse * (h.half_vv - w.v * d.v - w.half_vv * d.s);
  d.uv = w.inverse * (h.uv - w.u * d.v - w.v * d.u - w.uv * d.s);
  return d;
}

/// The local parameters of a point in its piece, and the inverse widths of that.
struct InPiece {
  const Real* coefficients;
  Real u, v, per_u, per_v;
};

template <int P, int Q>
Jet jet_of(const InPiece& at) {
  const Powers by_u(at.u), by_v(at.v);
  const Lifted zw = lifted<P, Q>(at.coefficients + 2, by_u, by_v);
  const Weights w{1 / zw.s[1], zw.u[1], zw.v[1], zw.half_uu[1], zw.uv[1], zw.half_vv[1]};
  const Lifted xy = divided(lifted<P, Q>(at.coefficients, by_u, by_v), w), z = divided(zw, w);
  const Real a = at.per_u, b = at.per_v;
  const auto joined = [](Real scale, Two x, Two y) {
    return Vec3(scale * x[0], scale * x[1], scale * y[0]);
  };
  return {joined(1, xy.s, z.s),       joined(a, xy.u, z.u),
          joined(b, xy.v, z.v),       joined(2 * a * a, xy.half_uu, z.half_uu),
          joined(a * b, xy.uv, z.uv), joined(2 * b * b, xy.half_vv, z.half_vv)};
}

}  // namespace

Jet Face::at(Piece piece, Real u, Real v) const {
  const auto [i, j] = piece;
  if (coefficients_.empty()) {
    const SurfaceDerivatives d = evaluate_on(surface_, {by_u_.spans[i], by_v_.spans[j]}, {u, v}, 2);
    return {d[0][0], d[1][0], d[0][1], d[2][0], d[1][1], d[0][2]};
  }
  const int p = surface_.u.degree, q = surface_.v.degree;
  const std::size_t stride = 4 * static_cast<std::size_t>((p + 1) * (q + 1));
  const Real a = by_u_.inverse[i], b = by_v_.inverse[j];
  const InPiece at{&coefficients_[(i * by_v_.starts.size() + j) * stride],
                   (u - by_u_.middles[i]) * a, (v - by_v_.middles[j]) * b, a, b};
  switch (4 * p + q) {
    case 4 * 1 + 1:
      return jet_of<1, 1>(at);
    case 4 * 1 + 2:
      return jet_of<1, 2>(at);
    case 4 * 1 + 3:
      return jet_of<1, 3>(at);
    case 4 * 2 + 1:
      return jet_of<2, 1>(at);
    case 4 * 2 + 2:
      return jet_of<2, 2>(at);
    case 4 * 2 + 3:
      return jet_of<2, 3>(at);
    case 4 * 3 + 1:
      return jet_of<3, 1>(at);
    case 4 * 3 + 2:
      return jet_of<3, 2>(at);
    default:  // both are 3
      return jet_of<3, 3>(at);
  }
}

}  // namespace pantin::detail::nurbs
