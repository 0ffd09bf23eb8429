// Coulomb friction of surface joints, and of skates and wheels: with a grip, which stands for mu N,
// or with a coefficient and the load of the joint that carries them.
// While friction sticks, the rolling rows are constraints.
// While it slips, a force mu N opposes the slip; N is the multiplier of the gap row and depends on
// that force in turn. Sticking ends when the force needed exceeds mu N; sliding ends when the slip
// speed crosses zero.
#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// m/s: slower slip keeps its last direction.
constexpr Real kStill = 1e-9;
/// m/s: slower slip counts as none. kAcross: fraction of the slip speed that may remain across the
/// direction of a slip that ends.
constexpr Real kNoSlip = 1e-6, kAcross = 0.02;
/// Residual of the friction forces, relative to the largest force.
constexpr Real kGripTolerance = 1e-13;

bool has_friction(const Island& m, std::size_t block) { return may_slip(m.blocks[block]); }
bool has_load(const Block& b) { return b.kind == BlockKind::roll || b.carrier != UINT32_MAX; }
/// Whether the surfaces of a rolling block press. A skate always does.
bool bears(const Island& m, std::size_t block) {
  return m.blocks[block].kind != BlockKind::roll || is_active(m, block - 1);
}
/// N: normal force of a rolling block, or load of a skate, signed. 1 for a skate whose bound is a
/// force.
Real normal_force(const Island& m, std::size_t block, std::span<const Real> lambda) {
  const Block& b = m.blocks[block];
  if (b.kind == BlockKind::roll) return lambda[m.blocks[block - 1].first_row];
  return b.carrier != UINT32_MAX ? load_of(m, b, lambda) : 1;
}
Real press_of(const Island& m, std::size_t block, std::span<const Real> lambda) {
  return std::abs(normal_force(m, block, lambda));
}
/// Whether a rolling block slips against friction.
bool slips(const Island& m, std::size_t block) {
  PANTIN_ASSERT(block < m.blocks.size());
  return has_friction(m, block) && !m.memory[block].active && bears(m, block);
}

/// Adds a friction force of magnitude `size` to forces and torques, two a body.
void add_friction(const Island& m, const Block& roll, Real size, std::span<Vec3> force) {
  PANTIN_ASSERT(may_slip(roll) && 2 * m.count() <= force.size());
  const SurfaceFound& found = m.scratch.touching[roll.first_place];
  for (std::size_t k = 0; k < 2; ++k) {
    if (roll.body[k] >= m.count()) continue;
    const Vec3 pull = (k == 0 ? -size : size) * found.along;
    force[2 * roll.body[k]] += pull;
    force[2 * roll.body[k] + 1] += glm::cross(found.arm[k], pull);
  }
}

/// Slip velocity of a on b, m/s.
Vec3 slip_of(const Island& m, const Block& roll) {
  const SurfaceFound& found = m.scratch.touching[roll.first_place];
  Vec3 v(0);
  for (std::size_t k = 0; k < 2; ++k) {
    const BodyState& at = m.scratch.body_states[roll.body[k]];
    v += (k == 0 ? 1.0 : -1.0) * (at.velocity + glm::cross(at.angular_velocity, found.arm[k]));
  }
  if (roll.rows == 1) return glm::dot(v, found.tangent[0]) * found.tangent[0];
  return v - glm::dot(v, found.normal) * found.normal;
}

/// m/s: below this slip speed the direction of friction lags, as in an implicit step. Friction ends
/// slip across the direction `way` within `slip / deceleration` seconds, which is then less than
/// the substep.
Real lag_speed(const Island& m, const Block& roll, Vec3 way) {
  const SurfaceFound& found = m.scratch.touching[roll.first_place];
  const Vec3 across = glm::cross(found.normal, way);
  Real mobility = 0;
  for (std::size_t k = 0; k < 2; ++k) {
    if (roll.body[k] >= m.count()) continue;
    const Vec3 turn = glm::cross(found.arm[k], across);
    mobility +=
        1 / m.mass[roll.body[k]] + glm::dot(turn, m.scratch.inverse_inertia[roll.body[k]] * turn);
  }
  return m.scratch.part_h * roll.bound * found.grip * mobility;
}

