#pragma once
/// What crosses islands and is kept from step to step: contacts, and interfaces where pins and cables
/// tie islands of different solvers.
#include <cstdint>
#include <vector>

#include "engine/base/hash.hpp"
#include "engine/contact/contact.hpp"
#include "engine/contact/search.hpp"
#include "engine/world/memory.hpp"
#include "engine/world/world.hpp"

namespace pantin::contact {

/// What ties the islands of two solvers at an interface.
enum class TieKind : std::uint8_t { pin, cable };

/// A point where a pin or a cable ties an island, the leader, to an island of another solver, the
/// follower.
///
/// The leader moves as if the follower were a point of its mass there, pushed by `asked`; then the
/// follower follows the point and tells the impulse that this took. Both are done again until that
/// is what the leader was given. See runtime/coupling.hpp.
struct Interface {
  TieKind kind = TieKind::pin;
  std::uint32_t source = 0;           // slot in the store of its kind
  std::uint32_t body = 0, guess = 0;  // columns of the leader: where it is tied; the point mass
  Vec3 anchor{0};                     // in the body
  Real mass = 0;                      // kg
  Vec3 force{0};                      // N on the leader, mean over the last step
  Vec3 asked{0};                      // N s, on the point mass
  Vec3 debt{0};                       // N s, what is left of the last step
  // Within a step:
  Vec3 given{0}, lack{0}, start{0};   // N s; N s; m/s of the point
  Real relax = 1;
  int rounds = 0;  // in which the step was taken
  bool taut = false;

  static void fields(auto& self, auto&& field) {
    field("kind", derived(self.kind));
    field("source", derived(self.source));
    field("body", derived(self.body));
    field("guess", derived(self.guess));
    field("anchor", derived(self.anchor));
    field("mass", self.mass);
    field("force", self.force);
    field("asked", self.asked);
    field("debt", self.debt);
    field("given", derived(self.given));
    field("lack", derived(self.lack));
    field("start", derived(self.start));
    field("relax", derived(self.relax));
    field("rounds", derived(self.rounds));
    field("taut", derived(self.taut));
  }
};

/// What a follower pulled on the body of another solver through a pin or a cable.
struct Reaction {
  TieKind kind = TieKind::pin;
  std::uint32_t source = 0;  // slot in the store of its kind
  Vec3 force{0};             // N on the other body, mean over the step
  Real mass = 0;             // kg, of the island that pulls
};

/// What bodies in contact press on one that feels no contacts itself; its solver takes it along in
/// the next step.
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

/// What the search needs from step to step but not for its answer.
struct DetectScratch {
  std::vector<Real> reach;  // m, by body slot: how far its surface may move in the step
  std::vector<Pose> ends;   // poses of kinematic bodies at the end of the step
  std::vector<Contact> before;
  bool stale = false;  // bodies were numbered anew: contacts are to be looked for again
  Search search;
};

/// Everything between islands that a step remembers.
struct Memory {
  std::vector<Contact> contacts;    // of the last step, in order of bodies and keys
  std::vector<Pressure> pressures;  // of the last step
  Scratch<DetectScratch> scratch;

  static void fields(auto& self, auto&& field) {
    field("contacts", self.contacts);
    field("pressures", self.pressures);
    field("scratch", derived(self.scratch));
  }
};

/// Whether a body's own motion answers to contacts; to others it is an obstacle on a given path.
inline bool feels_contacts(const Partition& partition, std::uint32_t slot) {
  return owner_of(partition, slot).feels_contacts;
}

}  // namespace pantin::contact
