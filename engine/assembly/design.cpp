#include "engine/assembly/design.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/assembly/problem.hpp"
#include "engine/base/rotation.hpp"
#include "engine/joints/cable_path.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/world/cable_route.hpp"

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

bool is_of(const Block& b, const DesignVariable& v, const World& world) {
  if (b.kind == BlockKind::joint || b.kind == BlockKind::limit)
    return world.links.owners()[b.source] == v.law;
  return b.kind == BlockKind::cable && world.cables.owners()[b.source] == v.law;
}

Real scale_of(const FreeQuantity& q, Real size) {
  const bool turns = q.of.quantity == Quantity::axis_a || q.of.quantity == Quantity::axis_b;
  if (turns) return 1 / size;
  const bool is_one = numbers_of(q.of.quantity) == 1;
  return is_one ? std::max(std::abs(q.start.numbers.x), kLeastSize) / size : 1;
}

/// G of a block for one design variable.
struct Slopes {
  const World& world;
  const Island& m;
  const FreeQuantity& q;
  std::span<const Real> numbers;  // of the variable
  std::span<Real> to;             // by number, then by row of the part

  Real& at(std::size_t number, std::size_t row) const { return to[number * m.rows + row]; }
  void write(std::size_t block) const;
  void write_anchor(const Block& b, std::size_t end) const;
  void write_axis(const Block& b, std::size_t end) const;
  void write_cable(const Block& b) const;
  void write_pitch(std::size_t block) const;
};

/// The residual depends on the anchor only by the point R anchor of the body, as on a displacement.
void Slopes::write_anchor(const Block& b, std::size_t end) const {
  const Mat3 turned = m.scratch.body_states[b.body[end]].rotation_matrix;
  for (std::size_t r = 0; r < b.rows; ++r) {
    const Vec3 v = row_of(b, jacobian_of(m, b), r, end).v * turned;
    for (int i = 0; i < 3; ++i) at(static_cast<std::size_t>(i), b.first_row + r) = v[i];
  }
}

/// And on the axes as on a rotation of the body about the anchor. The rotation vector (0, p) of the
/// axes has the rate J_r(0, p) (0, p') in these axes, J_r: the right Jacobian of SO(3).
void Slopes::write_axis(const Block& b, std::size_t end) const {
  const BodyState& body = m.scratch.body_states[b.body[end]];
  const Joint& joint = world.links[q.of.law].joint;
  const Vec3 arm = body.rotation_matrix * (end == 0 ? joint.anchor_a : joint.anchor_b);
  const Mat3 axes =
      body.rotation_matrix * glm::mat3_cast(end == 0 ? joint.frames.a() : joint.frames.b());
  const Vec3 turn(0, numbers[0], numbers[1]);
  const Real angle2 = glm::dot(turn, turn), angle = std::sqrt(angle2);
  const bool is_small = angle2 < 1e-6;
  const Real p = is_small ? 0.5 - angle2 / 24 : (1 - std::cos(angle)) / angle2;
  const Real s =
      is_small ? Real(1) / 6 - angle2 / 120 : (angle - std::sin(angle)) / (angle2 * angle);
  for (std::size_t i = 0; i < 2; ++i) {
    Vec3 unit(0);
    unit[static_cast<int>(i) + 1] = 1;
    const Vec3 across = glm::cross(turn, unit);
    const Vec3 rate = axes * (unit - p * across + s * glm::cross(turn, across));
    for (std::size_t r = 0; r < b.rows; ++r) {
      const RowVectors row = row_of(b, jacobian_of(m, b), r, end);
      at(i, b.first_row + r) = glm::dot(row.w - glm::cross(arm, row.v), rate);
    }
  }
}

