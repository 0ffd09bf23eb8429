#pragma once
/// The islands of one solver.
#include <vector>

#include "engine/world/memory.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {

/// All islands of a solver.
template <class Island, class List = std::vector<Island>>
struct IslandList {
  struct ListScratch {
    std::size_t prepared = 0;  // number of islands with scratch memory; 0 in a copy
  };

  List list;
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

}  // namespace pantin::detail
