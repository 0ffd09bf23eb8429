// Faults of a World: see check().
#include "engine/solvers/check.hpp"

#include <algorithm>
#include <optional>

#include "engine/base/invariants.hpp"
#include "engine/geometry/usable.hpp"
#include "engine/joints/joint_force.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/world/features.hpp"
#include "engine/world/flat.hpp"
#include "engine/world/holds.hpp"
#include "engine/world/lamina.hpp"
#include "engine/world/special_surface.hpp"

namespace pantin::detail {
namespace {

std::string unknown_to(Solver solver, Feature feature, const char* verb) {
  return std::string(verb) + ' ' + name_of(feature) + ", which its solver \"" + name_of(solver) +
         "\" does not support; use " + solvers_that_know(feature);
}

bool is_sound(const Joint& j) {
  return is_finite(j.anchor_a) && is_finite(j.anchor_b) && is_finite(j.frames.a()) &&
         is_finite(j.frames.b()) && is_unit(j.frames.a()) && is_unit(j.frames.b());
}

bool are_sound(const JointLimits& limits) {
  const auto fits = [](const AngleLimit& l) { return !l.on || is_range(l.low, l.high); };
  return fits(limits.angle) && fits(limits.second);
}

bool is_sound(const Cable& cable) {
  const CableParameters& s = cable.joint;
  const auto fits = [](const CableGuide& g) {
    return is_finite(g.anchor) && is_unit(g.axis) && g.radius >= 0 && std::isfinite(g.radius);
  };
  return std::all_of(cable.guides.begin(), cable.guides.end(), fits) && is_finite(s.anchor_a) &&
         is_finite(s.anchor_b) && !std::isnan(s.length) && s.compliance >= 0 &&
         std::isfinite(s.compliance);
}

bool is_sound(const Pin& p) {
  const bool draws =
      p.kind == PinKind::exact || (std::isfinite(1 / p.stiffness) && p.stiffness > 0 &&
                                   std::isfinite(p.damping) && p.damping >= 0);
  return is_finite(p.anchor) && draws;
}

/// The plans of the islands, by slot of their bodies.
struct Plans {
  World& world;
  Partition& partition;
  const Scope& scope;
  std::vector<IslandPlan*> of;