/// C = length - L(path). L has the derivative R^T dL/dcentre by an anchor, and the angle of wrap by
/// a radius: the path is the shortest, so that its ends on the pulley do not count.
void Slopes::write_cable(const Block& b) const {
  const Cable& cable = world.cables[q.of.law];
  Pose poses[kMostPathPoints];
  std::size_t placed = 0;
  const auto pose_of = [&](Entity body) -> const Pose* {
    const auto mine = std::find(m.bodies.begin(), m.bodies.end(), body);
    if (mine == m.bodies.end()) return &world.bodies[body].pose;
    const auto i = static_cast<std::size_t>(mine - m.bodies.begin());
    Pose& pose = poses[placed++ % kMostPathPoints];
    return &(pose = {m.scratch.state.x[i], m.scratch.state.q[i]});
  };
  const std::vector<PathPoint> route = route_of(cable, pose_of);
  if (q.of.quantity == Quantity::radius) {
    Real wraps[kMostPathPoints];
    follow_path(route, 0, wraps);
    at(0, b.first_row) = -std::max(Real(0), wraps[q.of.guide + 1]);
    return;
  }
  PathGradient gradients[kMostPathPoints];
  path_length(route, gradients);
  const bool first = q.of.quantity == Quantity::anchor_a;
  const Pose end = *pose_of(first ? cable.a : cable.b);
  const Vec3 slope =
      glm::conjugate(end.rotation) * gradients[first ? 0 : route.size() - 1].by_centre;
  for (int i = 0; i < 3; ++i) at(static_cast<std::size_t>(i), b.first_row) = -slope[i];
}

/// Rows are linear in the pitch.
void Slopes::write_pitch(std::size_t block) const {
  const Block& b = m.blocks[block];
  const auto rows_at = [&](Real pitch) {
    Joint joint = world.links[q.of.law].joint;
    joint.parameters.edit().pitch = pitch;
    std::array<Real, 6> c{};
    write_rows({joint, m.scratch.body_states[b.body[0]], m.scratch.body_states[b.body[1]],
                m.memory[block].before[0]},
               {c.data(), nullptr, nullptr});
    return c;
  };
  const std::array<Real, 6> one = rows_at(1), none = rows_at(0);
  for (std::size_t r = 0; r < b.rows; ++r) at(0, b.first_row + r) = one[r] - none[r];
}

void Slopes::write(std::size_t block) const {
  const Block& b = m.blocks[block];
  const Quantity kind = q.of.quantity;
  if (kind == Quantity::length && b.kind == BlockKind::cable) {
    at(0, b.first_row) = 1;
  } else if (kind == Quantity::length) {
    // C = (d.d - L L) / (2 L)
    const Real length = world.links[q.of.law].joint.parameters->length;
    if (b.kind == BlockKind::joint) at(0, b.first_row) = -1 - m.scratch.c[b.first_row] / length;
  } else if (kind == Quantity::pitch) {
    if (b.kind == BlockKind::joint) write_pitch(block);
  } else if (b.kind == BlockKind::cable) {
    write_cable(b);
  } else if (kind == Quantity::anchor_a || kind == Quantity::anchor_b) {
    write_anchor(b, kind == Quantity::anchor_b);
  } else {
    write_axis(b, kind == Quantity::axis_b);
  }
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
  if (!is_size(q.of.quantity)) return {-1e300, 1e300};
  const Real now = q.start.numbers.x + d.numbers[q.first];
  return {std::min(Real(0), std::max(q.of.least, kLeastSize) - now),
          std::max(Real(0), q.of.most - now)};
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
  d.slopes.assign(d.scale.size() * part.m.rows, 0);
}

void write_slopes(const World& world, Part& part) {
  Design& d = part.design;
  std::fill(d.slopes.begin(), d.slopes.end(), Real(0));
  for (const FreeQuantity& q : d.all) {
    const std::size_t count = numbers_of(q.of.quantity), rows = part.m.rows;
    const Slopes slopes{world, part.m, q, std::span(d.numbers).subspan(q.first, count),
                        std::span(d.slopes).subspan(q.first * rows, count * rows)};
    for (std::size_t i = 0; i < part.m.blocks.size(); ++i)
      if (is_of(part.m.blocks[i], q.of, world) && lagrangian::is_active(part.m, i)) slopes.write(i);
  }
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
