// Builds: the whole list of islands, or the islands that a change of structure concerns.
#include <algorithm>
#include <iterator>

#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/rebuild.hpp"

namespace pantin::detail::articulated {
namespace {

/// Spare places of the list after a whole build, as a fraction of it: without them the next island
/// that is added would move all others.
constexpr std::size_t kSparePart = 4;

void append(std::vector<Island>& to, std::vector<Island>&& from) {
  to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
}

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
void merge(std::vector<Island>& list, std::vector<Island>&& made,
           std::span<const std::uint32_t> places, std::size_t fixed) {
  std::vector<Island> later(std::make_move_iterator(list.begin() + std::ptrdiff_t(fixed)),
                            std::make_move_iterator(list.end()));
  list.erase(list.begin() + std::ptrdiff_t(fixed), list.end());
  auto kept = later.begin();
  for (std::size_t i = 0; i < made.size(); ++i) {
    for (; list.size() < places[i]; ++kept) list.push_back(std::move(*kept));
    list.push_back(std::move(made[i]));
  }
  for (; kept != later.end(); ++kept) list.push_back(std::move(*kept));
}

}  // namespace

void compile(World& world, std::span<const IslandPlan> plans) {
  Islands& all = world.memory.of<Islands>();
  const std::size_t kept = keep_first(world, plans, all.list);
  std::vector<Island> made = pack_islands(world, Scope::all(world), plans.subspan(kept));
  const auto first = all.list.begin() + std::ptrdiff_t(kept);
  std::vector<Island> before(std::make_move_iterator(first),
                             std::make_move_iterator(all.list.end()));
  all.list.erase(first, all.list.end());
  carry_over(world, before, made);
  for (const Island& a : made) assert_packed(a);
  if (all.list.capacity() < plans.size())
    all.list.reserve(plans.size() + plans.size() / kSparePart);
  append(all.list, std::move(made));
  all.scratch.prepared = std::min(all.scratch.prepared, kept), all.crowd.is_known = false;
  all.rest = {};
}

void recompile(World& world, const Rebuild& rebuild) {
  Islands& all = world.memory.of<Islands>();
  std::size_t fixed = 0;  // the first islands keep their numbers
  while (fixed < rebuild.now.size() && rebuild.now[fixed] == fixed) ++fixed;
  std::vector<Island> made = pack_islands(world, rebuild.scope, rebuild.plans), before;
  std::size_t left = fixed;
  for (std::size_t i = fixed; i < all.list.size(); ++i) {
    if (rebuild.now[i] == Rebuild::kGone)
      before.push_back(std::move(all.list[i]));
    else if (left++ < i)
      all.list[left - 1] = std::move(all.list[i]);
  }
  const bool is_prepared = all.scratch.prepared == all.list.size();
  all.list.erase(all.list.begin() + std::ptrdiff_t(left), all.list.end());
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