  const SolverSettings* settings(Entity body) const {
    const std::uint32_t slot = world.bodies.slot(body);
    return slot == kNoSlot || !of[slot] ? nullptr : &of[slot]->settings;
  }
  /// Excludes the island of a body from stepping, and reports the body.
  void stop(Entity body) const {
    const std::uint32_t slot = world.bodies.slot(body);
    if (slot == kNoSlot || !of[slot] || of[slot]->unfit) return;
    of[slot]->unfit = body;
    partition.islands[partition.island[slot]].unfit = true;
  }
};

void list_unknown(const Plans& owners) {
  const World& world = owners.world;
  const auto note = [&](Entity who, const SolverSettings* how, Feature what, const char* verb) {
    if (!how || knows(how->solver, what)) return false;
    const bool minor =
        what == Feature::contact || what == Feature::soft_stop || what == Feature::spring_pin;
    owners.partition.faults.push_back(
        {who, unknown_to(how->solver, what, verb), StructureFault::unknown, minor});
    return true;
  };
  each_feature(world, owners.scope,
               [&](Entity owner, std::span<const Entity> bodies, Feature what, const char* verb) {
                 if (what == Feature::kind) return;  // kinds are left out
                 for (const Entity body : bodies)
                   if (note(owner, owners.settings(body), what, verb)) return;
               });
  std::optional<Entity> special;  // of no island
  const auto solid = [&](std::uint32_t i) { return world.collisions.owners()[i]; };
  for (const std::uint32_t i : owners.scope.collisions)
    if (const Entity e = solid(i);
        !special && !owners.settings(e) && has_special_surface(world.collisions[e]))
      special = e;
  // One body represents its island.
  std::vector<const SolverSettings*> told;
  for (const std::uint32_t i : owners.scope.collisions) {
    const Entity e = solid(i);
    if (world.collisions[e].sensor) continue;  // detects the bodies of all solvers
    const SolverSettings* how = owners.settings(e);
    if (!how || how->solver == Solver::articulated ||
        std::find(told.begin(), told.end(), how) != told.end())
      continue;
    told.push_back(how);
    note(e, how, Feature::contact, "is made for");
    if (!knows(how->solver, Feature::contact)) continue;
    if (has_special_surface(world.collisions[e]))
      note(e, how, Feature::surface, "has");
    else if (special)
      note(*special, how, Feature::surface, "has");
  }
}

void list_impossible(const Plans& owners) {
  const World& world = owners.world;
  const auto impossible = [&](Entity who, std::string why) {
    owners.partition.faults.push_back({who, std::move(why), StructureFault::impossible, false});
  };
  const auto stop_both = [&](Entity who, const char* what, Entity a, Entity b) {
    impossible(who, std::string(what));
    owners.stop(a), owners.stop(b);
  };
  for (const std::uint32_t slot : owners.scope.bodies) {
    const Entity e = world.bodies.owners()[slot];
    const Body& b = world.bodies.values()[slot];
    const char* why = b.motion == Motion::dynamic ? fault_of(b) : nullptr;
    if (!why) continue;
    impossible(e, why), owners.stop(e);
  }
  for (const std::uint32_t i : owners.scope.links)
    if (const Link& l = world.links.values()[i]; !is_sound(l.joint))
      stop_both(world.links.owners()[i],
                "has an anchor that is not finite, or axes that are not unit quaternions", l.a,
                l.b);
  for (const std::uint32_t i : owners.scope.links)
    if (const Link& l = world.links.values()[i];
        l.joint.limits.any() && !are_sound(*l.joint.limits))
      stop_both(world.links.owners()[i], "has limits whose low end is above the high one", l.a,
                l.b);
  for (const std::uint32_t i : owners.scope.links) {
    const Link& l = world.links.values()[i];
    if (l.joint.parameters.any() &&
        !(is_sound(l.joint.parameters->rotation) && is_sound(l.joint.parameters->translation)))
      stop_both(
          world.links.owners()[i],
          "has a spring, friction or a motor with a number that is not finite or out of range", l.a,
          l.b);
  }
  for (const std::uint32_t i : owners.scope.collisions)
    if (const Shapes* shapes = world.shapes.find(world.collisions.owners()[i]);
        shapes && !std::all_of(shapes->list.begin(), shapes->list.end(),
                               [](const Shape& shape) { return is_usable(shape); }))
      owners.partition.faults.push_back(
          {world.collisions.owners()[i],
           "has a shape whose sizes or place are not finite or out of range",
           StructureFault::left_out, false});
  for (const std::uint32_t i : owners.scope.cables)
    if (const Cable& s = world.cables.values()[i]; !is_sound(s))
      stop_both(world.cables.owners()[i], "has a number that is not finite or out of range", s.a,
                s.b);
  for (const std::uint32_t i : owners.scope.pins)
    if (const Pin& p = world.pins.values()[i]; !is_sound(p))
      stop_both(world.pins.owners()[i],
                "has an anchor, a stiffness or a damping that is not finite or out of range",
                p.body, p.to);
}

/// Excludes bodies with more exact pins, joints to fixed bodies, or joints to one other body, than
/// `lagrangian` can solve for.
void list_overheld(const Plans& owners) {
  const World& world = owners.world;
  if (owners.scope.links.empty() && owners.scope.pins.empty()) return;
  std::vector<std::size_t> pins(world.bodies.size(), 0), joints(pins);
  for (const std::uint32_t i : owners.scope.pins) {
    const Pin& p = world.pins.values()[i];
    if (p.kind != PinKind::exact) continue;
    for (const Entity e : {p.body, p.to})
      if (const std::uint32_t slot = world.bodies.slot(e); slot != kNoSlot) ++pins[slot];
  }
  std::vector<PairedJoint> paired;
  for (const std::uint32_t i : owners.scope.links) {
    const Link& l = world.links.values()[i];
    const std::uint32_t a = world.bodies.slot(l.a), b = world.bodies.slot(l.b);
    if (a == kNoSlot || b == kNoSlot) continue;
    const auto is_dynamic = [&](std::uint32_t slot) {
      return world.bodies.values()[slot].motion == Motion::dynamic;
    };
    if (is_dynamic(a) != is_dynamic(b)) ++joints[is_dynamic(a) ? a : b];
    if (const SolverSettings* how = owners.settings(l.a);
        is_dynamic(b) && how && how->solver == Solver::lagrangian)
      paired.push_back({i, a, b});
  }
  const auto tell = [&](Entity body, Entity who, std::size_t found, const HoldBound& bound) {
    const SolverSettings* how = owners.settings(body);
    if (found <= bound.most || !how || how->solver != Solver::lagrangian) return;
    owners.partition.faults.push_back({who,
                                       (who == body ? "has " : "is one of ") +
                                           std::to_string(found) + " " + std::string(bound.what) +
                                           ", expected at most " + std::to_string(bound.most) +
                                           " under \"lagrangian\"; three already fix a body",
                                       StructureFault::impossible, false});
    owners.stop(body);
  };
  for (const std::uint32_t slot : owners.scope.bodies) {
    const Entity e = world.bodies.owners()[slot];
    tell(e, e, pins[slot], kExactPins), tell(e, e, joints[slot], kJointsToFixed);
  }
  for (const JointsOfPair& p : list_crowded_pairs(std::move(paired)))
    tell(world.bodies.owners()[p.first.a], world.links.owners()[p.first.joint], p.count,
         kJointsOfPair);
}

/// Excludes islands with faulty settings, and reports their first body.
void list_faulty_settings(const Plans& owners, std::span<std::vector<IslandPlan>> plans) {
  for (const std::vector<IslandPlan>& list : plans)
    for (const IslandPlan& plan : list) {
      const char* why = settings_fault(plan.settings);
      if (!why) continue;
      const Entity body = owners.world.bodies.owners()[plan.slots.front()];
      owners.partition.faults.push_back({body, why, StructureFault::impossible, false});
      owners.stop(body);
    }
}

/// One solver steps each island: reports the first body of each that asks for another one.
void list_ignored(const Plans& owners, std::span<std::vector<IslandPlan>> plans) {
  const World& world = owners.world;
  for (const std::vector<IslandPlan>& list : plans)
    for (const IslandPlan& plan : list) {
      const SolverSettings* used = nullptr;
      Entity by;
      for (const std::uint32_t slot : plan.slots) {
        const Entity e = world.bodies.owners()[slot];
        const SolverSettings* asked = world.settings.find(e);
        if (!asked) continue;
        if (!used) used = asked, by = e;
        if (asked->solver == used->solver) continue;
        std::string why = std::string("asks for the solver \"") + name_of(asked->solver) +
                          "\", but is tied to " + world.name_of(by) + ", whose solver \"" +
                          name_of(used->solver) + "\" steps both";
        owners.partition.faults.push_back({e, std::move(why), StructureFault::unknown, false});
        break;
      }
    }
}

/// Why an island cannot be moved in the plane, with the body concerned; or nothing.
std::string flat_fault_of(const World& world, const IslandPlan& plan, Entity& who) {
  who = world.bodies.owners()[plan.slots.front()];
  if (!has_planar_solver())
    return "is solved by \"planar\", which needs Box2D: this build was made without it";
  if (std::string why = flat_fault(world.gravity); !why.empty()) return why;
  for (const std::uint32_t slot : plan.slots) {
    who = world.bodies.owners()[slot];
    const Body& body = world.bodies.values()[slot];
    if (std::string why = flat_fault(body); !why.empty()) return why;
    const Shapes* shapes = world.collisions.find(who) ? world.shapes.find(who) : nullptr;
    if (shapes && !std::all_of(shapes->list.begin(), shapes->list.end(),
                               [&](const Shape& s) { return has_section(s, body.pose.rotation); }))
      return "has a shape without a planar section of discs and polygons";
  }
  return {};
}

/// Excludes islands that leave the plane.
void list_what_leaves_planes(const Plans& owners, std::span<const IslandPlan> plans) {
  for (const IslandPlan& plan : plans) {
    Entity who;
    std::string why = flat_fault_of(owners.world, plan, who);
    if (why.empty()) continue;
    owners.partition.faults.push_back({who, std::move(why), StructureFault::impossible, false});
    owners.stop(who);
  }
}

/// Excludes bodies that are no laminas, and laminas with connections to other bodies.
void list_what_is_no_lamina(const Plans& owners, std::span<const IslandPlan> plans) {
  for (const IslandPlan& plan : plans)
    for (const std::uint32_t slot : plan.slots) {
      const Entity who = owners.world.bodies.owners()[slot];
      std::string why = lamina_fault(owners.world, who);
      if (why.empty() && plan.slots.size() > 1)
        why = "is a lamina that is tied to another body: only fingers hold it";
      if (why.empty()) continue;
      owners.partition.faults.push_back({who, std::move(why), StructureFault::impossible, false});
      owners.stop(who);
    }
  const auto is_slow = [&](Entity body) {
    const SolverSettings* how = owners.settings(body);
    return how && how->solver == Solver::quasistatic;
  };
  const auto tell = [&](Entity tie, std::initializer_list<Entity> bodies) {
    if (std::any_of(bodies.begin(), bodies.end(), is_slow))
      owners.partition.faults.push_back(
          {tie,
           "ties a lamina, which its solver \"quasistatic\" does not support: only fingers hold it",
           StructureFault::left_out, false});
  };
  const World& w = owners.world;
  for (const std::uint32_t i : owners.scope.links)
    tell(w.links.owners()[i], {w.links.values()[i].a, w.links.values()[i].b});
  for (const std::uint32_t i : owners.scope.pins)
    tell(w.pins.owners()[i], {w.pins.values()[i].body, w.pins.values()[i].to});
}

}  // namespace

const char* fault_of(const Body& b) {
  if (!is_mass(b.mass)) return "has a mass that is not a positive number";
  if (!is_mass(b.inertia)) return "has an inertia that is not three positive numbers";
  if (!std::isfinite(b.drag) || !std::isfinite(b.gravity_scale))
    return "has a drag or a gravity scale that is not finite";
  if (!is_unit(b.pose)) return "has a rotation that is not a unit quaternion";
  return nullptr;
}

namespace {

/// Removes one component of an entity that no longer exists. If that of its successor hides it, the
/// latter is restored.
template <class T>
void drop(Store<T>& store, Entity gone) {
  if (store.slot(gone) != kNoSlot) return store.remove(gone);
  for (const Entity e : store.owners()) {
    if (e.index != gone.index || store.slot(e) == kNoSlot) continue;
    T kept = std::move(store[e]);
    const Entity owner = e;
    store.remove(owner), drop(store, gone);
    store.add(owner, std::move(kept));
    return;
  }
}

}  // namespace

std::vector<StructureFault> drop_strays(World& world) {
  std::vector<StructureFault> faults;
  const auto stray = [&](Entity e) { return !world.is_alive(e); };
  const auto clear = [&](const char* name, auto& store) {
    for (;;) {
      const auto at = std::find_if(store.owners().begin(), store.owners().end(), stray);
      if (at == store.owners().end()) return;
      const Entity gone = *at;
      drop(store, gone);
      faults.push_back({gone, "does not exist, but owns one of " + std::string(name),
                        StructureFault::left_out, false});
    }
  };
  World::fields(world, [&](const char* name, auto&& part) {
    unwrap(part, [&](Role, auto& member) {
      if constexpr (requires { member.owners(); }) clear(name, member);
    });
  });
  return faults;
}

namespace {

/// Whether a body surely has no fault: masses of all but absurd sizes, without a division.
bool is_plainly_sound(const Body& b) {
  const auto is_usual = [](Real x) { return x > 1e-300 && x < 1e300; };
  return is_usual(b.mass) && is_usual(b.inertia.x) && is_usual(b.inertia.y) &&
         is_usual(b.inertia.z) && std::isfinite(b.drag + b.gravity_scale) && is_unit(b.pose);
}

}  // namespace

bool normalise_rotations(World& world) {
  bool all_sound = true;
  for (Body& b : world.bodies.values()) {
    if (Quat& q = b.pose.rotation; !is_unit(q))
      if (const Real length = glm::length(q); length > 1e-150 && std::isfinite(length))
        q = q / length;
    all_sound = all_sound && (b.motion != Motion::dynamic || is_plainly_sound(b) || !fault_of(b));
  }
  return all_sound;
}

void list_faults(World& world, const Scope& scope, std::span<std::vector<IslandPlan>> plans) {
  Plans all{world, world.memory.of<Partition>(), scope, {}};
  all.of.assign(world.bodies.size(), nullptr);
  for (std::vector<IslandPlan>& list : plans)
    for (IslandPlan& plan : list)
      for (const std::uint32_t slot : plan.slots) all.of[slot] = &plan;
  list_unknown(all);
  list_impossible(all), list_overheld(all);
  list_faulty_settings(all, plans);
  list_ignored(all, plans);
  list_what_leaves_planes(all, plans[kPlanar]);
  list_what_is_no_lamina(all, plans[kQuasistatic]);
}

}  // namespace pantin::detail

namespace pantin {

using namespace detail;

std::vector<StructureFault> check(const World& world) {
  World built = world;
  built.mark_dirty();
  compile_if_changed(built);
  return partition_of(built).faults;
}

}  // namespace pantin
