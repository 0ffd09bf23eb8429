#include "engine/world/faults.hpp"

#include <stdexcept>

#include "engine/world/world.hpp"

namespace pantin {
namespace {

constexpr unsigned bit(Solver s) { return 1u << static_cast<int>(s); }
constexpr unsigned kAuto = bit(Solver::automatic), kExact = bit(Solver::lagrangian);

struct Knowledge {
  const char* name;
  unsigned solvers;
  const char* told;
};
// By Feature. Sweeps pose: they close joints one after the other and clamp hard limits, no more.
constexpr Knowledge kKnowledge[kFeatures] = {
    {"a kind of joint whose bodies share no point", kExact, "\"lagrangian\""},
    {"a spring", kExact, "\"lagrangian\""},
    {"friction", kExact, "\"lagrangian\""},
    {"a motor", kExact, "\"lagrangian\""},
    {"limits with restitution", kExact, "\"lagrangian\""},
    {"a ratio", kExact, "\"lagrangian\""},
    {"a soft stop", kAuto, "\"auto\""},
    {"a pose drive", kAuto | kExact, "\"auto\" or \"lagrangian\""},
    {"a cable", kAuto | kExact, "\"auto\" or \"lagrangian\""},
    {"contact", kAuto, "\"auto\""},
    {"a spring grip", kAuto | kExact, "\"auto\" or \"lagrangian\""}};

const Knowledge& knowledge(Feature f) { return kKnowledge[static_cast<int>(f)]; }

std::string unknown_to(Solver solver, Feature feature, const char* verb) {
  return std::string(verb) + ' ' + name_of(feature) + ", which its solver \"" + name_of(solver) +
         "\" does not know, only " + solvers_that_know(feature);
}

bool is_mass(Real x) { return x > 0 && std::isfinite(x) && std::isfinite(1 / x); }

/// Why no step can be computed with a dynamic body, or null.
const char* fault_of(const Body& b) {
  if (!is_mass(b.mass)) return "has a mass that is not a positive number";
  if (!is_mass(b.inertia.x) || !is_mass(b.inertia.y) || !is_mass(b.inertia.z))
    return "has an inertia that is not three positive numbers";
  if (!std::isfinite(b.drag) || !std::isfinite(b.gravity_scale))
    return "has a drag or a gravity scale that is not finite";
  return nullptr;
}

bool is_sound(const Joint& j) {
  return is_finite(j.anchor_a) && is_finite(j.anchor_b) && is_finite(j.frames.a()) &&
         is_finite(j.frames.b());
}

bool is_sound(const StringJoint& s) {
  return is_finite(s.anchor_a) && is_finite(s.anchor_b) && !std::isnan(s.length) &&
         s.compliance >= 0 && std::isfinite(s.compliance);
}

bool is_sound(const Pin& p) {
  const bool draws = p.grip == Grip::exact || (std::isfinite(1 / p.stiffness) && p.stiffness > 0);
  return is_finite(p.anchor) && draws;
}

/// Who moves each body, by slot.
struct Owners {
  World& world;
  std::vector<Articulation*> articulation;
  std::vector<Mechanism*> mechanism;

  explicit Owners(World& w)
      : world(w), articulation(w.bodies.size()), mechanism(w.bodies.size()) {
    for (Articulation& a : w.articulations)
      for (std::size_t c = 0; c < a.count(); ++c) articulation[a.slots[c]] = &a;
    for (Mechanism& m : w.mechanisms)
      for (std::uint32_t slot : m.slots)
        if (slot < w.bodies.size()) mechanism[slot] = &m;
  }

  const SolverSettings* settings(Entity body) const {
    const std::uint32_t slot = world.bodies.slot(body);
    if (slot == kNoSlot) return nullptr;
    if (articulation[slot]) return &articulation[slot]->settings;
    return mechanism[slot] ? &mechanism[slot]->settings : nullptr;
  }

