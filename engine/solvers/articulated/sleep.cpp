// Sleep of islands at rest: falling asleep, and what wakes them.
#include <algorithm>
#include <cmath>
#include <functional>

#include "engine/contact/contact.hpp"
#include "engine/contact/detect.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/rebuild.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::articulated {
namespace {

/// Drift up to which a body counts as unmoved: the distance at the sleep speed in this time, s, or
/// this fraction of the island's size, whichever is less. Less than half of the island's mass may
/// sway this many times farther, in a pile of trees by more.
constexpr Real kRestDriftTime = 2.5, kRestDriftOfSize = 3e-3, kSwayFactor = 16, kSwayInPile = 48;
/// s: an island unmoved for so long is at rest. Creep shows as motion only after that time.
constexpr Real kTimeToRest = 1;
/// 1/s: rate at which slow_limbs() slows an island.
constexpr Real kSlowing = 6;

/// Whether the caller changed a sleeping body.
bool is_disturbed(const Body& b) {
  return b.restart || b.teleport || b.velocity != Vec3(0) || b.angular_velocity != Vec3(0);
}

void sort_once(std::vector<std::uint32_t>& islands) {
  std::sort(islands.begin(), islands.end());
  islands.erase(std::unique(islands.begin(), islands.end()), islands.end());
}

/// To be called when an island fell asleep or woke.
void note_rest(World& world, const Island& a) {
  Islands& all = world.memory.of<Islands>();
  const std::uint32_t island = owner_of(partition_of(world), a.slots.front()).island;
  PANTIN_ASSERT(&a == &all.list[island]);
  std::vector<std::uint32_t>& changed = all.rest.changed;
  if (changed.size() == changed.capacity()) sort_once(changed);
  changed.push_back(island);
  ++world.memory.of<Partition>().rest_version;
}

}  // namespace

namespace {

/// Whether the caller or a winch changed a cable, or moves the body it is fixed to.
bool is_changed(const World& world, const PackedCable& c) {
  const CableParameters& now = world.cables.values()[c.cable].joint;
  if (now.length != c.length_before || now.rate != c.rate_before) return true;
  const auto moves = [&](std::uint32_t column, std::uint32_t slot) {
    if (column != UINT32_MAX) return false;
    const Body& b = world.bodies.values()[slot];
    return contact::moves(b) || b.restart || b.teleport;
  };
  return moves(c.column_a, c.slot_a) || moves(c.column_b, c.slot_b);
}

}  // namespace

bool must_wake(const World& world, const Island& a) {
  if (world.gravity != a.asleep_gravity) return true;
  for (const PackedCable& c : a.cables)
    if (is_changed(world, c)) return true;
  for (const Tree& t : a.trees)
    if (t.target != t.target_before) return true;
  for (const PackedPin& h : a.pins)
    if (h.target != h.target_before) return true;
  return std::any_of(a.slots.begin(), a.slots.end(),
                     [&](std::uint32_t slot) { return is_disturbed(world.bodies.values()[slot]); });
}

namespace {

/// Wakes sleeping islands on which applied forces act.
void wake_pushed(World& world) {
  const Partition& partition = partition_of(world);
  for (std::size_t i = 0; i < world.forces.size(); ++i) {
    const Force& f = world.forces.values()[i];
    if (f.force == Vec3(0) && f.torque == Vec3(0)) continue;
    const std::uint32_t slot = world.bodies.slot(world.forces.owners()[i]);
    if (slot == kNoSlot || !is_own(world, slot)) continue;
    Island& a = islands_of(world)[owner_of(partition, slot).island];
    if (a.asleep) rouse(world, a);
  }
}

}  // namespace

