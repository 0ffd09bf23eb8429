// State that islands keep when they are compiled again.
#include <algorithm>

#include "engine/solvers/lagrangian/integrator.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// Whether an island has the same structure as before; slots are those of the two builds.
struct Unchanged {
  const World& world;
  const Island &was, &now;

  bool is_same_source(BlockKind kind, std::uint32_t old, std::uint32_t slot) const {
    switch (kind) {
      case BlockKind::pin:
      case BlockKind::elastic_pin:
        return is_same_value(world.pins, old, slot);
      case BlockKind::gear:
        return is_same_value(world.gears, old, slot);
      case BlockKind::belt:
        return is_same_value(world.belts, old, slot);
      case BlockKind::cable:
      case BlockKind::elastic_cable:
        return is_same_value(world.cables, old, slot);
      case BlockKind::surface:
      case BlockKind::roll:
        return is_same_value(world.surface_contacts, old, slot);
      case BlockKind::joint:
      case BlockKind::limit:
      case BlockKind::drive:
      case BlockKind::spring:
      case BlockKind::joint_torque:
        break;
    }
    return is_same_value(world.links, old, slot);
  }
  bool operator()(const Block& a, const Block& b) const {
    return a.kind == b.kind && a.coordinate == b.coordinate && a.second == b.second &&
           a.upper == b.upper && a.lock == b.lock && a.holonomic == b.holonomic &&
           a.rows == b.rows && a.count == b.count &&
           std::equal(a.body, a.body + kMostBlockBodies, b.body) &&
           std::equal(a.ends, a.ends + 4, b.ends) &&
           (a.kind != BlockKind::belt || a.first_place == b.first_place) &&
           is_same_source(a.kind, a.source, b.source);
  }
  bool operator()(const Frame& a, const Frame& b) const {
    return is_same_value(world.bodies, a.slot, b.slot) && is_same_value(world.pins, a.pin, b.pin) &&
           is_same_value(world.cables, a.cable, b.cable) &&
           is_same_value(world.joint_drives, a.drive, b.drive);
  }
  bool operator()(const JointForce& a, const JointForce& b) const {
    return a.coordinate == b.coordinate && std::equal(a.body, a.body + 2, b.body) &&
           is_same_value(world.links, a.link, b.link);
  }
  template <class T>
  bool all(const std::vector<T>& a, const std::vector<T>& b) const {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), *this);
  }
  bool is_so() const {
    return was.bodies == now.bodies && was.rows == now.rows && all(was.blocks, now.blocks) &&
           all(was.frames, now.frames) && all(was.joint_forces, now.joint_forces);
  }
};

/// Carries over state that only steps change: revolution counts, faults found.
void carry_on(const World& world, Island& was, Island& m) {
  PANTIN_ASSERT(was.memory.size() == m.memory.size() &&
                was.mean_lambda.size() == m.mean_lambda.size());
  PANTIN_ASSERT(was.touches.size() == m.touches.size());
  m.touches = was.touches;
  m.memory = was.memory, m.mean_lambda = was.mean_lambda, m.forces = was.forces;
  m.fresh = was.fresh, m.loops = m.loops || was.loops;
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    if (m.memory[i].counted && m.blocks[i].kind == BlockKind::gear &&
        !world.gears.values()[m.blocks[i].source].has_offset)
      m.blocks[i].bound = was.blocks[i].bound;
  for (std::size_t i = 0; i < m.frames.size(); ++i) m.frames[i].begin(was.frames[i].start());
  for (std::size_t i = 0; i < m.joint_forces.size(); ++i)
    m.joint_forces[i].before = was.joint_forces[i].before;
  m.faults = was.faults, m.rank = was.rank, m.lost = was.lost, m.residual = was.residual;
  m.solves = was.solves, m.substeps = was.substeps, m.iterations = was.iterations;
  m.events = was.events, m.cannot_close = was.cannot_close;
  m.size = was.size, m.reach = was.reach;
  if (m.settings == was.settings) m.scratch = std::move(was.scratch);
}

