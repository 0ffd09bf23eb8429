#include "engine/assembly/design.hpp"

#include <algorithm>
#include <cmath>

#include "engine/assembly/problem.hpp"
#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"

namespace pantin::detail::assembly {

using lagrangian::Block;
using lagrangian::BlockKind;
using lagrangian::Island;
using lagrangian::RowVectors;

namespace {

/// The least length and radius, m.
constexpr Real kLeastSize = 1e-9;
/// Steps towards the least change, those without a measurable one, the relative step and the
/// relative fall of its squares that end them, and steps that close the laws after each.
constexpr int kMostReturns = 200, kMostIdle = 4, kMostClosing = 20;
constexpr Real kStill = 1e-11, kIdle = 1e-13;
/// Bounds of the weight of displacements beside changes.
constexpr Real kLeastWeight = 1e-6, kMostWeight = 1e9;
/// Damping of these steps, relative to the diagonal.
constexpr Real kUndamped = 1e-12;
/// rad: the largest rotation of one of these steps.
constexpr Real kMostTurn = 0.3;

Real scale_of(const FreeQuantity& q, Real size) {
  if (is_axis(q.of.quantity)) return 1 / size;
  const bool is_one = numbers_of(q.of.quantity) == 1;
  return is_one ? std::max(std::abs(q.start.numbers.x), kLeastSize) / size : 1;
}

/// Solves a symmetric positive definite system of n unknowns in place, by Cholesky's method; those
/// that are not free keep x.
void solve_dense(std::vector<Real> matrix, std::span<const std::uint8_t> is_free,
                 std::span<Real> x) {
  std::vector<std::size_t> of;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (is_free[i]) of.push_back(i);
  const auto at = [&](std::size_t i, std::size_t k) -> Real& {
    return matrix[of[i] * x.size() + of[k]];
  };
  for (std::size_t i = 0; i < of.size(); ++i)
    for (std::size_t k = 0; k <= i; ++k) {
      Real sum = at(i, k);
      for (std::size_t l = 0; l < k; ++l) sum -= at(i, l) * at(k, l);
      at(i, k) = i == k ? std::sqrt(std::max(sum, Real(1e-300))) : sum / at(k, k);
    }
  for (std::size_t i = 0; i < of.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) x[of[i]] -= at(i, k) * x[of[k]];
    x[of[i]] /= at(i, i);
  }
  for (std::size_t i = of.size(); i-- > 0;) {
    for (std::size_t k = i + 1; k < of.size(); ++k) x[of[i]] -= at(k, i) * x[of[k]];
    x[of[i]] /= at(i, i);
  }
}

/// How far a number may still fall and rise.
std::pair<Real, Real> room_of(const Design& d, const FreeQuantity& q) {
  if (numbers_of(q.of.quantity) > 1) return {-1e300, 1e300};
  const Real now = q.start.numbers.x + d.numbers[q.first];
  const Real least = is_size(q.of.quantity) ? std::max(q.of.least, kLeastSize) : q.of.least;
  // Pulleys that overlap shrink.
  const Real rise = std::min(std::max(Real(0), q.of.most - now), d.room[q.first]);
  return {std::min({Real(0), least - now, rise}), rise};
}

}  // namespace

void find_design(const World& world, Part& part, std::span<const DesignVariable> free) {
  Design& d = part.design;
  for (const DesignVariable& v : free) {
    const bool is_here = std::any_of(part.m.blocks.begin(), part.m.blocks.end(),
                                     [&](const Block& b) { return is_of(b, v, world); });
    if (!is_here || !fault_of(world, v).empty()) continue;
    const FreeQuantity q{v, value_of(world, v), d.scale.size()};
    d.scale.insert(d.scale.end(), numbers_of(v.quantity), 0);
    d.all.push_back(q);
    d.size = std::max(d.size, glm::length(q.start.numbers));
  }
  // Of single points on rods the island has no size.
  d.size = std::max(d.size, part.m.size);
  if (!(d.size > kLeastSize)) d.size = 1;
  for (const FreeQuantity& q : d.all)
    std::fill_n(d.scale.begin() + static_cast<std::ptrdiff_t>(q.first), numbers_of(q.of.quantity),
                scale_of(q, d.size));
  d.numbers.assign(d.scale.size(), 0), d.before = d.step = d.numbers;
  d.room.assign(d.scale.size(), 1e300);
  d.slopes.assign(d.scale.size() * part.m.rows, 0);
}

