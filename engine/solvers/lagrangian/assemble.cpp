// Assembly of the matrix of kkt.cpp: J M^-1 J^T of the blocks at each body.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {
namespace {

Real dot2(const RowVectors& x, const RowVectors& y) {
  return glm::dot(x.v, y.v) + glm::dot(x.w, y.w);
}

/// Two point-constraining blocks that share a body: angular parts of J_p M^-1 without sign, the
/// Jacobian of q with the index of the body in it, 1/kg, and 1 or -1.
struct PointFactors {
  const Vec3* w;
  const Vec3* j;
  std::size_t at_q;
  Real per_mass, sign;
};

/// Destination of the product of blocks p and q: their numbers of rows, and the strides between
/// entries along them.
struct ProductTarget {
  Real* to;
  std::size_t rows_p, rows_q, step_p, step_q;
};

/// S += J_p M^-1 J_q^T at one body, for two blocks that constrain points. R = 0: sizes known at run
/// time only.
template <int R>
void add_point_product(const PointFactors& of, const ProductTarget& target) {
  const std::size_t np = R ? R : target.rows_p, nq = R ? R : target.rows_q;
  const std::size_t step_p = target.step_p, step_q = target.step_q;
  const Real per_mass = of.per_mass, sign = of.sign;
  const Vec3 *w = of.w, *j = of.j;
  const Vec3 arm = j[of.at_q];
  Real* to = target.to;
  for (std::size_t r = 0; r < np; ++r, to += step_p) {
    const Vec3 x = glm::cross(w[r], arm);
    to[0] += sign * x.x, to[step_q] += sign * x.y, to[2 * step_q] += sign * x.z;
    if (r < 3) to[r * step_q] += sign * per_mass;
    for (std::size_t s = 3; s < nq; ++s) to[s * step_q] += sign * glm::dot(w[r], j[s - 1]);
  }
}

/// All block products at one body, with `share` of its inverse mass.
void add_products_at(Island& m, std::size_t body, Real share) {
  const KktPattern& p = m.scratch.pattern;
  const Real per_mass = share / m.mass[body];
  const Mat3 inverse_inertia = share * m.scratch.inverse_inertia[body];
  RowVectors full[6];
  Vec3 w[6];
  std::uint32_t last = UINT32_MAX;
  for (std::uint32_t i = p.first_product[body]; i < p.first_product[body + 1]; ++i) {
    const KktPattern::BlockProduct& k = p.products[i];
    const Block &one = m.blocks[k.p], &two = m.blocks[k.q];
    PANTIN_ASSERT(one.body[k.at_p] == body && two.body[k.at_q] == body);
    const Vec3 *j = jacobian_of(m, one), *to_j = jacobian_of(m, two);
    if (k.p != last) {
      last = k.p;
      if (one.point) {
        const Vec3 r = j[k.at_p];  // of -[r]x, times the inverse inertia
        w[0] = r.z * inverse_inertia[1] - r.y * inverse_inertia[2];
        w[1] = r.x * inverse_inertia[2] - r.z * inverse_inertia[0];
        w[2] = r.y * inverse_inertia[0] - r.x * inverse_inertia[1];
        for (std::size_t s = 3; s < one.rows; ++s) w[s] = inverse_inertia * j[s - 1];
      }
      for (std::size_t r = 0; r < one.rows && (!one.point || !k.all_points); ++r) {
        full[r] = row_of(one, j, r, k.at_p);
        full[r].v *= per_mass, full[r].w = inverse_inertia * full[r].w;
      }
    }
    Real* to = &m.scratch.values[k.target];
    if (k.first_write) std::fill_n(to, one.rows * two.rows, 0.0);
    const std::size_t step_p = k.flipped ? 1 : two.rows, step_q = k.flipped ? one.rows : 1;
    if (!one.point || !two.point) {
      for (std::size_t s = 0; s < two.rows; ++s) {
        const RowVectors row = row_of(two, to_j, s, k.at_q);
        for (std::size_t r = 0; r < one.rows; ++r)
          to[r * step_p + s * step_q] += dot2(full[r], row);
      }
    } else {
      const PointFactors of{w, to_j, k.at_q, per_mass, k.at_p == k.at_q ? 1.0 : -1.0};
      const ProductTarget target{to, one.rows, two.rows, step_p, step_q};
      if (one.rows == 3 && two.rows == 3)
        add_point_product<3>(of, target);
      else if (one.rows == 5 && two.rows == 5)
        add_point_product<5>(of, target);
      else
        add_point_product<0>(of, target);
    }
    if (k.p == k.q)
      for (std::size_t r = 0; r < one.rows; ++r)
        m.scratch.scales[one.first_row + r] = to[r * (one.rows + 1u)];
  }
}

/// Contribution of hubs to the diagonal of J M^-1 J^T.
void add_scales_of_hubs(Island& m) {
  const KktPattern& p = m.scratch.pattern;
  for (const KktPattern::HubProduct& k : p.hub_products) {
    const Block& b = m.blocks[k.block];
    const Real* d = &m.scratch.values[p.diagonal[p.place[k.block]]];
    for (std::size_t r = 0; r < b.rows; ++r) m.scratch.scales[b.first_row + r] = d[r * b.rows + r];
  }
  for (const KktPattern::HubProduct& k : p.hub_products) {
    const Block& b = m.blocks[k.block];
    PANTIN_ASSERT(k.at < b.count && b.body[k.at] < m.count());
    const std::uint32_t body = b.body[k.at];
    for (std::size_t r = 0; r < b.rows; ++r) {
      const RowVectors j = row_of(b, jacobian_of(m, b), r, k.at);
      m.scratch.scales[b.first_row + r] +=
          glm::dot(j.v, j.v) / m.mass[body] + glm::dot(j.w, m.scratch.inverse_inertia[body] * j.w);
    }
  }
}

}  // namespace

void assemble(Island& m, std::span<const Real> share) {
  const KktPattern& p = m.scratch.pattern;
  PANTIN_ASSERT(share.empty() || share.size() == m.count());
  for (const KktPattern::Range& r : p.fill_ranges)
    std::fill_n(m.scratch.values.begin() + r.from, r.count, 0.0);
  for (std::size_t b = 0; b < m.count(); ++b) add_products_at(m, b, share.empty() ? 1 : share[b]);
  add_scales_of_hubs(m);
  for (const KktPattern::HubProduct& k : p.hub_products) {
    const Block& block = m.blocks[k.block];
    Real* to = &m.scratch.values[k.target];
    for (std::size_t r = 0; r < block.rows; ++r) {
      const RowVectors j = row_of(block, jacobian_of(m, block), r, k.at);
      for (int c = 0; c < 6; ++c)
        (k.flipped ? to[c * block.rows + r] : to[r * 6 + c]) = c < 3 ? j.v[c] : j.w[c - 3];
    }
  }
  for (std::size_t h = 0; h < p.hubs.size(); ++h) {
    PANTIN_ASSERT(p.hub_of[p.hubs[h]] == h);
    const std::uint32_t b = p.hubs[h];
    Real* to = &m.scratch.values[p.diagonal[p.place[m.blocks.size() + h]]];
    const Mat3 inertia = world_inertia(m.scratch.body_states[b].rotation, m.inertia[b]);
    for (int r = 0; r < 3; ++r) {
      to[7 * r] = -m.mass[b];
      for (int c = 0; c < 3; ++c) to[(3 + r) * 6 + 3 + c] = -inertia[c][r];
    }
  }
}

}  // namespace pantin::detail::lagrangian
