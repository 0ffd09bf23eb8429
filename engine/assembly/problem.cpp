#include "engine/assembly/problem.hpp"

#include <algorithm>
#include <cmath>

#include "engine/assembly/surfaces.hpp"
#include "engine/base/rotation.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::assembly {

using lagrangian::add_constraint_force;
using lagrangian::Block;
using lagrangian::BlockKind;
using lagrangian::Island;
using lagrangian::jacobian_of;
using lagrangian::RowVectors;
using lagrangian::SurfaceMemory;

namespace {

/// s: frames are evaluated at the present time, so its length does not matter.
constexpr Real kStep = 1e-3;
constexpr lagrangian::Want kRows{.c = true, .gamma = false};
/// Regularisation of dependent rows, relative to the diagonal, where damping has vanished.
constexpr Real kRegularisation = 1e-11;
/// The same with design variables: rounding and the error of the regularisation are equal then.
constexpr Real kRegularisationOfDesign = 1e-8;
/// The least arm of a body, as a fraction of its largest radius of gyration or of the mechanism.
constexpr Real kLeastArm = 1e-3;
/// Searches for the pairs of a surface joint that was lost.
constexpr Real kSearchSpan = 1;

/// Whether a row measures angles, not lengths.
bool is_angular(const Island& m, const Block& b, std::size_t row) {
  switch (b.kind) {
    case BlockKind::limit:
      return b.coordinate != Coordinate::travel;
    case BlockKind::gear:
      return b.second != Coordinate::travel;
    case BlockKind::joint:
      if (b.point) return row >= 3;
      for (std::size_t k = 0; k < b.count; ++k)
        if (row_of(b, jacobian_of(m, b), row, k).v != Vec3(0)) return false;
      return true;
    default:  // points and lengths
      return false;
  }
}

/// Sets mass 1 and inertia arm^2, with the mean square of the arms of a body's laws.
void set_metric(Island& m) {
  std::vector<Real> sum(m.count(), 0), number(m.count(), 0);
  for (const Block& b : m.blocks)
    for (std::size_t r = 0; r < b.rows; ++r)
      for (std::size_t k = 0; k < b.count; ++k) {
        if (b.body[k] >= m.count() || lagrangian::is_compliant(b.kind)) continue;
        const RowVectors j = row_of(b, jacobian_of(m, b), r, k);
        const Real v = glm::dot(j.v, j.v);
        if (v < 1e-12) continue;
        sum[b.body[k]] += glm::dot(j.w, j.w) / v, number[b.body[k]] += 1;
      }
  for (std::size_t b = 0; b < m.count(); ++b) {
    const Vec3 inertia = m.inertia[b] / m.mass[b];
    const Real gyration = std::max({inertia.x, inertia.y, inertia.z});
    const Real arm = number[b] > 0 ? sum[b] / number[b] : 0;
    m.mass[b] = 1;
    m.inertia[b] = Vec3(std::max(
        {arm, kLeastArm * m.size * kLeastArm * m.size, arm > 0 ? kLeastArm * gyration : gyration}));
  }
}

void set_units(Part& part) {
  const Island& m = part.m;
  part.units.assign(m.rows, 1);
  for (const Block& b : m.blocks)
    for (std::size_t r = 0; r < b.rows; ++r) {
      Real sum = 0;
      const bool angular = is_angular(m, b, r);
      for (std::size_t k = 0; k < b.count; ++k)
        if (b.body[k] < m.count()) sum += angular ? 1 / m.inertia[b.body[k]].x : 1;
      part.units[b.first_row + r] = std::max(sum, Real(1e-12));
    }
}

/// Whether a bilateral surface joint tracks no pair.
bool has_unknown_pairs(const Island& m) {
  for (std::size_t n = 0; n < m.touches.size(); ++n)
    if (m.blocks[m.touch_blocks[n]].lock && !m.touches[n].known && !m.touches[n].is_over())
      return true;
  return false;
}

/// Kinematics of bodies at rest. Their inverse inertia is a multiple of one in all poses, set once.
void place_bodies(Island& m) {
  const lagrangian::Motions& s = m.scratch.state;
  for (std::size_t b = 0; b < m.count(); ++b) {
    BodyState& at = m.scratch.body_states[b];
    at.position = s.x[b], at.rotation = s.q[b], at.rotation_matrix = glm::mat3_cast(s.q[b]);
  }
}

/// Rolling that holds velocities only does not count.
void write_rows(const World& world, Island& m, lagrangian::Want want = kRows) {
  lagrangian::write_all_rows(world, m, want);
  lagrangian::clear_rolling(m);
}

}  // namespace