void solve_design(Part& part) {
  Design& d = part.design;
  lagrangian::StepScratch& scratch = part.m.scratch;
  const std::size_t n = d.numbers.size(), rows = part.m.rows;
  const auto column = [&](std::size_t i) { return std::span(d.slopes).subspan(i * rows, rows); };
  const auto dot = [&](std::size_t i, std::span<const Real> x) {
    Real sum = 0;
    for (std::size_t r = 0; r < rows; ++r) sum += d.slopes[i * rows + r] * x[r];
    return sum;
  };
  const auto subtract = [&](std::size_t i, Real factor) {
    for (std::size_t r = 0; r < rows; ++r) scratch.right[r] -= factor * d.slopes[i * rows + r];
  };
  std::vector<Real> target(n, 0), solved(scratch.right.size(), 0), schur(n * n, 0), pull(n, 0);
  for (std::size_t i = 0; i < n && d.returns; ++i) target[i] = -d.numbers[i];
  for (std::size_t i = 0; i < n; ++i) subtract(i, target[i]);
  std::vector<Real> right(scratch.right.size(), 0);
  for (std::size_t i = 0; i < n; ++i) {
    std::copy(column(i).begin(), column(i).end(), right.begin());
    lagrangian::solve_lambda(part.m, right, solved);
    for (std::size_t k = 0; k < n; ++k) schur[i * n + k] = dot(k, solved);
    schur[i * n + i] += 1 / (d.weight * d.scale[i] * d.scale[i]);
  }
  lagrangian::solve_lambda(part.m, scratch.right, solved);
  for (std::size_t i = 0; i < n; ++i) pull[i] = dot(i, solved);
  // Numbers that would pass a bound are put there, and the others are solved for again.
  std::vector<std::uint8_t> is_free(n, 1);
  std::vector<Real> more(n, 0);  // beyond the target
  for (bool again = true; again;) {
    again = false;
    for (std::size_t i = 0; i < n; ++i) {
      if (!is_free[i]) continue;
      more[i] = pull[i];
      for (std::size_t k = 0; k < n; ++k)
        if (!is_free[k]) more[i] -= schur[i * n + k] * more[k];
    }
    solve_dense(schur, is_free, more);
    for (const FreeQuantity& q : d.all) {
      const auto [fall, rise] = room_of(d, q);
      const Real step = target[q.first] + more[q.first];
      if (!is_free[q.first] || (step >= fall && step <= rise)) continue;
      more[q.first] = std::clamp(step, fall, rise) - target[q.first];
      is_free[q.first] = 0, again = true;
    }
  }
  for (std::size_t i = 0; i < n; ++i) subtract(i, more[i]), d.step[i] = target[i] + more[i];
}

void set_design(World& world, Part& part, std::span<const Real> numbers) {
  Design& d = part.design;
  if (numbers.data() != d.numbers.data()) d.numbers.assign(numbers.begin(), numbers.end());
  // Pairs of points are tracked again, on the surfaces as they are then.
  for (lagrangian::SurfaceFound& found : part.m.scratch.touching) found.is_fresh = false;
  for (const FreeQuantity& q : d.all) {
    DesignValue value = q.start;
    Vec3 by(0);
    for (std::size_t i = 0; i < numbers_of(q.of.quantity); ++i)
      by[static_cast<int>(i)] = d.numbers[q.first + i];
    value.numbers += by;
    value.axes = glm::normalize(q.start.axes * from_rotation_vector({0, by.x, by.y}));
    set_value(world, q.of, value);
    // The length of a cable is the position of its winch.
    for (const Block& b : part.m.blocks)
      if (b.kind == BlockKind::cable && q.of.quantity == Quantity::length && is_of(b, q.of, world))
        part.m.scratch.body_states[b.body[b.count - 1]].position.x = value.numbers.x;
  }
}