/// The direction of a slip that had the direction `before`.
Vec3 way_of(const Island& m, const Block& roll, Vec3 slip, Vec3 before) {
  const Real speed = glm::length(slip);
  const Real lag = roll.rows == 1 ? 0 : std::max(lag_speed(m, roll, before) - 0.5 * speed, Real(0));
  const Vec3 normal = m.scratch.touching[roll.first_place].normal;
  return glm::normalize(slip + lag * (before - glm::dot(before, normal) * normal));
}

/// Sets the direction that friction opposes. It keeps its sign within a substep: reversal is an
/// event.
void aim(Island& m, const Block& roll) {
  SurfaceFound& found = m.scratch.touching[roll.first_place];
  PANTIN_ASSERT(is_unit(found.normal));
  const Vec3 before = m.touches[roll.first_place].slip, slip = slip_of(m, roll);
  if (glm::length(slip) > kStill) {
    found.along = way_of(m, roll, glm::dot(slip, before) < 0 ? -slip : slip, before);
    return;
  }
  if (roll.kind != BlockKind::roll && roll.rows == 1) {
    found.along = (glm::dot(before, found.tangent[0]) < 0 ? -1.0 : 1.0) * found.tangent[0];
    return;
  }
  const Vec3 way = before - glm::dot(before, found.normal) * found.normal;
  const Real length = glm::length(way);
  found.along = length > 0.5 ? way / length : Vec3(0);
}

/// The force of the rolling rows on a.
Vec3 held_by(const Island& m, const Block& roll, std::span<const Real> lambda) {
  const SurfaceFound& found = m.scratch.touching[roll.first_place];
  PANTIN_ASSERT(roll.rows <= std::size(found.tangent));
  Vec3 sum(0);
  for (std::size_t r = 0; r < roll.rows; ++r) sum += lambda[roll.first_row + r] * found.tangent[r];
  return sum;
}

}  // namespace

void begin_slips(Island& m) {
  for (std::size_t i = 0; m.rubs && i < m.blocks.size(); ++i) {
    if (!has_friction(m, i) || !bears(m, i)) continue;
    const Vec3 slip = slip_of(m, m.blocks[i]);
    const Real speed = glm::length(slip);
    m.memory[i].active = !(speed > kNoSlip);
    m.touches[m.blocks[i].first_place].slip = speed > kNoSlip ? slip / speed : Vec3(0);
  }
}

void update_slip_directions(Island& m, Real h) {
  m.scratch.part_h = h;
  set_grips(m, m.mean_lambda);
  for (std::size_t i = 0; m.rubs && i < m.blocks.size(); ++i)
    if (has_friction(m, i))
      m.scratch.touching[m.blocks[i].first_place].holds = SurfaceFound::Holds::as_it_can,
      m.scratch.touching[m.blocks[i].first_place].jams = false;
  aim_slips(m);
}

void aim_slips(Island& m) {
  for (std::size_t i = 0; m.rubs && i < m.blocks.size(); ++i) {
    if (!slips(m, i)) continue;
    SurfaceFound& found = m.scratch.touching[m.blocks[i].first_place];
    const Vec3 slip = slip_of(m, m.blocks[i]);
    found.slip_before = glm::length(slip);
    Vec3& way = m.touches[m.blocks[i].first_place].slip;
    if (found.slip_before > kNoSlip)
      way = glm::dot(slip, way) > 0 ? way_of(m, m.blocks[i], slip, way) : slip / found.slip_before;
    aim(m, m.blocks[i]);
  }
}

Real slip_left(const Island& m, std::size_t block) {
  if (!m.rubs || !slips(m, block)) return 1e300;
  return glm::dot(slip_of(m, m.blocks[block]), m.touches[m.blocks[block].first_place].slip);
}

bool has_slip_ended(const Island& m, std::size_t block, Real tolerance) {
  return slip_left(m, block) <= tolerance &&
         !m.scratch.touching[m.blocks[block].first_place].has_let_go;
}

void end_slips(Island& m, Real tolerance) {
  for (std::size_t i = 0; m.rubs && i < m.blocks.size(); ++i) {
    if (!has_slip_ended(m, i, tolerance)) continue;
    const std::uint32_t place = m.blocks[i].first_place;
    const Vec3 slip = slip_of(m, m.blocks[i]);
    const Real speed = glm::length(slip);
    // A slip that reverses and ends again in this step would chatter; it sticks.
    const bool turns = ++m.scratch.touching[place].ends > 1;
    if (turns || speed <= std::max(kNoSlip, kAcross * m.scratch.touching[place].slip_before))
      m.memory[i].active = true, m.scratch.touching[place].holds = SurfaceFound::Holds::anyway;
    else
      m.touches[place].slip = slip / speed;
  }
}

