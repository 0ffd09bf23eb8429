#include "engine/runtime/coupling.hpp"

#include <algorithm>

#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/solvers/procedural/procedural.hpp"

namespace pantin {
namespace {

constexpr int kMostRounds = 24;
constexpr Real kEnough = 1e-6;

void save_bodies(const World& world, std::span<const std::uint32_t> slots, std::size_t count,
                 std::vector<Body>& to) {
  to.clear();
  for (std::size_t i = 0; i < count; ++i) to.push_back(world.bodies.values()[slots[i]]);
}

void restore_bodies(World& world, std::span<const std::uint32_t> slots,
                    const std::vector<Body>& from) {
  for (std::size_t i = 0; i < from.size(); ++i) world.bodies.values()[slots[i]] = from[i];
}

/// What a step of an articulation starts from: the same that its fingerprint is made of.
void copy_memory(const Articulation& from, Articulation& to) {
  to.memory = from.memory, to.trees = from.trees, to.holds = from.holds, to.cords = from.cords;
  to.joints.resize(from.joints.size());
  for (std::size_t i = 0; i < from.joints.size(); ++i) {
    std::copy(std::begin(from.joints[i].loads), std::end(from.joints[i].loads),
              std::begin(to.joints[i].loads));
    to.joints[i].share = from.joints[i].share;
  }
  to.calm_steps = from.calm_steps, to.iterating = from.iterating, to.still_for = from.still_for;
  to.resting = from.resting, to.resting_in = from.resting_in, to.fresh = from.fresh;
  to.last_step = from.last_step, to.reserve = from.reserve;
  to.aimed = from.aimed, to.driven = from.driven;
  to.second_order = from.second_order, to.disturbed = from.disturbed;
}

void copy_memory(const Mechanism& from, Mechanism& to) {
  to.memory = from.memory, to.loads = from.loads, to.owed = from.owed, to.frames = from.frames;
  to.accelerations = from.accelerations, to.lagged = from.lagged, to.efforts = from.efforts;
  to.fresh = from.fresh, to.try_step = from.try_step, to.rescues = from.rescues;
}

/// Whether a mechanism that takes part in the step holds any part of the articulation.
bool hangs(const World& world, const Articulation& a) {
  const auto is_moving = [&](std::uint32_t slot) {
    return world.is_exact(slot) && is_coupled(world.mechanisms[world.exact[slot].mechanism]);
  };
  const auto exact_pin = [&](std::uint32_t pin) {
    if (pin == UINT32_MAX) return false;
    const Pin& p = world.pins.values()[pin];
    return is_moving(world.bodies.slot(p.body)) || (p.to && is_moving(world.bodies.slot(p.to)));
  };
  for (const Tree& t : a.trees)
    if (exact_pin(t.held_pin)) return true;
  for (const Hold& h : a.holds)
    if (exact_pin(h.held_pin)) return true;
  for (const Cord& c : a.cords)
    if (is_moving(c.slot_a) || is_moving(c.slot_b)) return true;
  return false;
}

/// Whether the articulation hangs there.
bool holds(const Articulation& a, const Hanging& g) {
  const bool pin = g.kind == BlockKind::pin;
  if (pin && std::any_of(a.trees.begin(), a.trees.end(),
                         [&](const Tree& t) { return t.held_pin == g.source; }))
    return true;
  if (pin)
    return std::any_of(a.holds.begin(), a.holds.end(),
                       [&](const Hold& h) { return h.held_pin == g.source; });
  return std::any_of(a.cords.begin(), a.cords.end(),
                     [&](const Cord& c) { return c.string == g.source; });
}

template <class Work>
void each_articulation(World& world, const Work& work) {
  CouplingRoom& room = world.coupling;
  for (std::size_t i = 0; i < world.articulations.size(); ++i)
    if (room.hanging[i]) work(world.articulations[i], room.articulations[i], room.bodies[i]);
}

template <class Work>
void each_mechanism(World& world, const Work& work) {
  CouplingRoom& room = world.coupling;
  for (std::size_t i = 0; i < world.mechanisms.size(); ++i)
    if (is_coupled(world.mechanisms[i]))
      work(world.mechanisms[i], room.mechanisms[i], room.bodies[world.articulations.size() + i]);
}

/// What its contacts bore and are to give back, as it was when they were found.
void restore_contacts(World& world, const Articulation& a) {
  for (const Touch& t : a.room.touches) world.contacts[t.contact] = world.coupling.contacts[t.contact];
}

/// What each pull still lacks; true if all are met. Sets the pace of the next round.
bool find_lacks(World& world, Real h, bool first) {
  bool settled = true;
  each_mechanism(world, [&](Mechanism& m, Mechanism&, std::vector<Body>&) {
    for (Hanging& g : m.hangings) {
      const Vec3 lack = h * g.force + g.debt - g.given;
      const Real bound = kEnough * h * (glm::length(g.force) + 1e-3 * g.mass);
      settled = settled && glm::length(lack) <= bound;
      const Vec3 change = lack - g.lack;  // [Aitken 1926], a vector at a time
      const Real size = glm::dot(change, change);
      if (!first && size > 0)
        g.relax = std::clamp(-g.relax * glm::dot(g.lack, change) / size, 0.1, 3.0);
      g.lack = lack;
    }
  });
  return settled;
}

}  // namespace

void begin_coupled(World& world) {
  CouplingRoom& room = world.coupling;
  const bool any = std::any_of(world.mechanisms.begin(), world.mechanisms.end(), is_coupled);
  room.hanging.assign(any ? world.articulations.size() : 0, 0);
  if (!any) return;
  room.articulations.resize(world.articulations.size());
  room.mechanisms.resize(world.mechanisms.size());
  room.bodies.resize(world.articulations.size() + world.mechanisms.size());
  for (std::size_t i = 0; i < world.articulations.size(); ++i)
    room.hanging[i] = hangs(world, world.articulations[i]);
  each_articulation(world, [&](Articulation& a, Articulation& kept, std::vector<Body>& bodies) {
    copy_memory(a, kept), save_bodies(world, a.slots, a.count(), bodies);
  });
  each_mechanism(world, [&](Mechanism& m, Mechanism& kept, std::vector<Body>& bodies) {
    copy_memory(m, kept);
    save_bodies(world, m.slots, m.count() - m.hangings.size(), bodies);
    for (Hanging& g : m.hangings) g.relax = 1, g.lack = Vec3(0), g.taut = g.force != Vec3(0);
  });
}

void renumber_coupled(World& world) {
  CouplingRoom old = std::move(static_cast<CouplingRoom&>(world.coupling));
  CouplingRoom& room = world.coupling;
  static_cast<CouplingRoom&>(room) = CouplingRoom();
  const std::size_t before = old.articulations.size(), count = world.articulations.size();
  if (std::none_of(world.mechanisms.begin(), world.mechanisms.end(), is_coupled)) return;
  room.hanging.assign(count, 0);
  room.articulations.resize(count), room.mechanisms.resize(world.mechanisms.size());
  room.bodies.resize(count + world.mechanisms.size());
  for (std::size_t i = 0; i < count; ++i) {
    Articulation& a = world.articulations[i];
    room.hanging[i] = hangs(world, a);
    if (!room.hanging[i]) continue;
    if (a.was < before && old.hanging[a.was]) {
      room.articulations[i] = std::move(old.articulations[a.was]);
      copy_slots(a, room.articulations[i]);
      room.bodies[i] = std::move(old.bodies[a.was]);
    } else {
      copy_memory(a, room.articulations[i]), save_bodies(world, a.slots, a.count(), room.bodies[i]);
    }
  }
  for (std::size_t i = 0; i < world.mechanisms.size(); ++i) {
    const Mechanism& m = world.mechanisms[i];
    if (!is_coupled(m)) continue;  // so it was packed before the step
    room.mechanisms[i] = std::move(old.mechanisms[m.was]);
    for (std::size_t f = 0; f < m.frames.size(); ++f) {
      MechanismFrame& kept = room.mechanisms[i].frames[f];
      kept.slot = m.frames[f].slot, kept.pin = m.frames[f].pin;
    }
    room.bodies[count + i] = std::move(old.bodies[before + m.was]);
  }
}

void step_coupled(World& world, Real h) {
  if (world.coupling.hanging.empty()) return;
  world.coupling.contacts = world.contacts;
  for (int round = 0;; ++round) {
    bool failed = false;
    each_mechanism(world, [&](Mechanism& m, Mechanism& kept, std::vector<Body>& bodies) {
      copy_memory(kept, m), restore_bodies(world, m.slots, bodies);
      lagrangian::step(world, m, h);
      failed = failed || m.lost;
    });
    each_articulation(world, [&](Articulation& a, Articulation& kept, std::vector<Body>& bodies) {
      if (a.mutual) return;
      copy_memory(kept, a), restore_bodies(world, a.slots, bodies);
      restore_contacts(world, a);
      procedural::update(world, a, h);
      a.lost = Entity{};
      procedural::adjust(world, a, h, a.lost);
      procedural::tell_pulls(world, a, h);
    });
    const bool last = find_lacks(world, h, round == 0) || failed || round + 1 == kMostRounds;
    each_mechanism(world, [&](Mechanism& m, Mechanism&, std::vector<Body>&) {
      m.rounds = round + 1;
      for (Hanging& g : m.hangings) {
        g.taut = g.taut || g.force != Vec3(0);
        if (last) g.debt = g.lack;
        else g.asked += g.relax * g.lack;
      }
    });
    if (last) return;
  }
}

void settle_mutual(World& world, Real h) {
  if (world.coupling.hanging.empty()) return;
  each_articulation(world, [&](Articulation& a, Articulation&, std::vector<Body>&) {
    if (!a.mutual) return;
    procedural::tell_pulls(world, a, h);
    for (Mechanism& m : world.mechanisms)
      for (Hanging& g : m.hangings) {
        if (!holds(a, g)) continue;
        const Vec3 lack = h * g.force - g.given;
        g.asked += lack - g.debt, g.debt = lack;
      }
  });
}

}  // namespace pantin