namespace {

bool precedes(const RestLists::Sleeper& a, const RestLists::Sleeper& b) {
  return a.island < b.island;
}

/// Lists an island; the lists are put in order later.
void list_island(const World& world, Islands& all, std::uint32_t i) {
  RestLists& r = all.rest;
  Island& a = all.list[i];
  if (!a.asleep) return r.awake.push_back(i);
  const bool is_alone = a.count() == 1 && a.parents[0] == kFree && !is_tied(a) && !a.unfit;
  r.sleepers.push_back({i, is_alone ? a.slots[0] : kNoSlot});
  a.in_group = false, a.scratch.contact_rows.clear();
  if (a.asleep_gravity != world.gravity) r.gravity = a.asleep_gravity;
}

/// Puts the values from the `first` on into the ascending ones before them. Both are ascending;
/// `aside` has room for the latter. Allocates nothing.
template <class T, class Precedes>
void merge_from(std::vector<T>& list, std::ptrdiff_t first, std::vector<T>& aside,
                const Precedes& before) {
  aside.assign(list.begin() + first, list.end());
  auto to = list.end();
  for (auto kept = list.begin() + first; !aside.empty(); aside.pop_back()) {
    for (; kept != list.begin() && before(aside.back(), kept[-1]); --kept) *--to = kept[-1];
    *--to = aside.back();
  }
}

/// Room for all islands, so that no step needs more.
void reserve(RestLists& r, std::size_t islands) {
  r.changed.reserve(2 * islands);
  r.awake.reserve(islands), r.sleepers.reserve(islands);
  r.more_awake.reserve(islands), r.more_sleepers.reserve(islands);
}

/// Lists `more` islands, which are ascending and in no list.
void list_islands(const World& world, Islands& all, std::span<const std::uint32_t> more) {
  RestLists& r = all.rest;
  const auto awake = std::ptrdiff_t(r.awake.size()), sleepers = std::ptrdiff_t(r.sleepers.size());
  for (const std::uint32_t i : more) list_island(world, all, i);
  merge_from(r.awake, awake, r.more_awake, std::less<>());
  merge_from(r.sleepers, sleepers, r.more_sleepers, precedes);
}

/// Lists all islands.
void list_all(const World& world, Islands& all) {
  RestLists& r = all.rest;
  r.gravity = world.gravity;
  reserve(r, all.list.size());
  r.awake.clear(), r.sleepers.clear();
  for (std::uint32_t i = 0; i < all.list.size(); ++i) list_island(world, all, i);
}

}  // namespace

RestLists& rest_lists(World& world) {
  Islands& all = world.memory.of<Islands>();
  RestLists& r = all.rest;
  const std::uint64_t version = partition_of(world).rest_version;
  if (r.version == version) return r;
  for (const std::uint32_t i : r.touched) all.list[i].scratch.contact_rows.clear();
  if (r.version == 0 || r.gravity != world.gravity) {
    list_all(world, all);
  } else {
    sort_once(r.changed);
    const auto has_changed = [&](std::uint32_t i) {
      return std::binary_search(r.changed.begin(), r.changed.end(), i);
    };
    std::erase_if(r.awake, has_changed);
    std::erase_if(r.sleepers, [&](const auto& s) { return has_changed(s.island); });
    list_islands(world, all, r.changed);
  }
  r.version = version;
  r.changed.clear(), r.touched.clear();
  return r;
}

void renumber_rests(World& world, const Rebuild& rebuild) {
  Islands& all = world.memory.of<Islands>();
  RestLists& r = all.rest;
  if (r.version == 0) return;
  reserve(r, all.list.size());
  const auto renumber = [&](std::vector<std::uint32_t>& islands) {
    for (std::uint32_t& i : islands) i = rebuild.now[i];
    std::erase(islands, Rebuild::kGone);
  };
  renumber(r.awake), renumber(r.changed), renumber(r.touched);
  for (RestLists::Sleeper& s : r.sleepers) {
    s.island = rebuild.now[s.island];
    if (s.slot != kNoSlot) s.slot = world.bodies.slot_now(s.slot);
  }
  std::erase_if(r.sleepers, [](const auto& s) { return s.island == Rebuild::kGone; });
  list_islands(world, all, rebuild.places);
}

namespace {

/// Wakes what lies on sleeping bodies that the caller moved.
void wake_neighbours(World& world) {
  each_contact(world, [&](const Contact& c) {
    for (const auto& [slot, other] :
         {std::pair(c.slot_a, c.slot_b), std::pair(c.slot_b, c.slot_a)}) {
      if (!is_own(world, slot) || !is_own(world, other)) continue;
      const Body& moved = world.bodies.values()[other];
      Island& a = islands_of(world)[owner_of(partition_of(world), slot).island];
      if ((moved.restart || moved.teleport) && a.asleep) rouse(world, a);
    }
  });
}

}  // namespace