Real grip_left(const Island& m, std::size_t block, std::span<const Real> lambda) {
  const Block& roll = m.blocks[block];
  if (!m.rubs || !has_friction(m, block) || !m.memory[block].active || !bears(m, block) ||
      m.scratch.touching[roll.first_place].holds == SurfaceFound::Holds::anyway)
    return 1e300;
  const Real grip = roll.bound * press_of(m, block, lambda);
  return grip - glm::length(held_by(m, roll, lambda));
}

void release_sticking(Island& m, std::size_t block, std::span<const Real> lambda) {
  const Block& roll = m.blocks[block];
  m.memory[block].active = false;
  m.scratch.touching[roll.first_place].holds = SurfaceFound::Holds::gave_way;
  m.touches[roll.first_place].slip = -glm::normalize(held_by(m, roll, lambda));
}

bool yield_holding(Island& m, std::span<const Real> lambda, Real least) {
  using Holds = SurfaceFound::Holds;
  bool any = false;
  for (std::size_t i = 0; m.rubs && i < m.blocks.size(); ++i) {
    if (!has_friction(m, i) || !bears(m, i)) continue;
    SurfaceFound& found = m.scratch.touching[m.blocks[i].first_place];
    const bool jams = std::exchange(found.jams, false) && !m.memory[i].active;
    if (jams || (found.holds == Holds::gave_way && slip_left(m, i) < 0)) {
      found.holds = Holds::anyway, m.memory[i].active = any = true;
      continue;
    }
    const Real left = grip_left(m, i, lambda);
    const Real rounding = 1e-9 * press_of(m, i, lambda) * m.blocks[i].bound;
    if (!(left < -(rounding + least))) continue;
    release_sticking(m, i, lambda), any = true;
  }
  return any;
}

Real set_grips(Island& m, std::span<const Real> lambda) {
  Real most = 0, change = 0;
  for (const Vec3& force : m.scratch.force) most = std::max(most, glm::length(force));
  for (std::size_t i = 0; m.rubs && i < m.blocks.size(); ++i) {
    if (!has_friction(m, i)) continue;
    Real& grip = m.scratch.touching[m.blocks[i].first_place].grip;
    const Real before = grip;
    grip = press_of(m, i, lambda);
    if (slips(m, i))
      most = std::max(most, grip), change = std::max(change, std::abs(grip - before));
  }
  return most > 0 ? change / most : 0;
}

void add_slip_forces(Island& m) {
  for (std::size_t i = 0; m.rubs && i < m.blocks.size(); ++i) {
    if (!slips(m, i)) continue;
    const Block& roll = m.blocks[i];
    aim(m, roll);
    add_friction(m, roll, roll.bound * m.scratch.touching[roll.first_place].grip, m.scratch.force);
  }
}

Real raise_grips(Island& m, Real h, std::span<Vec3> load) {
  // Where the normal force crosses 0, it is the difference of larger forces.
  Real most = 0, change = 0;
  for (std::size_t b = 0; m.rubs && b < m.count(); ++b)
    most = std::max(most, glm::length(load[2 * b]) / h);
  for (std::size_t i = 0; m.rubs && i < m.blocks.size(); ++i) {
    if (!slips(m, i)) continue;
    SurfaceFound& found = m.scratch.touching[m.blocks[i].first_place];
    if (!has_load(m.blocks[i])) continue;
    const Real force = normal_force(m, i, m.scratch.lambda) / h;
    const Real grip = std::abs(force + m.touches[m.blocks[i].first_place].projected);
    add_friction(m, m.blocks[i], h * m.blocks[i].bound * (grip - found.grip), load);
    most = std::max(most, grip), change = std::max(change, std::abs(grip - found.grip));
    found.grip = grip;
  }
  return change > kGripTolerance * most ? change : 0;
}

void jam_slips(Island& m, Real h, std::span<Vec3> load) {
  for (std::size_t i = 0; m.rubs && i < m.blocks.size(); ++i) {
    if (!slips(m, i)) continue;
    SurfaceFound& found = m.scratch.touching[m.blocks[i].first_place];
    if (!load.empty()) add_friction(m, m.blocks[i], -h * m.blocks[i].bound * found.grip, load);
    found.grip = 0, found.jams = true;
  }
}

}  // namespace pantin::detail::lagrangian
