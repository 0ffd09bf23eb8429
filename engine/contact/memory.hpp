#pragma once
/// What crosses islands and is kept from step to step: contacts, and interfaces where pins and
/// cables tie islands of different solvers.
#include <cstdint>
#include <string_view>
#include <vector>

#include "engine/base/hash.hpp"
#include "engine/contact/contact.hpp"
#include "engine/contact/near_pairs.hpp"
#include "engine/contact/search.hpp"
#include "engine/world/memory.hpp"
#include "engine/world/partition.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail::contact {

/// Kind of connection at an interface.
enum class TieKind : std::uint8_t { pin, cable };

/// An interface: a point where a pin or a cable connects an island, the leader, to an island of
/// another solver, the follower.
///
/// The leader steps with a point mass of the follower's mass at the interface, on which `impulse`
/// acts. Then the follower tracks the point and reports its reaction. Both steps repeat until the
/// reaction equals the transmitted impulse. See runtime/coupling.hpp.
struct Interface {
  TieKind kind = TieKind::pin;
  std::uint32_t source = 0;  // slot in the store of its kind
  std::uint32_t body = 0,
                point_mass = 0;  // columns of the leader: the connected body; the point mass
  Vec3 anchor{0};                // in the body
  Real mass = 0;                 // kg
  Vec3 force{0};                 // N on the leader, mean over the last step
  Vec3 impulse{0};               // N s, on the point mass
  Vec3 carried{0};               // N s, residual carried over from the last step
  // Within a step:
  Vec3 transmitted{0}, residual{0}, start{0};  // N s; N s; m/s of the point
  Real relax = 1;
  int iterations = 0;  // in which the step converged
  bool taut = false;

  static void fields(auto& self, auto&& field) {
    field("kind", derived(self.kind));
    field("source", derived(self.source));
    field("body", derived(self.body));
    field("point_mass", derived(self.point_mass));
    field("anchor", derived(self.anchor));
    field("mass", self.mass);
    field("force", self.force);
    field("impulse", self.impulse);
    field("carried", self.carried);
    field("transmitted", derived(self.transmitted));
    field("residual", derived(self.residual));
    field("start", derived(self.start));
    field("relax", derived(self.relax));
    field("iterations", derived(self.iterations));
    field("taut", derived(self.taut));
  }
};

/// Reaction of a follower on the leader's body through a pin or a cable.
struct Reaction {
  TieKind kind = TieKind::pin;
  std::uint32_t source = 0;  // slot in the store of its kind
  Vec3 force{0};             // N on the other body, mean over the step
  Real mass = 0;             // kg, of the follower
};

/// Contact force on a body that had been stepped when it was found; applied in its next step.
struct Pressure {
  Entity body;
  Vec3 force{0};   // N
  Vec3 torque{0};  // N m, about the mass centre

  static void fields(auto& self, auto&& field) {
    field("body", self.body);
    field("force", self.force);
    field("torque", self.torque);
  }
};

/// A body that the update stage has moved to the end of the step already, and where it started.
struct StartPose {
  std::uint32_t slot = 0;
  Pose pose;
};

/// Scratch memory of contact detection; not part of the state.
struct DetectScratch {
  std::vector<Real> reach;  // m, by body slot: how far its surface may move in the step
  std::vector<Pose> ends;   // poses of kinematic bodies at the end of the step
  std::vector<StartPose> starts;
  std::vector<std::uint8_t> has_fallen;  // by body slot: weight has acted on its velocity
  std::vector<Contact> before;
  bool stale = false;  // bodies were renumbered: contacts are detected again
  Search search;
};

/// State between islands.
struct Memory {
  static constexpr std::string_view name = "contact";  // in saved Worlds
  std::vector<Contact> contacts;        // of the last step, in order of bodies and keys
  std::vector<Pressure> pressures;      // of the last step
  std::vector<SensorOverlap> overlaps;  // at its end
  NearPairs near;                       // of the last step
  Scratch<DetectScratch> scratch;

  static void fields(auto& self, auto&& field) {
    field("contacts", self.contacts);
    field("pressures", self.pressures);
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

// What copies, hashes and saves them is compiled once, in sense.cpp.
namespace pantin::detail {
extern template contact::Memory& Memories::create();
extern template const contact::Memory& Memories::none();
}  // namespace pantin::detail
