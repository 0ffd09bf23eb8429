#pragma once
/// Who touches whom, and what is within a sensor: events by pairs of bodies; layers.
///
/// A body takes part if it has a Collision (RigidBody::collision). Which pairs are looked at is
/// said by layers, and by the fields `others` and `self` of Collision, for bodies that both move. A
/// body whose Collision is a sensor pushes nothing and is pushed by nothing; it only tells what
/// overlaps it:
///
///   world.add(RigidBody{.motion = Motion::fixed, .shape = BoxShape{.half_extents = {1, 1, 1}},
///                       .collision = Collision{.sensor = true}});
#include <cstdint>
#include <pantin/world.hpp>
#include <span>
#include <vector>

namespace pantin {

/// The bit of layer `number`, 0 to 31; several are combined by |.
constexpr std::uint32_t collision_layer(unsigned number) { return 1u << (number % 32); }
inline constexpr std::uint32_t kAllLayers = UINT32_MAX;

/// A Collision that lies in some layers and touches what lies in others. Of two bodies each has to
/// touch a layer of the other.
constexpr Collision in_layers(std::uint32_t layers, std::uint32_t touches = kAllLayers,
                              Collision with = {}) {
  with.groups = layers, with.with = touches;
  return with;
}

struct Contact;

enum class ContactPhase : std::uint8_t { begin, persist, end };

/// Two bodies that touch, began to or ceased to. `a` has the lower index; of a sensor and what
/// overlaps it `a` is the sensor.
struct ContactEvent {
  ContactPhase phase = ContactPhase::begin;
  bool is_sensor = false;  // `a` is a sensor: no impulse
  Entity a, b;
  Vec3 impulse{0};       // N s on a, all points together, of the time since the last update
  Vec3 point{0};         // world, m: mean of all contact points on b
  Vec3 normal{0, 1, 0};  // unit, world, from b to a
  Real depth = 0;        // m, overlap at the deepest point
  // Of the point that bears most: which shapes of a and b (in World::shapes), and their materials
  // (in World::materials).
  std::uint32_t shape_a = 0, shape_b = 0, material_a = 0, material_b = 0;
  // m/s: how fast the bodies came towards each other at the point, by their motion at the update
  // before; of a begin what a sound goes by.
  Real approach = 0;
};

/// Tracks pairs in contact and reports changes. One object for each World:
///
///   ContactEvents events(simulation.world);
///   simulation.step();
///   for (const ContactEvent& event : events.update(simulation.world)) ...
///
/// A pair that was in contact stays so while its distance is below 0.1 mm. Impulses agree with
/// the momentum that bodies gain, impacts included. Where the settings of a step say substeps,
/// forces are those of the last one. An end names bodies that may be gone.
///
/// Overlaps with sensors are those at the end of the last step: what passes a thin sensor within
/// one step is not seen; of an overlap the shapes are not told.
class ContactEvents {
 public:
  /// Pairs in contact in this World as it stands do not report a begin.
  explicit ContactEvents(const World& world) : time_(world.time) { update(world); }

  /// Compares the World with the last one seen. Begins and persists in the order of a's and b's
  /// indices, then ends likewise; good until the next update.
  std::span<const ContactEvent> update(const World& world);
  /// Those of the last update.
  std::span<const ContactEvent> events() const { return events_; }

 private:
  void collect(const World& world, std::span<const Contact> contacts, Real seconds);
  void collect_overlaps(const World& world);
  void compare();
  bool touched(const ContactEvent& now) const;
  void find_approaches();
  void note_motions(const World& world);

  /// A body as it was at the last update.
  struct Motion {
    Entity owner;
    Vec3 position{0}, velocity{0}, spin{0};
  };
  Vec3 velocity_before(Entity body, Vec3 point) const;

  Real time_ = 0;
  std::vector<Motion> motions_;  // by index of the entity
  std::vector<ContactEvent> now_, before_, events_;
};

}  // namespace pantin
