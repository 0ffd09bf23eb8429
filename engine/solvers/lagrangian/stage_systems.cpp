// Linear systems of an implicit method of three stages: M with drag, J of joints, and rows of
// compliant elements and dampers, whose compliances are complex in the complex system.
#include <algorithm>

#include "engine/solvers/lagrangian/kkt_blocks.hpp"
#include "engine/solvers/lagrangian/radau.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// For dependent rows, relative to the diagonal: the systems only speed up convergence.
constexpr Real kRegularisation = 1e-8, kPivotTolerance = 1e-12;
/// Rates times steps below this need no slope: fixed-point iterations converge.
constexpr Real kNotStiff = 0.02;
/// Least effect of a compliant row on its rate, relative: keeps rows without slopes solvable.
constexpr Real kLeastEffect = 1e-12;

/// Parts of a number: real, or real and imaginary.
template <class T>
constexpr std::size_t kParts = sizeof(T) / sizeof(Real);

Real number_of(const Real (&parts)[1]) { return parts[0]; }
Complex number_of(const Real (&parts)[2]) { return {parts[0], parts[1]}; }
Real part_of(Real x, std::size_t) { return x; }
Real part_of(Complex x, std::size_t part) { return part == 0 ? x.re : x.im; }

/// One of the systems, with storage for its right-hand side and solution.
template <class T>
struct StageSystem {
  Island& m;
  T g;
  std::vector<T>&values, &right;
  bool braked = false;

  /// Fraction of a body's speed that drag leaves over the step.
  T share_of(std::size_t body) const { return braked ? T(1) / (T(1) + g * T(m.drag[body])) : T(1); }
};

StageSystem<Real> real_system(Island& m) {
  CollocationScratch& s = m.scratch.collocation;
  return {m, s.h / kRealEigenvalue, s.values, s.right, s.braked};
}
StageSystem<Complex> complex_system(Island& m) {
  CollocationScratch& s = m.scratch.collocation;
  return {m, Complex(s.h) / kComplexEigenvalue, s.complex_values, s.complex_right, s.braked};
}

/// Force of a row per change of its rate: g^2 stiffness + g damping.
template <class T>
T slope_of(const StageSystem<T>& s, std::size_t row) {
  const CollocationScratch& c = s.m.scratch.collocation;
  PANTIN_ASSERT(row < c.mobility.size() && row < c.stiffness.size() && row < c.damping.size());
  const Real least = kLeastEffect / std::max(c.mobility[row], Real(1e-300));
  return s.g * s.g * T(c.stiffness[row]) + s.g * T(c.damping[row]) + T(least);
}

void copy_part(const Island& m, std::size_t, std::vector<Real>& to) {
  std::copy_n(m.scratch.values.begin(), to.size(), to.begin());
}
void copy_part(const Island& m, std::size_t part, std::vector<Complex>& to) {
  for (std::size_t i = 0; i < to.size(); ++i)
    (part == 0 ? to[i].re : to[i].im) = m.scratch.values[i];
}

/// The rows between hubs and blocks hold the Jacobian itself, which is real.
void clear_hub_rows(const Island&, std::vector<Real>&) {}
void clear_hub_rows(const Island& m, std::vector<Complex>& values) {
  for (const KktPattern::HubProduct& k : m.scratch.pattern.hub_products)
    for (std::size_t i = 0; i < 6u * m.blocks[k.block].rows; ++i) values[k.target + i].im = 0;
}

/// J M^-1 J^T with the inverse masses reduced by drag.
template <class T>
void assemble_system(const StageSystem<T>& s) {
  Island& m = s.m;
  std::vector<Real>& share = m.scratch.collocation.share;
  PANTIN_ASSERT(share.size() == m.count());
  if (!s.braked) {
    std::fill(s.values.begin(), s.values.end(), T(0));
    assemble(m);
    return copy_part(m, 0, s.values);
  }
  for (std::size_t part = kParts<T>; part-- > 0;) {  // the real part last: scales are its own
    for (std::size_t b = 0; b < m.count(); ++b) share[b] = part_of(s.share_of(b), part);
    assemble(m, share);
    copy_part(m, part, s.values);
  }
  clear_hub_rows(m, s.values);
  const KktPattern& p = m.scratch.pattern;
  for (std::size_t h = 0; h < p.hubs.size(); ++h) {
    T* d = &s.values[p.diagonal[p.place[m.blocks.size() + h]]];
    const T heavier = T(1) / s.share_of(p.hubs[h]);
    for (std::size_t i = 0; i < 36; ++i) d[i] = T(part_of(d[i], 0)) * heavier;
  }
}

