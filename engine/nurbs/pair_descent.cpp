#include "engine/nurbs/pair_descent.hpp"

#include <algorithm>
#include <cmath>

namespace pantin::detail::nurbs {
namespace {

constexpr int kMostRounds = 80;

using Four4 = std::array<Real, 4>;

/// |d|^2 / 2 with gradient and second derivatives, by parameters in units of their domains.
struct Slope {
  Real f = 0;
  Four4 g{};
  Real h[4][4] = {};
  Vec3 on_a{0}, on_b{0};
};

// Solves the free rows of a symmetric system by root-free Cholesky; false if it is not positive
// definite.
bool solve_free(Real (&h)[4][4], const std::array<bool, 4>& is_free, const Four4& right, Four4& x) {
  Real l[4][4] = {}, d[4] = {};
  for (int i = 0; i < 4; ++i) {
    x[static_cast<std::size_t>(i)] = 0;
    if (!is_free[static_cast<std::size_t>(i)]) continue;
    for (int j = 0; j <= i; ++j) {
      if (!is_free[static_cast<std::size_t>(j)]) continue;
      Real sum = h[i][j];
      for (int k = 0; k < j; ++k) sum -= l[i][k] * d[k] * l[j][k];
      if (j < i)
        l[i][j] = sum / d[j];
      else if (sum > 1e-14 * std::abs(h[i][i]))
        d[i] = sum, l[i][i] = 1;
      else
        return false;
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    if (!is_free[i]) continue;
    x[i] = right[i];
    for (std::size_t k = 0; k < i; ++k) x[i] -= l[i][k] * x[k];
  }
  for (std::size_t i = 4; i-- > 0;) {
    if (!is_free[i]) continue;
    x[i] /= d[i];
    for (std::size_t k = i + 1; k < 4; ++k) x[i] -= l[k][i] * x[k];
  }
  return true;
}

class Descent {
 public:
  Descent(const Meeting& of, const PlacePair& at)
      : fa_(of.a.face(at.a.face)),
        fb_(of.b.face(at.b.face)),
        turn_(glm::mat3_cast(of.a_in_b.rotation)),
        origin_(of.a_in_b.position),
        knots_{&fa_.u(), &fa_.v(), &fb_.u(), &fb_.v()} {
    for (std::size_t i = 0; i < 4; ++i) width_[i] = knots_[i]->domain().width();
  }

  PairDescent run(const PlacePair& from);

 private:
  Slope slope_at(const Four4& s) const;
  std::array<bool, 4> free_at(const Four4& s, const Four4& g) const;
  bool step(const Slope& here, const std::array<bool, 4>& is_free, Real damping, Four4& out) const;

  const Face &fa_, &fb_;
  Mat3 turn_;
  Vec3 origin_;
  std::array<const Knots*, 4> knots_;
  Four4 width_{};
};

Slope Descent::slope_at(const Four4& s) const {
  const Jet p = in_frame(fa_.at(s[0], s[1]), turn_, origin_), q = fb_.at(s[2], s[3]);
  const Vec3 d = p.s - q.s;
  const Vec3 by[4] = {width_[0] * p.u, width_[1] * p.v, -width_[2] * q.u, -width_[3] * q.v};
  Slope out;
  out.f = glm::dot(d, d) / 2, out.on_a = p.s, out.on_b = q.s;
  for (std::size_t i = 0; i < 4; ++i) {
    out.g[i] = glm::dot(d, by[i]);
    for (std::size_t j = 0; j < 4; ++j) out.h[i][j] = glm::dot(by[i], by[j]);
  }
  const auto bend = [&](std::size_t i, std::size_t j, Vec3 second) {
    const Real x = glm::dot(d, second) * width_[i] * width_[j];
    out.h[i][j] += x;
    if (i != j) out.h[j][i] += x;
  };
  bend(0, 0, p.uu), bend(0, 1, p.uv), bend(1, 1, p.vv);
  bend(2, 2, -q.uu), bend(2, 3, -q.uv), bend(3, 3, -q.vv);
  return out;
}

std::array<bool, 4> Descent::free_at(const Four4& s, const Four4& g) const {
  std::array<bool, 4> is_free;
  for (std::size_t i = 0; i < 4; ++i) {
    const Range domain = knots_[i]->domain();
    is_free[i] = knots_[i]->is_periodic ||
                 !((s[i] <= domain.low && g[i] > 0) || (s[i] >= domain.high && g[i] < 0));
  }
  return is_free;
}

bool Descent::step(const Slope& here, const std::array<bool, 4>& is_free, Real damping,
                   Four4& out) const {
  Real h[4][4];
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) h[i][j] = here.h[i][j];
  const Real largest = std::max({h[0][0], h[1][1], h[2][2], h[3][3], 1e-300});
  for (int i = 0; i < 4; ++i) h[i][i] += damping * largest;
  Four4 right;
  for (std::size_t i = 0; i < 4; ++i) right[i] = -here.g[i];
  return solve_free(h, is_free, right, out);
}

PairDescent Descent::run(const PlacePair& from) {
  Four4 s{from.a.u, from.a.v, from.b.u, from.b.v};
  for (std::size_t i = 0; i < 4; ++i) s[i] = knots_[i]->inside(s[i]);
  Slope here = slope_at(s);
  Real damping = 1e-3;
  for (int round = 0; round < kMostRounds; ++round) {
    Four4 way;
    if (!step(here, free_at(s, here.g), damping, way)) {
      damping = std::max(4 * damping, 1e-6);
      continue;
    }
    Real longest = 0;
    for (Real x : way) longest = std::max(longest, std::abs(x));
    if (!(longest > 1e-13)) break;
    const Real part = std::min(1.0, 0.25 / longest);
    Four4 to;
    for (std::size_t i = 0; i < 4; ++i) to[i] = knots_[i]->inside(s[i] + part * way[i] * width_[i]);
    const Slope there = slope_at(to);
    if (there.f < here.f) {
      const bool is_done = longest < 1e-10;
      s = to, here = there, damping /= 8;
      if (damping < 1e-9) damping = 0;
      if (is_done) break;
    } else {
      if (longest < 1e-8) break;
      damping = std::max(4 * damping, 1e-6);
    }
  }
  PairDescent out;
  out.at = {{from.a.face, s[0], s[1]}, {from.b.face, s[2], s[3]}};
  out.on_a = here.on_a, out.on_b = here.on_b, out.distance = std::sqrt(2 * here.f);
  for (std::size_t i = 0; i < 4; ++i)
    out.is_on_edge |=
        !knots_[i]->is_periodic && (s[i] <= knots_[i]->low() || s[i] >= knots_[i]->high());
  return out;
}

}  // namespace

PairDescent descend(const Meeting& of, const PlacePair& from) {
  return Descent(of, from).run(from);
}

}  // namespace pantin::detail::nurbs
