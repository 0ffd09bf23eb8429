#pragma once
/// The islands of one solver, and repeated steps of an island.
#include <vector>

#include "engine/world/memory.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {

/// All islands of a solver. An island derives from `Memory`, its state; the first own() of its
/// slots are those of its bodies.
template <class Island, class Memory>
struct IslandList {
  /// Initial state of a step that is repeated.
  struct Saved {
    Memory memory;
    std::vector<Body> bodies;
  };
  struct ListScratch {
    bool prepared = false;     // every island has its scratch memory
    std::vector<Saved> saved;  // by island
  };

  std::vector<Island> list;
  Scratch<ListScratch> scratch;

  static void fields(auto& self, auto&& field) {
    field("list", in_place(self.list));
    field("scratch", derived(self.scratch));
  }
};

/// Whether a slot of the last build and one of this build refer to the same value, or both to none.
template <class T>
bool is_same_value(const Store<T>& store, std::uint32_t old, std::uint32_t now) {
  if (old == kNoSlot || now == kNoSlot) return old == now;
  return store.slot_now(old) == now;
}

/// Saves the state of an island and of its bodies.
template <class Islands>
void save_island(World& world, std::size_t island) {
  Islands& all = world.memory.of<Islands>();
  all.scratch.saved.resize(all.list.size());
  const auto& a = all.list[island];
  typename Islands::Saved& saved = all.scratch.saved[island];
  saved.memory = a;
  saved.bodies.clear();
  for (std::size_t c = 0; c < a.own(); ++c)
    saved.bodies.push_back(world.bodies.values()[a.slots[c]]);
}

/// Puts the saved state back; returns the island.
template <class Islands>
auto& restore_island(World& world, std::size_t island) {
  Islands& all = world.memory.of<Islands>();
  all.scratch.saved.resize(all.list.size());
  auto& a = all.list[island];
  const typename Islands::Saved& saved = all.scratch.saved[island];
  static_cast<decltype(Islands::Saved::memory)&>(a) = saved.memory;
  for (std::size_t c = 0; c < a.own(); ++c) world.bodies.values()[a.slots[c]] = saved.bodies[c];
  return a;
}

}  // namespace pantin::detail