void wake_changed(World& world, const StepTask& task) {
  RestLists& r = rest_lists(world);
  const bool is_still = world.gravity == r.gravity;
  bool any = false;
  for (const RestLists::Sleeper& s : r.sleepers) {
    if (s.slot != kNoSlot && is_still) {
      if (!is_disturbed(world.bodies.values()[s.slot])) continue;
    } else {
      Island& a = islands_of(world)[s.island];
      set_targets(world, a, task.h);
      if (!a.unfit && !find_unsound(world, a) && !must_wake(world, a)) continue;
    }
    rouse(world, islands_of(world)[s.island]);
    any = true;
  }
  if (any) wake_neighbours(world);
  if (!world.forces.empty() && !r.sleepers.empty()) wake_pushed(world);
  rest_lists(world);
}

void stir(Island& a) {
  a.asleep = a.rested = false;
  a.quiet_time = a.rest_time = 0;
}

void rouse(World& world, Island& a) {
  stir(a);
  note_rest(world, a);
}

void wake(World& world, Island& a, Real h) {
  rouse(world, a);
  std::vector<std::uint32_t>& awake = world.memory.of<Partition>().awake;
  awake.insert(awake.end(), a.slots.begin(), a.slots.begin() + std::ptrdiff_t(a.count()));
  a.step = h;
  update(world, a, h);
}

void predict_still(const World& world, Island& a) {
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Pose& pose = world.bodies.values()[a.slots[c]].pose;
    a.scratch.work.set(kPosition, c, pose.position),
        a.scratch.work.set(kRotation, c, pose.rotation);
  }
}

bool has_rested(const World& world, Island& a, Real h, Limbs limbs) {
  if (a.rests.empty()) return false;
  PANTIN_ASSERT(a.rests.size() == a.count());
  Real near = kRestDriftTime * a.settings.sleep_speed;
  if (a.size > 0) near = std::min(near, kRestDriftOfSize * a.size);
  Real moved = 0, whole = 0, farthest = 0, fastest = 0;
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    const Quat turn = b.pose.rotation * glm::conjugate(a.rests[c].rotation);
    const Real angle = 2 * glm::length(Vec3(turn.x, turn.y, turn.z));
    const Real by = std::max(glm::length(b.pose.position - a.rests[c].position), angle / kTurning);
    farthest = std::max(farthest, by);
    fastest =
        std::max({fastest, glm::length(b.velocity), glm::length(b.angular_velocity) / kTurning});
    whole += b.mass;
    if (!(by < near)) moved += b.mass;
  }
  a.rest_time += h;
  const Real sway = limbs == Limbs::sway ? kSwayInPile : kSwayFactor;
  if (!(farthest < sway * near) || !(2 * moved < whole)) {
    a.rested = a.contact_active && a.rest_time > kTimeToRest;
    a.rest_time = 0;
    for (std::size_t c = 0; c < a.count(); ++c) a.rests[c] = world.bodies.values()[a.slots[c]].pose;
  }
  return a.contact_active && near > 0 && fastest * kTimeToSleep < kSwayFactor * near &&
         (a.rested || a.rest_time > kTimeToRest);
}

void slow_limbs(World& world, const Island& a, Real h) {
  if (!a.contact_active || !(a.rest_time > kTimeToRest)) return;
  const Real kept = std::exp(-kSlowing * h);
  for (std::size_t c = 0; c < a.count(); ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    b.velocity *= kept, b.angular_velocity *= kept;
  }
}

void fall_asleep(World& world, Island& a) {
  PANTIN_ASSERT(!a.asleep);
  a.asleep = true;
  a.asleep_gravity = world.gravity;
  a.sweeps_used = 0, a.limited = false;
  note_rest(world, a);
  for (std::uint32_t c = 0; c < a.count(); ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    b.velocity = b.angular_velocity = Vec3(0);
    a.memory.set(kLastTranslation, c, Vec3(0)), a.memory.set(kLastRotation, c, Vec3(0));
  }
}

}  // namespace pantin::detail::articulated
