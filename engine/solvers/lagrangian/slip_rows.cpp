// Rows of joints that constrain velocities only: skates and wheels.
#include <algorithm>

#include "engine/joints/kinds.hpp"
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// A joint that may hold its bodies apart.
bool may_carry(const Block& b) {
  return b.kind == BlockKind::surface || (b.kind == BlockKind::joint && b.holonomic);
}
bool joins(const Block& b, std::uint32_t one, std::uint32_t two) {
  return (b.body[0] == one && b.body[1] == two) || (b.body[0] == two && b.body[1] == one);
}

/// The only joint that carries and for which `fits` holds. UINT32_MAX: none, and `several` tells
/// whether because there are more.
template <class Fits>
std::uint32_t only_carrier(const Island& m, const Fits& fits, bool& several) {
  std::uint32_t found = UINT32_MAX;
  several = false;
  for (std::uint32_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    if (!may_carry(b) || !fits(b)) continue;
    const bool is_same = found != UINT32_MAX && m.blocks[found].kind == b.kind &&
                         m.blocks[found].source == b.source;  // another place of the same surfaces
    several = several || (found != UINT32_MAX && !is_same);
    if (found == UINT32_MAX) found = i;
  }
  return several ? UINT32_MAX : found;
}

}  // namespace

bool find_carrier(Island& m, std::size_t block) {
  const std::uint32_t a = m.blocks[block].body[0], b = m.blocks[block].body[1];
  bool several = false;
  std::uint32_t found = only_carrier(
      m, [&](const Block& by) { return joins(by, a, b); }, several);
  const auto carries_neighbour = [&](const Block& by) {
    if (by.body[0] != a && by.body[1] != a) return false;
    const std::uint32_t next = by.body[0] == a ? by.body[1] : by.body[0];
    return std::any_of(m.blocks.begin(), m.blocks.end(),
                       [&](const Block& k) { return may_carry(k) && joins(k, next, b); });
  };
  if (found == UINT32_MAX && !several) found = only_carrier(m, carries_neighbour, several);
  m.blocks[block].carrier = found;
  if (found == UINT32_MAX) return false;
  m.blocks[found].carries = true;
  return true;
}

Real load_of(const Island& m, const Block& slip, std::span<const Real> lambda) {
  const Block& first = m.blocks[slip.carrier];
  Vec3 pull[2] = {Vec3(0), Vec3(0)};
  for (std::size_t i = slip.carrier; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    if (b.source != first.source) break;
    if (b.kind == first.kind && is_active(m, i))
      add_constraint_force({b, jacobian_of(m, b), 0}, &lambda[b.first_row], pull);
  }
  return glm::dot(pull[0], m.scratch.touching[slip.first_place].normal);
}

void write_slip(const World& world, Island& m, std::size_t block, RowsOut out) {
  const Block& b = m.blocks[block];
  PANTIN_ASSERT(b.kind == BlockKind::joint && !b.holonomic && b.rows <= 2 && b.count == 2);
  const Joint& joint = world.links.values()[b.source].joint;
  const BodyState &at_a = m.scratch.body_states[b.body[0]],
                  &at_b = m.scratch.body_states[b.body[1]];
  const SlipPoint p = info_of(joint.kind).slip_point(joint, at_a, at_b);
  write_slip_rows(p, {joint, at_a, at_b}, b.rows, out);
  if (may_slip(b)) {
    SurfaceFound& found = m.scratch.touching[b.first_place];
    found.normal = p.normal, found.arm[0] = p.arm_a, found.arm[1] = p.arm_b;
    std::copy_n(p.tangent, 2, found.tangent);
  }
  if (is_active(m, block)) return;
  std::fill_n(out.j, vectors_of(b), Vec3(0));
  if (out.gamma) std::fill_n(out.gamma, b.rows, 0.0);
}

}  // namespace pantin::detail::lagrangian
