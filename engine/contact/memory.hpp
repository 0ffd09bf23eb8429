#pragma once
/// Contacts: state shared by islands and kept from step to step.
#include <cstdint>
#include <span>
#include <string_view>
#include <tuple>
#include <vector>

#include "engine/base/hash.hpp"
#include "engine/contact/contact.hpp"
#include "engine/contact/near_pairs.hpp"
#include "engine/contact/search.hpp"
#include "engine/world/memory.hpp"
#include "engine/world/partition.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail::contact {

/// By body slot: bounds on the displacement of bodies' surfaces in the step, m, and the predicted
/// displacements. The bounds include kReachFactor times these.
struct Reaches {
  std::span<Real> reach;
  std::span<Displacement> displacement;
};

/// A body that the update stage has already moved to the end of the step, and its pose at the
/// start.
struct StartPose {
  std::uint32_t slot = 0;
  Pose pose;
};

/// The fields of a Collision that decide which bodies collide.
struct CollisionFilter {
  std::uint32_t groups = 0, with = 0;
  bool sensor = false;
  bool is_known = false;  // has been compared
  bool operator==(const CollisionFilter&) const = default;
};

/// Whether c comes before d in the order of bodies and keys.
inline bool precedes(const Contact& c, const Contact& d) {
  return std::tie(c.slot_a, c.slot_b, c.key) < std::tie(d.slot_a, d.slot_b, d.key);
}

/// Where a body stood.
struct Placed {
  Entity body;
  Pose pose;
};

/// Scratch memory of contact detection; not part of the state.
struct DetectScratch {
  std::vector<Real> reach;  // m, by body slot: how far its surface may move in the step
  std::vector<Displacement> displacement;  // by body slot, as predicted
  std::vector<Real> struck;  // m, by body slot: largest displacement of its possible strikers
  std::vector<Pose> ends;    // poses of kinematic bodies at the end of the step
  std::vector<StartPose> starts;
  std::vector<std::uint8_t> has_gravity;  // by body slot: gravity has acted on its velocity
  std::vector<Contact> before, woken, fallen;
  std::uint64_t rest_version = 0;        // Partition::rest_version at the last update of `resting`
  std::vector<std::uint8_t> still;       // parallel to Partition::kinematic: whether it was at rest
  std::vector<Placed> placed;            // kinematic bodies, at the end of the last step
  std::vector<CollisionFilter> filters;  // by slot in World::collisions, at the last comparison
  int resting_active = 0;                // active contacts in Memory::resting
  Real resting_depth = 0;                // m, the largest depth in Memory::resting
  bool stale = false;                    // the structure changed: contacts are detected again
  Search search;
};

/// State shared by islands.
struct Memory {
  static constexpr std::string_view name = "contact";  // in saved Worlds
  std::vector<Contact> contacts;                       // see contacts_of(), resting_contacts_of()
  std::vector<Contact> resting;
  std::uint64_t kept_for = 0;           // replacements() at the last detection
  std::vector<SensorOverlap> overlaps;  // at the end of the last step
  NearPairs near;                       // of the last step
  Scratch<DetectScratch> scratch;

  static void fields(auto& self, auto&& field) {
    field("contacts", self.contacts);
    field("resting", self.resting);
    field("kept_for", passive(self.kept_for));
    field("overlaps", passive(self.overlaps));
    field("near", self.near);
    field("scratch", derived(self.scratch));
  }
};

/// Whether contacts affect the motion of a body; otherwise it is a kinematic obstacle.
inline bool feels_contacts(const Partition& partition, std::uint32_t slot) {
  return owner_of(partition, slot).feels_contacts;
}

}  // namespace pantin::detail::contact

// Code that copies, hashes and saves them is instantiated once, in sense.cpp.
namespace pantin::detail {
extern template contact::Memory& Memories::create();
extern template const contact::Memory& Memories::none();
}  // namespace pantin::detail
