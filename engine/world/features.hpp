#pragma once
/// Lists the features of a World that not every solver supports.
#include <initializer_list>
#include <span>
#include <vector>

#include "engine/world/closing.hpp"
#include "engine/world/faults.hpp"
#include "engine/world/scope.hpp"
#include "engine/world/solver_list.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {

/// Calls visit(owner, bodies, feature, verb) for each joint, drive, cable and pin of a scope, and
/// each joint of surfaces, belt and gear, that has such a feature; "owner verb name_of(feature)" is
/// a sentence. Contacts are not included.
template <class Visit>
void each_feature(const World& world, const Scope& scope, const Visit& visit) {
  std::vector<Entity> on;
  const auto tell = [&](Entity owner, std::initializer_list<Entity> bodies, Feature what,
                        const char* verb) {
    on.insert(on.end(), bodies);
    visit(owner, std::span<const Entity>(on), what, verb);
    on.clear();
  };
  for (const std::uint32_t i : scope.links) {
    const Link& link = world.links.values()[i];
    const Entity owner = world.links.owners()[i];
    for (const Feature f : features_of(link.joint)) tell(owner, {link.a, link.b}, f, "has");
    if (const JointDrive* drive = world.joint_drives.find(owner))
      tell(owner, {link.a, link.b}, feature_of(*drive), "has");
  }
  for (const std::uint32_t i : list_closing(world, scope.links)) {
    const Link& link = world.links.values()[i];
    tell(world.links.owners()[i], {link.a, link.b}, Feature::closing, "is");
  }
  for (const std::uint32_t i : scope.cables) {
    const Cable& c = world.cables.values()[i];
    const bool guided = !c.guides.empty();
    for (const CableGuide& g : c.guides) on.push_back(g.body);
    tell(world.cables.owners()[i], {c.a, c.b}, guided ? Feature::cable_guide : Feature::cable,
         guided ? "has" : "is");
  }
  for (const std::uint32_t i : scope.pins)
    if (const Pin& p = world.pins.values()[i]; p.kind == PinKind::spring)
      tell(world.pins.owners()[i], {p.body}, Feature::spring_pin, "has");
  for (std::size_t i = 0; i < world.surface_contacts.size(); ++i) {
    const SurfaceContact& c = world.surface_contacts.values()[i];
    tell(world.surface_contacts.owners()[i], {c.a, c.b}, feature_of(c), "is");
  }
  for (std::size_t i = 0; i < world.belts.size(); ++i) {
    const Belt& belt = world.belts.values()[i];
    for (const BeltPulley& p : belt.pulleys) on.push_back(p.body);
    tell(world.belts.owners()[i], {}, feature_of(belt), "is");
  }
  for (std::size_t i = 0; i < world.gears.size(); ++i) {
    const Gear& g = world.gears.values()[i];
    const Link *one = world.links.find(g.first), *two = world.links.find(g.second);
    if (!one || !two || g.first == g.second) continue;  // reported by the Lagrangian solver
    tell(world.gears.owners()[i], {one->a, one->b, two->a, two->b}, Feature::ratio, "is");
  }
}

}  // namespace pantin::detail
