// Builds: the whole list of islands, or the islands that a change of structure concerns.
#include <algorithm>

#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/rebuild.hpp"

namespace pantin::detail::articulated {
namespace {

/// Brings the slots of an unchanged island up to date.
void renumber(const World& world, Island& a) {
  for (std::uint32_t& slot : a.slots) slot = world.bodies.slot_now(slot);
  for (std::uint32_t& link : a.links) link = world.links.slot_now(link);
  for (PackedJoint& j : a.joints) j.drive = world.joint_drives.slot_now(j.drive);
  const auto renumber_anchor = [&](auto& held) {
    held.held_body = world.bodies.slot_now(held.held_body);
    held.held_pin = world.pins.slot_now(held.held_pin);
  };
  for (Tree& t : a.trees) renumber_anchor(t);
  for (PackedPin& p : a.pins) renumber_anchor(p), p.held_link = world.links.slot_now(p.held_link);
  for (PackedCable& c : a.cables) {
    c.cable = world.cables.slot_now(c.cable);
    c.slot_a = world.bodies.slot_now(c.slot_a), c.slot_b = world.bodies.slot_now(c.slot_b);
  }
}

/// Puts islands in the places that a rebuild gives them. The first `fixed` of the list stay.
void merge(IslandVector& list, IslandVector&& made, std::span<const std::uint32_t> places,
           std::size_t fixed) {
  if (made.empty()) return;
  IslandVector later;
  later.append_from(list, fixed);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < made.size(); ++i) {
    while (list.size() < places[i]) later.give(kept++, list);
    made.give(i, list);
  }
  while (kept < later.size()) later.give(kept++, list);
}

}  // namespace

void compile(World& world, std::span<const IslandPlan> plans) {
  Islands& all = world.memory.of<Islands>();
  const std::size_t kept = keep_first(world, plans, all.list);
  IslandVector made = pack_islands(world, Scope::all(world), plans.subspan(kept)), before;
  before.append_from(all.list, kept);
  carry_over(world, before, made);
  for (const Island& a : made) assert_packed(a);
  all.list.append_from(made, 0);
  all.scratch.prepared = std::min(all.scratch.prepared, kept), all.crowd.is_known = false;
  all.rest = {};
}

void recompile(World& world, const Rebuild& rebuild) {
  Islands& all = world.memory.of<Islands>();
  std::size_t fixed = 0;  // the first islands keep their numbers
  while (fixed < rebuild.now.size() && rebuild.now[fixed] == fixed) ++fixed;
  IslandVector made = pack_islands(world, rebuild.scope, rebuild.plans), before, later;
  const bool is_prepared = all.scratch.prepared == all.list.size();
  later.append_from(all.list, fixed);
  for (std::size_t i = 0; i < later.size(); ++i)
    later.give(i, rebuild.now[fixed + i] == Rebuild::kGone ? before : all.list);
  const auto sleeps = [](const Island& a) { return a.asleep; };
  const bool wakes = !made.empty() && std::any_of(before.begin(), before.end(), sleeps);
  if (!made.empty()) carry_over(world, before, made);
  for (const Island& a : made) assert_packed(a);
  merge(all.list, std::move(made), rebuild.places, fixed);
  for (const std::uint32_t i : rebuild.moved) renumber(world, all.list[i]);
  if (is_prepared)
    for (const std::uint32_t i : rebuild.places) prepare(world, all.list[i]);
  all.scratch.prepared = is_prepared ? all.list.size() : 0;
  renumber_rests(world, rebuild), renumber_crowds(all, rebuild);
  if (wakes) ++world.memory.of<Partition>().rest_version;
}

}  // namespace pantin::detail::articulated
