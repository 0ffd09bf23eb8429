#pragma once
/// Contacts between bodies at rest: no step looks at them until one of the two rests no longer.
#include <algorithm>
#include <iterator>

#include "engine/contact/memory.hpp"
#include "engine/contact/on_the_way.hpp"

namespace pantin::detail::contact {

/// Moves contacts of two bodies at rest from DetectScratch::before to Memory::resting, where they
/// bear what they bore last, and those of bodies that rest no longer back.
void part_resting(const WayFinder& finder, Memory& memory);

/// Brings DetectScratch::resting_active and resting_depth up to date.
void sum_up_resting(Memory& memory);

/// Moves those contacts of Memory::resting that `wakes(contact)` names to Memory::contacts.
template <class Wakes>
void release_resting(Memory& memory, const Wakes& wakes) {
  DetectScratch& scratch = memory.scratch;
  std::vector<Contact>&awake = scratch.all, &left = scratch.before;
  awake.clear(), left.clear();
  for (const Contact& c : memory.resting) (wakes(c) ? awake : left).push_back(c);
  memory.resting.swap(left), left.clear();
  std::merge(memory.contacts.begin(), memory.contacts.end(), awake.begin(), awake.end(),
             std::back_inserter(left), are_ordered);
  memory.contacts.swap(left);
  scratch.rest_version = 0;
  sum_up_resting(memory);
}

/// Whether who collides with whom has changed since the last call.
bool note_collisions(World& world);

}  // namespace pantin::detail::contact
