#pragma once
/// Contacts between bodies at rest: unchanged until one of the two bodies moves or wakes.
#include "engine/contact/memory.hpp"
#include "engine/contact/on_the_way.hpp"

namespace pantin::detail::contact {

/// How often Shapes and Collisions were replaced: contacts of sleeping bodies are detected again
/// then.
inline std::uint64_t replacements(const World& world) {
  return world.shapes.replaced() + world.collisions.replaced();
}

/// Moves contacts of two bodies at rest from DetectScratch::before to Memory::resting, where they
/// keep their last impulse, and moves contacts of bodies no longer at rest back.
void split_resting(const SweptSearch& finder, Memory& memory);

/// Updates DetectScratch::resting_active and resting_depth.
void sum_up_resting(Memory& memory);

/// Moves the contacts for which `leaves(contact)` is true from one list to the other, in order. The
/// previous content of `to` is lost.
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
/// Merges sorted contacts into a sorted list.
void merge_into(std::vector<Contact>& to, const std::vector<Contact>& from);

/// Moves the contacts of Memory::resting for which `wakes(contact)` is true to Memory::contacts.
template <class Wakes>
void release_resting(Memory& memory, const Wakes& wakes) {
  move_those(memory.resting, memory.scratch.woken, wakes);
  merge_into(memory.contacts, memory.scratch.woken);
  memory.scratch.rest_version = 0;
  sum_up_resting(memory);
}

/// After a build in which bodies have moved to other slots or are gone: renumbers the colliders at
/// rest (colliders.cpp).
void renumber_resting(const World& world, RestingColliders& resting);

/// Sets the current shape of a collider at rest. False if its body rests no longer, or has lost the
/// shape or its Collision (colliders.cpp).
bool look_up(const World& world, const RestingColliders& resting, ColliderShape& at);

/// Calls `take(shape)` for each collider at rest that is near a box.
template <class Take>
void each_resting(const World& world, const RestingColliders& resting, const Aabb& near,
                  const Take& take) {
  const auto give = [&](ColliderShape at) {
    if (look_up(world, resting, at)) take(at);
  };
  for (const ColliderShape& at : resting.obstacles.unbounded) give(at);
  resting.obstacles.tree.query(near, [&](std::uint32_t i) { give(resting.obstacles.shapes[i]); });
}

/// After such a build: renumbers the filters that the next function compares.
void renumber_filters(const World& world, std::vector<CollisionFilter>& filters);

/// Whether any CollisionFilter has changed since the last call. Those that came since have not.
bool note_collisions(World& world);

}  // namespace pantin::detail::contact