template <class T>
void factor_system(const StageSystem<T>& s) {
  Island& m = s.m;
  const KktPattern& p = m.scratch.pattern;
  const Real regularisation = m.loops ? kRegularisation : 0;
  assemble_system(s);
  for (std::uint32_t at = 0; at < p.order.size(); ++at) {
    const std::uint32_t node = p.order[at];
    const std::size_t n = p.size[at];
    T* d = &s.values[p.diagonal[at]];
    if (node >= m.blocks.size()) {
      eliminate<6>(p, s.values.data(), at, {.sign = -1});
      continue;
    }
    const Block& b = m.blocks[node];
    const Real* scales = &m.scratch.scales[b.first_row];
    for (std::size_t r = 0; r < n; ++r) {
      if (is_compliant(b.kind))
        d[r * n + r] += T(1) / slope_of(s, b.first_row + r);
      else if (is_active(m, node))
        d[r * n + r] += T(regularisation * scales[r]);
      else
        d[r * n + r] = T(1);
    }
    eliminate_rows(p, s.values.data(), at,
                   {.scales = scales, .least = std::max(0.5 * regularisation, kPivotTolerance)});
  }
  ++m.solves;
}

/// Vectors of a stage by part, four a body.
template <class T>
using StageParts = std::vector<Vec3>* const (&)[kParts<T>];

/// Right-hand side of the rows: change of their rates by the residual itself.
template <class T>
void find_right(const StageSystem<T>& s, StageParts<T> d) {
  const Island& m = s.m;
  std::fill(s.right.begin(), s.right.end(), T(0));
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    const bool gives_way = is_compliant(b.kind);
    if ((!gives_way && !s.braked) || !is_active(m, i)) continue;
    const Vec3* jacobian = &m.scratch.jacobian_before[b.first_vector];
    T way[6] = {}, rate[6] = {};
    for (std::size_t k = 0; k < b.count; ++k) {
      const std::size_t body = b.body[k];
      if (body >= m.count()) continue;
      Real ways[6][kParts<T>] = {}, rates[6][kParts<T>] = {};
      for (std::size_t part = 0; part < kParts<T>; ++part) {
        const Vec3* v = &(*d[part])[kStageVectors * body];
        Real by_way[6] = {}, by_rate[6] = {};
        add_rates({b, jacobian, k}, v[0], v[1], by_way);
        add_rates({b, jacobian, k}, v[2], v[3], by_rate);
        for (std::size_t r = 0; r < b.rows; ++r)
          ways[r][part] = by_way[r], rates[r][part] = by_rate[r];
      }
      const T left = s.share_of(body) - T(gives_way ? 0 : 1);
      for (std::size_t r = 0; r < b.rows; ++r)
        way[r] += number_of(ways[r]), rate[r] += left * number_of(rates[r]);
    }
    for (std::size_t r = 0; r < b.rows; ++r) {
      const std::size_t row = b.first_row + r;
      T right = rate[r];
      if (gives_way)
        right += s.g * T(m.scratch.collocation.stiffness[row]) / slope_of(s, row) * way[r];
      s.right[row] = -right;
    }
  }
}

