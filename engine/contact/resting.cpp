#include "engine/contact/resting.hpp"

#include <algorithm>

#include "engine/base/invariants.hpp"

namespace pantin::detail::contact {
namespace {

/// Whether each body that no solver moves rests or moves as at the last call.
bool note_obstacles(const SweptSearch& s, DetectScratch& scratch) {
  const std::vector<std::uint32_t>& slots = s.partition.kinematic;
  bool same = scratch.still.size() == slots.size();
  scratch.still.resize(slots.size());
  for (std::size_t i = 0; i < slots.size(); ++i) {
    const std::uint8_t still = s.rests(slots[i]);
    same = same && scratch.still[i] == still;
    scratch.still[i] = still;
  }
  return same;
}

}  // namespace

void sum_up_resting(Memory& memory) {
  DetectScratch& scratch = memory.scratch;
  scratch.resting_active = 0, scratch.resting_depth = 0;
  for (const Contact& c : memory.resting) {
    scratch.resting_active += c.active;
    scratch.resting_depth = std::max(scratch.resting_depth, c.depth);
  }
}

void merge_into(std::vector<Contact>& to, const std::vector<Contact>& from) {
  std::size_t left = to.size(), add = from.size();
  to.resize(left + add);
  while (add > 0) {
    Contact& place = to[left + add - 1];
    if (left > 0 && precedes(from[add - 1], to[left - 1]))
      place = to[--left];
    else
      place = from[--add];
  }
  PANTIN_ASSERT(std::is_sorted(to.begin(), to.end(), precedes));
}

void split_resting(const SweptSearch& s, Memory& memory) {
  DetectScratch& scratch = memory.scratch;
  const bool same = note_obstacles(s, scratch);
  const bool is_step = s.h > 0;  // otherwise the caller's reach says which bodies rest
  if (same && is_step && s.keeps && scratch.rest_version == s.partition.rest_version) return;
  scratch.rest_version = s.keeps ? s.partition.rest_version : 0;
  const auto rests = [&](const Contact& c) {
    return s.keeps && s.is_moved(c.slot_a) && s.rests(c.slot_a) && s.rests(c.slot_b);
  };
  const auto wakes = [&](const Contact& c) { return !rests(c); };
  move_those(memory.resting, scratch.woken, wakes);
  move_those(scratch.before, scratch.fallen, rests);
  for (Contact& c : scratch.fallen) {
    if (!is_step) break;
    c.active = glm::dot(c.lambda, c.normal) > 0;
    c.depth = std::max(Real(0), -c.gap);
  }
  merge_into(scratch.before, scratch.woken), merge_into(memory.resting, scratch.fallen);
  sum_up_resting(memory);
}

void renumber_filters(const World& world, std::vector<CollisionFilter>& filters) {
  if (!world.collisions.has_moved()) return;
  std::vector<CollisionFilter> now(world.collisions.size());
  for (std::uint32_t then = 0; then < filters.size(); ++then)
    if (const std::uint32_t slot = world.collisions.slot_now(then); slot != kNoSlot)
      now[slot] = filters[then];
  filters = std::move(now);
}

bool note_collisions(World& world) {
  std::vector<CollisionFilter>& before = world.memory.of<Memory>().scratch.filters;
  const auto collisions = world.collisions.values();
  bool same = true;
  before.resize(collisions.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const Collision& c = collisions[i];
    const CollisionFilter now{c.groups, c.with, c.sensor, true};
    same = same && (!before[i].is_known || before[i] == now);
    before[i] = now;
  }
  return !same;
}

}  // namespace pantin::detail::contact
