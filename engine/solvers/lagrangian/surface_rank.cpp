// Finds surface joints whose gap row is redundant: with all other joints closed, an impulse along
// the normal does not open the gap.
#include <algorithm>

#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// Fraction of the response without joints; less is rounding.
constexpr Real kNothing = 1e-6;

bool is_held_to_roll(const Island& m, std::size_t block) {
  const Block& b = m.blocks[block];
  return b.kind == BlockKind::surface && m.touch_ways[b.first_place].a && is_active(m, block);
}

/// Response of the gap to a unit impulse along its row, with the joints of the current rows, as a
/// fraction of the response without joints.
Real part_that_opens(const World& world, Island& m, const Block& gap) {
  StepScratch& scratch = m.scratch;
  Vec3 row[4];
  std::copy_n(jacobian_of(m, gap), 4, row);
  scratch.leaves_gaps = true;
  write_all_rows(world, m, {true, false});
  scratch.leaves_gaps = false;
  factor(m);
  Real whole = 0, opens = 0;
  std::fill(scratch.force.begin(), scratch.force.end(), Vec3(0));
  std::fill(scratch.right.begin(), scratch.right.end(), 0.0);
  for (std::size_t k = 0; k < 2; ++k) {
    const std::uint32_t body = gap.body[k];
    if (body >= m.count()) continue;
    scratch.force[2 * body] += row[2 * k], scratch.force[2 * body + 1] += row[2 * k + 1];
    whole += glm::dot(row[2 * k], row[2 * k]) / m.mass[body] +
             glm::dot(row[2 * k + 1], scratch.inverse_inertia[body] * row[2 * k + 1]);
  }
  const Real residual = scratch.worst_relative_residual;
  solve(m, {scratch.force, scratch.right}, {scratch.solution, scratch.lambda});
  scratch.worst_relative_residual = residual;
  for (std::size_t k = 0; k < 2; ++k)
    if (const std::uint32_t body = gap.body[k]; body < m.count())
      opens += glm::dot(row[2 * k], scratch.solution[2 * body]) +
               glm::dot(row[2 * k + 1], scratch.solution[2 * body + 1]);
  return opens / whole;
}

}  // namespace

void find_following_gaps(const World& world, Island& m, Real h) {
  for (SurfaceFound& found : m.scratch.touching) found.gap_follows = false;
  bool is_written = false;
  for (std::size_t i = 0; m.loops && i < m.blocks.size(); ++i) {
    if (!is_held_to_roll(m, i)) continue;
    if (!is_written)
      update_kinematics(m), update_frames(world, m, 0, h), write_all_rows(world, m, {true, false});
    is_written = true;
    bool& follows = m.scratch.touching[m.blocks[i].first_place].gap_follows;
    follows = true;
    follows = part_that_opens(world, m, m.blocks[i]) <= kNothing;
    write_all_rows(world, m, {true, false});
  }
}

}  // namespace pantin::detail::lagrangian
