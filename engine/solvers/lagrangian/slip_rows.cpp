// Rows of joints that constrain velocities only: skates and wheels.
#include <algorithm>

#include "engine/joints/kinds.hpp"
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {

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