Problem make_problem(const World& world, std::span<const Entity> held,
                     std::span<const DesignVariable> free) {
  Problem p{world, {}, {}};
  World& w = p.world;
  w.default_settings.solver = Solver::lagrangian;
  for (SolverSettings& settings : w.settings.values()) settings.solver = Solver::lagrangian;
  for (const Entity e : held)
    if (Body* body = w.bodies.find(e); body && body->motion == Motion::dynamic)
      body->motion = Motion::fixed;
  // Drives are motions in time: configurations are not bound to them.
  const std::vector<Entity> driven(w.joint_drives.owners().begin(), w.joint_drives.owners().end());
  for (const Entity e : driven)
    if (w.joint_drives[e].exact) w.joint_drives.remove(e);
  w.mark_dirty();
  compile_if_changed(w);
  for (Island& m : lagrangian::islands_of(w)) {
    if (m.count() == 0 || m.equations() == 0) continue;
    if (m.unfit) {
      p.unfit.push_back(m.unfit);
      continue;
    }
    Part part(m);
    lagrangian::place_for_inspection(w, part.m, kStep);
    part.m.scratch.poses_only = true;
    part.m.loops = false;  // dependent rows are regularised, and steps are not refined
    lagrangian::forget_turns(part.m), lagrangian::count_turns(w, part.m);
    for (lagrangian::BlockMemory& memory : part.m.memory) memory.active = true;
    write_rows(w, part.m);
    set_metric(part.m);
    lagrangian::update_kinematics(part.m);
    set_units(part);
    for (lagrangian::BlockMemory& memory : part.m.memory) memory.active = false;
    for (const Block& b : part.m.blocks) part.bounds.push_back(b.bound);
    // A surface or curve that islands share belongs to the first.
    std::vector<DesignVariable> own;
    for (const DesignVariable& v : free)
      if (std::none_of(p.parts.begin(), p.parts.end(), [&](const Part& other) {
            return std::any_of(other.design.all.begin(), other.design.all.end(),
                               [&](const FreeQuantity& q) { return q.of.is_same(v); });
          }))
        own.push_back(v);
    find_design(w, part, own);
    look(w, part);
    p.parts.push_back(std::move(part));
  }
  return p;
}

Poses poses_of(const Part& part) {
  const lagrangian::Motions& s = part.m.scratch.state;
  Poses poses(part.m.count());
  for (std::size_t b = 0; b < poses.size(); ++b) poses[b] = {s.x[b], s.q[b]};
  return poses;
}

void set_poses(const World& world, Part& part, std::span<const Pose> poses) {
  Island& m = part.m;
  PANTIN_ASSERT(poses.size() == m.count());
  for (std::size_t b = 0; b < poses.size(); ++b)
    m.scratch.state.x[b] = poses[b].position, m.scratch.state.q[b] = poses[b].rotation;
  for (lagrangian::BlockMemory& memory : m.memory) memory.active = false;
  lagrangian::update_kinematics(m);
  lagrangian::forget_turns(m), lagrangian::count_turns(world, m);
  for (std::size_t i = 0; i < m.blocks.size(); ++i) m.blocks[i].bound = part.bounds[i];
  look(world, part);
}

namespace {

void look_at_rows(const World& world, Part& part, lagrangian::Want want) {
  Island& m = part.m;
  place_bodies(m);
  m.scratch.lost_touch = UINT32_MAX;
  write_rows(world, m, want);
  if (m.scratch.lost_touch != UINT32_MAX) {
    // Bilateral pairs that are lost are searched again; the gap is then unknown, not zero.
    SurfaceMemory& lost = m.touches[m.scratch.lost_touch];
    if (m.blocks[m.touch_blocks[m.scratch.lost_touch]].lock) lost.known = false;
    lagrangian::look_for_touches(world, m, kSearchSpan);
    m.scratch.lost_touch = UINT32_MAX;
    write_rows(world, m);
  }
  if (!m.touches.empty() && has_unknown_pairs(m)) {
    find_pairs_anywhere(world, part);
    write_rows(world, m);
  }
  if (!m.unilateral) return;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    if (!lagrangian::is_one_sided(m, i)) continue;
    const std::uint32_t row = m.blocks[i].first_row;
    const bool was = m.memory[i].active;
    m.memory[i].active = m.scratch.c[row] < 0 || (was && m.scratch.lambda[row] > 0);
    if (m.memory[i].active != was) lagrangian::write_block(world, m, i, kRows);
  }
}

}  // namespace

void look(const World& world, Part& part) {
  look_at_rows(world, part, kRows);
  if (part.design.any()) write_slopes(world, part);
}

void look_at_residuals(const World& world, Part& part) {
  look_at_rows(world, part, {.c = true, .gamma = false, .jacobian = false});
}

void count(const World& world, Part& part) { lagrangian::count_turns(world, part.m); }

