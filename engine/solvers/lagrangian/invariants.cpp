// Invariants of packed islands and of the factor's pattern, on which all files of the solver rely.
#include "engine/base/invariants.hpp"

#include <algorithm>

#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// Frames are numbered after the bodies.
void assert_bodies(const Island& m) {
  [[maybe_unused]] const std::size_t n = m.count();
  PANTIN_ASSERT(n > 0 && m.slots.size() == n);
  PANTIN_ASSERT(m.mass.size() == n && m.inertia.size() == n);
  PANTIN_ASSERT(m.drag.size() == n && m.gravity_scale.size() == n);
  for ([[maybe_unused]] const Frame& f : m.frames)
    PANTIN_ASSERT((f.slot != UINT32_MAX) + (f.pin != UINT32_MAX) + (f.cable != UINT32_MAX) +
                      (f.drive != UINT32_MAX) ==
                  1);
}

void assert_block(const Island& m, std::size_t i) {
  const Block& b = m.blocks[i];
  [[maybe_unused]] const std::size_t bodies = m.count() + m.frames.size();
  PANTIN_ASSERT(b.rows >= 1 && b.rows <= 6 && b.count >= 1 && b.count <= kMostBlockBodies);
  for (std::size_t k = 0; k < b.count; ++k) PANTIN_ASSERT(b.body[k] < bodies);
  PANTIN_ASSERT(!b.point || (b.rows >= 3 && b.count == 2));
  if (b.kind == BlockKind::roll) {
    PANTIN_ASSERT(i > 0 && m.blocks[i - 1].kind == BlockKind::surface);
    PANTIN_ASSERT(b.first_place == m.blocks[i - 1].first_place && b.rows <= 3);
  }
  if (b.kind == BlockKind::gear)
    for ([[maybe_unused]] const std::uint8_t end : b.ends) PANTIN_ASSERT(end < b.count);
  PANTIN_ASSERT(b.kind != BlockKind::drive || (b.count == 3 && b.body[2] >= m.count()));
  PANTIN_ASSERT(b.kind != BlockKind::surface || b.first_place < m.touch_sources.size());
}

/// Rows and vectors of the blocks follow one another.
void assert_blocks(const Island& m) {
  [[maybe_unused]] std::size_t rows = 0, vectors = 0, compliant = 0;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    assert_block(m, i);
    PANTIN_ASSERT(b.first_row == rows && b.first_vector == vectors);
    rows += b.rows, vectors += vectors_of(b);
    compliant += is_compliant(b.kind) ? b.rows : 0;
  }
  PANTIN_ASSERT(m.rows == rows && m.vectors == vectors && m.joint_force_rows == compliant);
}

void assert_forces(const Island& m) {
  [[maybe_unused]] const std::size_t bodies = m.count() + m.frames.size();
  for (const auto* list : {&m.joint_torques, &m.elastic_cables, &m.elastic_pins})
    for ([[maybe_unused]] const BodyPairForce& p : *list)
      PANTIN_ASSERT(p.body[0] < bodies && p.body[1] < bodies);
  for ([[maybe_unused]] const JointForce& f : m.joint_forces)
    PANTIN_ASSERT(f.body[0] < bodies && f.body[1] < bodies);
  for (const std::vector<Block>* list : {&m.blocks, &m.elastic_paths})
    for ([[maybe_unused]] const Block& b : *list)
      PANTIN_ASSERT(b.kind != BlockKind::cable || b.first_place <= m.places.size());
}

}  // namespace

void assert_packed(const Island& m) {
  assert_bodies(m), assert_blocks(m), assert_forces(m);
  PANTIN_ASSERT(m.memory.size() == m.blocks.size());
  PANTIN_ASSERT(m.mean_lambda.size() == m.rows && m.forces.size() == m.rows);
  [[maybe_unused]] const std::size_t touches = m.touch_sources.size();
  PANTIN_ASSERT(m.touches.size() == touches + m.slips && m.touch_ways.size() == touches);
  PANTIN_ASSERT(m.touch_blocks.size() == touches);
  for (std::size_t i = 0; i < touches; ++i) {
    [[maybe_unused]] const std::uint32_t at = m.touch_blocks[i];
    PANTIN_ASSERT(at < m.blocks.size() && m.blocks[at].kind == BlockKind::surface);
    PANTIN_ASSERT(m.blocks[at].first_place == i && m.blocks[at].source == m.touch_sources[i]);
  }
}

void assert_factorable(const KktPattern& p) {
  [[maybe_unused]] const std::size_t nodes = p.order.size();
  PANTIN_ASSERT(p.place.size() == nodes && p.size.size() == nodes && p.unknown.size() == nodes);
  PANTIN_ASSERT(p.first.size() == nodes + 1 && p.first_target.size() == nodes + 1);
  PANTIN_ASSERT(p.offset.size() == p.below.size() && p.first.back() == p.below.size());
  for (std::uint32_t at = 0; at < nodes; ++at) {
    PANTIN_ASSERT(p.order[at] < nodes && p.place[p.order[at]] == at);  // a permutation
    PANTIN_ASSERT(p.size[at] >= 1 && p.size[at] <= 6);
    PANTIN_ASSERT(is_part(p.diagonal[at], std::size_t{p.size[at]} * p.size[at], p.numbers));
    PANTIN_ASSERT(is_part(p.unknown[at], p.size[at], p.unknowns));
    for (std::uint32_t i = p.first[at]; i < p.first[at + 1]; ++i) {
      PANTIN_ASSERT(p.below[i] > at && p.below[i] < nodes);
      PANTIN_ASSERT(i == p.first[at] || p.below[i] > p.below[i - 1]);
      PANTIN_ASSERT(is_part(p.offset[i], std::size_t{p.size[at]} * p.size[p.below[i]], p.numbers));
    }
  }
  for ([[maybe_unused]] const std::uint32_t target : p.targets) PANTIN_ASSERT(target < p.numbers);
  for ([[maybe_unused]] const KktPattern::BlockProduct& k : p.products)
    PANTIN_ASSERT(k.target < p.numbers);
  for (std::size_t h = 0; h < p.hubs.size(); ++h) PANTIN_ASSERT(p.hub_of[p.hubs[h]] == h);
}

}  // namespace pantin::detail::lagrangian
