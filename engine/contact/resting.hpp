#pragma once
/// Contacts between bodies at rest: no step looks at them until one of the two rests no longer.
#include "engine/contact/memory.hpp"
#include "engine/contact/on_the_way.hpp"

namespace pantin::detail::contact {

/// How often shapes and Collisions took the place of others: what sleeps is looked at again then.
inline std::uint64_t replacements(const World& world) {
  return world.shapes.replaced() + world.collisions.replaced();
}

/// Moves contacts of two bodies at rest from DetectScratch::before to Memory::resting, where they
/// bear what they bore last, and those of bodies that rest no longer back.
void part_resting(const WayFinder& finder, Memory& memory);

/// Brings DetectScratch::resting_active and resting_depth up to date.
void sum_up_resting(Memory& memory);

/// Moves the contacts that `leaves(contact)` names from one list to the other, in order; what that
/// held is gone.
template <class Leaves>
void move_those(std::vector<Contact>& from, std::vector<Contact>& to, const Leaves& leaves) {
  to.clear();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (leaves(from[i]))
      to.push_back(from[i]);
    else if (kept++ < i)
      from[kept - 1] = from[i];
  }
  from.resize(kept);
}
/// Puts contacts into a list in order.
void merge_into(std::vector<Contact>& to, const std::vector<Contact>& from);

/// Moves those contacts of Memory::resting that `wakes(contact)` names to Memory::contacts.
template <class Wakes>
void release_resting(Memory& memory, const Wakes& wakes) {
  move_those(memory.resting, memory.scratch.woken, wakes);
  merge_into(memory.contacts, memory.scratch.woken);
  memory.scratch.rest_version = 0;
  sum_up_resting(memory);
}

/// Whether who collides with whom has changed since the last call.
bool note_collisions(World& world);

}  // namespace pantin::detail::contact