/// Takes over the turns that joints have counted, by whatever solver. A limit takes a count within
/// its range only: it holds one revolution.
void take_turns(const World& world, Island& m) {
  const TurnCounts& counts = partition_of(world).turns;
  const auto count_of = [&](std::uint32_t link, Coordinate of) {
    return find_count(counts, world.links.owners()[link], of);
  };
  for (JointForce& e : m.joint_forces)
    if (const Real* value = count_of(e.link, e.coordinate)) e.before = *value;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    if (b.kind != BlockKind::spring && (b.kind != BlockKind::limit || b.lock)) continue;
    const Real* value = count_of(b.source, b.coordinate);
    if (!value) continue;
    const JointLimits& limits = *world.links.values()[b.source].joint.limits;
    const AngleLimit& range = b.coordinate == Coordinate::second ? limits.second : limits.angle;
    if (b.kind == BlockKind::limit && !(*value >= range.low && *value <= range.high)) continue;
    m.memory[i].before[0] = *value, m.memory[i].counted = true;
  }
}

}  // namespace

Meshes::Meshes(const World& world, const std::vector<Island>& before) {
  for (const Island& was : before)
    for (std::size_t i = 0; i < was.memory.size(); ++i) {
      const Block& b = was.blocks[i];
      if (!was.memory[i].counted) continue;
      if (b.kind == BlockKind::gear) add(b, world.gears.slot_now(b.source), was.memory[i]);
      if (b.kind == BlockKind::belt) add(b, world.belts.slot_now(b.source), was.memory[i]);
    }
  std::sort(all_.begin(), all_.end(), [](const Mesh& a, const Mesh& b) { return a.key < b.key; });
}

void Meshes::add(const Block& b, std::uint32_t now, const BlockMemory& memory) {
  if (now != kNoSlot) all_.push_back({{b.kind, now, b.first_place}, b.bound, memory});
}

void Meshes::carry(const World& world, Island& m) const {
  for (std::size_t i = 0; i < m.blocks.size() && !all_.empty(); ++i) {
    Block& b = m.blocks[i];
    const Key key{b.kind, b.source, b.first_place};
    const auto at = std::lower_bound(all_.begin(), all_.end(), key,
                                     [](const Mesh& x, const Key& k) { return x.key < k; });
    if (at == all_.end() || at->key != key) continue;
    m.memory[i] = at->memory;
    if (b.kind == BlockKind::gear && !world.gears.values()[b.source].has_offset)
      b.bound = at->bound;
  }
}

void carry_memory(const World& world, const Meshes& meshes, std::vector<Island>& before,
                  Island& m) {
  m.memory.assign(m.blocks.size(), {}), m.touches.assign(m.touch_sources.size() + m.slips, {});
  m.mean_lambda.assign(m.rows, 0), m.forces = m.mean_lambda;
  m.accelerations.assign(2 * m.count(), Vec3(0));
  m.lagged = m.known_forces = m.accelerations;
  if (row_of(m.settings.integrator).collocates)
    m.stage_accelerations.assign(6 * m.count(), Vec3(0));
  assert_packed(m);
  take_turns(world, m), meshes.carry(world, m);
  for (Island& was : before) {
    if (was.bodies != m.bodies) continue;
    m.accelerations = was.accelerations, m.lagged = was.lagged;
    m.known_forces = was.known_forces;
    if (m.stage_accelerations.size() == was.stage_accelerations.size())
      m.stage_accelerations = was.stage_accelerations, m.stage_step = was.stage_step;
    m.try_step = was.try_step, m.rescues = was.rescues;
    if (!Unchanged{world, was, m}.is_so()) continue;
    carry_on(world, was, m);
    return;
  }
}

}  // namespace pantin::detail::lagrangian