void move_design(World& world, Part& part, Real fraction) {
  Design& d = part.design;
  if (!d.any()) return;
  d.before = d.numbers;
  for (std::size_t i = 0; i < d.numbers.size(); ++i) d.numbers[i] += fraction * d.step[i];
  set_design(world, part, d.numbers);
}

void undo_design(World& world, Part& part) {
  if (part.design.any()) set_design(world, part, std::vector<Real>(part.design.before));
}

Real slope_of_design(const Part& part, std::span<const Real> by_row) {
  const Design& d = part.design;
  Real sum = 0;
  for (std::size_t i = 0; i < d.numbers.size(); ++i) {
    Real slope = 0;
    for (std::size_t r = 0; r < part.m.rows; ++r)
      slope += d.slopes[i * part.m.rows + r] * by_row[r];
    sum += d.scale[i] * slope * d.scale[i] * slope;
  }
  return sum;
}

Real change_of(const Design& d) {
  Real sum = 0;
  for (std::size_t i = 0; i < d.numbers.size(); ++i) {
    const Real x = d.numbers[i] / d.scale[i];
    sum += x * x;
  }
  return 0.5 * sum;
}

namespace {

/// A closed configuration to return to, with its revolutions and contacts.
struct Closed {
  lagrangian::Motions state;
  std::vector<lagrangian::BlockMemory> memory;
  std::vector<lagrangian::SurfaceMemory> touches;
  std::vector<Real> numbers;
  Real change = 0;
};

Closed closed_of(const Part& part) {
  const Island& m = part.m;
  return {m.scratch.state, m.memory, m.touches, part.design.numbers, change_of(part.design)};
}

void set_closed(World& world, Part& part, const Closed& to) {
  part.m.scratch.state = to.state, part.m.memory = to.memory, part.m.touches = to.touches;
  set_design(world, part, to.numbers);
  look(world, part);
}

enum class Aim { least_change, closed };

void take_step(World& world, Part& part, Aim aim) {
  part.design.returns = aim == Aim::least_change;
  solve_step(part, kUndamped);
  part.design.returns = false;
  const Real turn = turn_of(part);
  displace(world, part, turn > kMostTurn ? kMostTurn / turn : 1);
  look(world, part), count(world, part);
}

/// The largest relative step of a number, times the size, m.
Real step_of(const Design& d) {
  Real most = 0;
  for (std::size_t i = 0; i < d.step.size(); ++i)
    most = std::max(most, std::abs(d.step[i] / d.scale[i]));
  return most;
}

}  // namespace

// minimise |p + dp - p_0|^2 / 2 + weight |dq|^2 / 2, weight rising where a step went too far
void lessen_change(World& world, Part& part, Real tolerance) {
  Design& d = part.design;
  if (change_of(d) == 0) return;
  Closed best = closed_of(part);
  int idle = 0;
  d.weight = 1;
  for (int n = 0; n < kMostReturns && d.weight < kMostWeight; ++n) {
    take_step(world, part, Aim::least_change);
    const Real moved = step_of(d);
    for (int k = 0; k < kMostClosing && worst_of(part) > tolerance; ++k)
      take_step(world, part, Aim::closed);
    const Real change = change_of(d);
    if (worst_of(part) <= tolerance && change <= (1 + kStill) * best.change) {
      idle = change < (1 - kIdle) * best.change ? 0 : idle + 1;
      best = closed_of(part);
      d.weight = std::max(d.weight / 2, kLeastWeight);
      if (moved < kStill * d.size || idle == kMostIdle) break;
    } else {
      set_closed(world, part, best);
      d.weight *= 8;
    }
  }
  d.weight = 1;
  set_closed(world, part, best);
  // From the tolerance to rounding.
  const Real before = worst_of(part);
  take_step(world, part, Aim::closed);
  if (!(worst_of(part) < before)) set_closed(world, part, best);
}

}  // namespace pantin::detail::assembly