/// The solution from the multipliers of the rows.
template <class T>
void move_bodies(const StageSystem<T>& s, StageParts<T> d) {
  const Island& m = s.m;
  const KktPattern& p = m.scratch.pattern;
  for (std::size_t body = 0; body < m.count(); ++body) {
    Vec3 pull[kParts<T>][2] = {};
    const std::uint32_t to = m.scratch.collocation.stiff ? p.first_incident[body + 1] : 0;
    for (std::uint32_t i = p.first_incident[body]; i < to; ++i) {
      const Block& b = m.blocks[p.incidents[i].block];
      const BodyPart part{b, &m.scratch.jacobian_before[b.first_vector], p.incidents[i].at};
      for (std::size_t n = 0; n < kParts<T>; ++n) {
        Real lambda[6];
        for (std::size_t r = 0; r < b.rows; ++r) lambda[r] = part_of(s.right[b.first_row + r], n);
        add_constraint_force(part, lambda, pull[n]);
      }
    }
    const T left = s.share_of(body);
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 2; ++k) {
        Real ways[kParts<T>], rates[kParts<T>];
        for (std::size_t n = 0; n < kParts<T>; ++n) {
          const Vec3* v = &(*d[n])[kStageVectors * body];
          const Vec3 change = k == 0 ? pull[n][0] / m.mass[body]
                                     : m.scratch.collocation.inverse_inertia[body] * pull[n][1];
          ways[n] = v[k][i], rates[n] = v[2 + k][i] + change[i];
        }
        const T rate = left * number_of(rates), way = number_of(ways) + s.g * rate;
        for (std::size_t n = 0; n < kParts<T>; ++n) {
          Vec3* v = &(*d[n])[kStageVectors * body];
          v[k][i] = part_of(way, n), v[2 + k][i] = part_of(rate, n);
        }
      }
  }
}

template <class T>
void solve_system(const StageSystem<T>& s, StageParts<T> d) {
  if (s.m.scratch.collocation.stiff) {
    s.m.scratch.springs_active = true;
    find_right(s, d);
    s.m.scratch.springs_active = false;
    back_solve(s.m.scratch.pattern, s.values.data(), s.right.data());
  }
  move_bodies(s, d);
}

/// Whether any slope is significant for a step of `h`.
bool is_stiff(const Island& m, Real h) {
  const CollocationScratch& s = m.scratch.collocation;
  for (const Block& b : m.blocks)
    for (std::size_t r = b.first_row; r < b.first_row + b.rows && is_compliant(b.kind); ++r)
      if (h * s.mobility[r] * (h * s.stiffness[r] + s.damping[r]) > kNotStiff) return true;
  return s.braked;
}

}  // namespace

void allocate_collocation(Island& m) {
  CollocationScratch& s = m.scratch.collocation;
  const std::size_t bodies = m.count();
  for (auto* three : {&s.stage, &s.rate, &s.part})
    for (std::vector<Vec3>& each : *three) each.assign(kStageVectors * bodies, Vec3(0));
  s.rate_at_start.assign(kStageVectors * bodies, Vec3(0)), s.error = s.rate_at_start;
  s.inverse_inertia.assign(bodies, Mat3(1)), s.share.assign(bodies, 1);
  for (auto* by_row : {&s.stiffness, &s.damping, &s.mobility}) by_row->assign(m.rows, 0);
  const KktPattern& p = m.scratch.pattern;
  s.values.assign(p.numbers, 0), s.complex_values.assign(p.numbers, {});
  s.right.assign(p.unknowns, 0), s.complex_right.assign(p.unknowns, {});
}

void prepare_stage_systems(const World& world, Island& m, Real h) {
  StepScratch& scratch = m.scratch;
  CollocationScratch& s = scratch.collocation;
  s.h = h;
  s.braked = std::any_of(m.drag.begin(), m.drag.end(), [&](Real d) { return h * d > kNotStiff; });
  s.stiff = s.braked;
  if (m.joint_force_rows == 0 && !s.braked) return;
  scratch.springs_active = true;
  write_all_rows(world, m, {true, false});
  find_force_slopes(world, m, {s.stiffness, s.damping, s.mobility});
  s.stiff = is_stiff(m, h);
  if (s.stiff) {
    scratch.jacobian_before = scratch.jacobian;
    s.inverse_inertia = scratch.inverse_inertia;
    factor_system(real_system(m)), factor_system(complex_system(m));
  }
  scratch.springs_active = false;
}

void solve_real_system(Island& m, std::vector<Vec3>& residual) {
  std::vector<Vec3>* const d[] = {&residual};
  solve_system(real_system(m), d);
}
void solve_complex_system(Island& m, std::vector<Vec3>& real, std::vector<Vec3>& imaginary) {
  std::vector<Vec3>* const d[] = {&real, &imaginary};
  solve_system(complex_system(m), d);
}

}  // namespace pantin::detail::lagrangian