bool counts(const Part& part, std::size_t block) {
  const Block& b = part.m.blocks[block];
  // A bilateral surface joint without a pair is open by more than is known.
  if (b.kind == BlockKind::surface && b.lock) return !part.m.touches[b.first_place].is_over();
  if (lagrangian::is_compliant(b.kind) || !lagrangian::is_active(part.m, block)) return false;
  return !lagrangian::is_one_sided(part.m, block) || part.m.scratch.c[b.first_row] < 0;
}

Real merit_of(const Part& part) {
  Real sum = 0;
  for (std::size_t i = 0; i < part.m.blocks.size(); ++i) {
    if (!counts(part, i)) continue;
    const Block& b = part.m.blocks[i];
    for (std::size_t r = b.first_row; r < b.first_row + b.rows; ++r)
      sum += part.m.scratch.c[r] * part.m.scratch.c[r] / part.units[r];
  }
  return 0.5 * sum;
}

Real worst_of(const Part& part) {
  Real worst = 0;
  for (std::size_t i = 0; i < part.m.blocks.size(); ++i) {
    if (!counts(part, i)) continue;
    const Block& b = part.m.blocks[i];
    for (std::size_t r = b.first_row; r < b.first_row + b.rows; ++r)
      worst = worse_of(worst, part.m.scratch.c[r]);
  }
  return worst;
}

Real slope_of(Part& part) {
  Island& m = part.m;
  std::vector<Vec3>& pull = m.scratch.force;
  std::fill(pull.begin(), pull.end(), Vec3(0));
  std::fill(m.scratch.right.begin(), m.scratch.right.end(), Real(0));
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    if (!counts(part, i)) continue;
    const Block& b = m.blocks[i];
    Real lambda[6] = {};
    for (std::size_t r = 0; r < b.rows; ++r)
      m.scratch.right[b.first_row + r] = lambda[r] =
          m.scratch.c[b.first_row + r] / part.units[b.first_row + r];
    for (std::size_t k = 0; k < b.count; ++k)
      if (b.body[k] < m.count())
        add_constraint_force({b, jacobian_of(m, b), k}, lambda, &pull[2 * b.body[k]]);
  }
  Real sum = slope_of_design(part, m.scratch.right);
  for (std::size_t b = 0; b < m.count(); ++b)
    sum += glm::dot(pull[2 * b], pull[2 * b]) +
           glm::dot(pull[2 * b + 1], pull[2 * b + 1]) / m.inertia[b].x;
  const Real merit = 2 * merit_of(part);
  return merit > 0 ? std::sqrt(sum / merit) : 0;
}

void set_equations(Part& part, Real damping) {
  Island& m = part.m;
  lagrangian::StepScratch& scratch = m.scratch;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    const bool on = !lagrangian::is_compliant(b.kind) && lagrangian::is_active(m, i);
    for (std::size_t r = b.first_row; r < b.first_row + b.rows; ++r) {
      scratch.weights[r] = on ? damping * part.units[r] : 0;
      scratch.right[r] = on ? -scratch.c[r] : 0;
    }
  }
}

void solve_equations(Part& part) {
  Island& m = part.m;
  lagrangian::factor_soft(m, part.design.any() ? kRegularisationOfDesign : kRegularisation);
  if (part.design.any()) solve_design(part);
  solve_again(part);
}

void solve_again(Part& part) {
  lagrangian::StepScratch& scratch = part.m.scratch;
  constexpr Real kUnrefined = std::numeric_limits<Real>::infinity();
  lagrangian::solve(part.m, {{}, scratch.right}, {scratch.solution, scratch.lambda}, kUnrefined);
}

void solve_step(Part& part, Real damping) {
  set_equations(part, damping);
  solve_equations(part);
}

Real turn_of(const Part& part) {
  Real most = 0;
  for (std::size_t b = 0; b < part.m.count(); ++b) {
    const Vec3 turn = part.m.scratch.solution[2 * b + 1];
    most = std::max(most, glm::dot(turn, turn));
  }
  return std::sqrt(most);
}

void move(Part& part, Real fraction) {
  lagrangian::Motions& s = part.m.scratch.state;
  const std::vector<Vec3>& way = part.m.scratch.solution;
  for (std::size_t b = 0; b < part.m.count(); ++b) {
    s.x[b] += fraction * way[2 * b];
    s.q[b] = glm::normalize(from_rotation_vector(fraction * way[2 * b + 1]) * s.q[b]);
  }
}

void displace(World& world, Part& part, Real fraction) {
  move(part, fraction);
  move_design(world, part, fraction);
}

void write_poses(const Part& part, World& world) {
  const lagrangian::Motions& s = part.m.scratch.state;
  for (std::size_t b = 0; b < part.m.count(); ++b)
    if (Body* body = world.bodies.find(part.m.bodies[b])) body->pose = {s.x[b], s.q[b]};
}

}  // namespace pantin::detail::assembly