  /// The island of a body does not move; `named` is told.
  void stop(Entity body, Entity named) {
    const std::uint32_t slot = world.bodies.slot(body);
    if (slot == kNoSlot) return;
    if (articulation[slot] && !articulation[slot]->unfit) articulation[slot]->unfit = named;
    if (mechanism[slot] && !mechanism[slot]->unfit) mechanism[slot]->unfit = named;
  }
};

void list_unknown(Owners& owners) {
  World& world = owners.world;
  const auto note = [&](Entity who, const SolverSettings* how, Feature what, const char* verb) {
    if (!how || knows(how->solver, what)) return false;
    const bool minor = what == Feature::contact || what == Feature::soft_stop ||
                       what == Feature::spring_grip;
    world.faults.push_back(
        {who, unknown_to(how->solver, what, verb), StructureFault::unknown, minor});
    return true;
  };
  for (std::size_t i = 0; i < world.links.size(); ++i) {
    const Link& link = world.links.values()[i];
    const Entity owner = world.links.owners()[i];
    const SolverSettings* how = owners.settings(link.a);
    if (!how) how = owners.settings(link.b);
    if (link.joint.extras.any() || link.joint.limits.any())
      for (Feature f : features_of(link.joint))
        if (f != Feature::kind) note(owner, how, f, "has");  // kinds are left out
    if (world.pose_drives.find(owner)) note(owner, how, Feature::pose_drive, "has");
  }
  for (std::size_t i = 0; i < world.strings.size(); ++i) {
    const String& s = world.strings.values()[i];
    for (Entity end : {s.a, s.b})
      if (note(world.strings.owners()[i], owners.settings(end), Feature::cable, "is")) break;
  }
  for (std::size_t i = 0; i < world.pins.size(); ++i)
    if (const Pin& p = world.pins.values()[i]; p.grip == Grip::spring)
      note(world.pins.owners()[i], owners.settings(p.body), Feature::spring_grip, "has");
  for (std::size_t i = 0; i < world.ratios.size(); ++i) {
    const Ratio& r = world.ratios.values()[i];
    const Entity owner = world.ratios.owners()[i];
    const Link *one = world.links.find(r.first), *two = world.links.find(r.second);
    if (!one || !two || r.first == r.second) {
      if (world.mechanisms.empty())  // otherwise told with them
        world.faults.push_back({owner, "couples joints that do not exist or are the same",
                                StructureFault::left_out, false});
      continue;
    }
    for (Entity body : {one->a, one->b, two->a, two->b})
      if (note(owner, owners.settings(body), Feature::ratio, "is")) break;
  }
  // Of an island one body stands for all.
  std::vector<const SolverSettings*> told;
  for (Entity e : world.collisions.owners()) {
    const SolverSettings* how = owners.settings(e);
    if (!how || how->solver == Solver::automatic ||
        std::find(told.begin(), told.end(), how) != told.end())
      continue;
    told.push_back(how);
    note(e, how, Feature::contact, "is made for");
  }
}

void list_impossible(Owners& owners) {
  World& world = owners.world;
  const auto impossible = [&](Entity who, std::string why) {
    world.faults.push_back({who, std::move(why), StructureFault::impossible, false});
  };
  const auto stop_both = [&](Entity who, const char* what, Entity a, Entity b) {
    impossible(who, std::string(what));
    owners.stop(a, a), owners.stop(b, b);
  };
  for (std::size_t slot = 0; slot < world.bodies.size(); ++slot) {
    const Entity e = world.bodies.owners()[slot];
    const Body& b = world.bodies.values()[slot];
    const char* why = b.motion == Motion::dynamic ? fault_of(b) : nullptr;
    if (!why) continue;
    impossible(e, why), owners.stop(e, e);
  }
  for (std::size_t i = 0; i < world.links.size(); ++i)
    if (const Link& l = world.links.values()[i]; !is_sound(l.joint))
      stop_both(world.links.owners()[i], "has an anchor or axes that are not finite", l.a, l.b);
  for (std::size_t i = 0; i < world.strings.size(); ++i)
    if (const String& s = world.strings.values()[i]; !is_sound(s.joint))
      stop_both(world.strings.owners()[i], "has a number that is none", s.a, s.b);
  for (std::size_t i = 0; i < world.pins.size(); ++i)
    if (const Pin& p = world.pins.values()[i]; !is_sound(p))
      stop_both(world.pins.owners()[i], "has an anchor or a stiffness that is none", p.body, p.to);
}

}  // namespace

bool knows(Solver solver, Feature feature) { return (knowledge(feature).solvers & bit(solver)) != 0; }

const char* solvers_that_know(Feature feature) { return knowledge(feature).told; }

const char* name_of(Feature feature) { return knowledge(feature).name; }

std::vector<Feature> features_of(const Joint& joint) {
  std::vector<Feature> found;
  const auto add = [&](Feature f, bool is_there) {
    if (is_there) found.push_back(f);
  };
  add(Feature::kind, !holds_point(joint.kind));
  if (joint.extras.any()) {
    const Freedom &turn = joint.extras->turn, &slide = joint.extras->slide;
    const auto springs = [](const Freedom& f) {
      return f.spring.stiffness != 0 || f.spring.damping != 0;
    };
    const auto rubs = [](const Freedom& f) {
      return f.friction.viscous != 0 || f.friction.dry != 0;
    };
    add(Feature::spring, springs(turn) || springs(slide));
    add(Feature::friction, rubs(turn) || rubs(slide));
    add(Feature::motor,
        turn.motor.kind != MotorKind::none || slide.motor.kind != MotorKind::none);
    add(Feature::restitution, joint.extras->restitution != 0);
  }
  add(Feature::soft_stop, joint.limits.any() && joint.limits->soft_zone > 0);
  return found;
}

void list_faults(World& world) {
  Owners owners(world);
  list_unknown(owners);
  list_impossible(owners);
}

std::vector<StructureFault> check(const World& world) {
  World built = world;
  built.touch();
  rebuild_articulations(built);
  return built.faults;
}

void throw_missing(Entity owner) {
  throw std::out_of_range("no such component of entity #" + std::to_string(owner.index) +
                          ", generation " + std::to_string(owner.generation));
}

}  // namespace pantin
