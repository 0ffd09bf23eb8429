#pragma once
/// Events of contacts and sensors, by pairs of bodies; collision layers.
///
/// A body takes part if it has a Collision (RigidBody::collision). Pairs are selected by layers
/// and, between two moving bodies, by the fields `others` and `self` of Collision. A body whose
/// Collision is a sensor exerts and receives no forces; it only reports overlaps:
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

/// A Collision that is in some layers and collides with others. Each of two bodies has to collide
/// with a layer of the other.
constexpr Collision in_layers(std::uint32_t layers, std::uint32_t touches = kAllLayers,
                              Collision with = {}) {
  with.groups = layers, with.with = touches;
  return with;
}

struct Contact;

enum class ContactPhase : std::uint8_t { begin, persist, end };

/// Two bodies that are in contact, or began or ended it. `a` has the lower index; if one is a
/// sensor, `a` is the sensor.
struct ContactEvent {
  ContactPhase phase = ContactPhase::begin;
  bool is_sensor = false;  // `a` is a sensor: no impulse
  Entity a, b;
  Vec3 impulse{0};       // N s on a, sum over all points, since the last update
  Vec3 point{0};         // world, m: mean of the contact points on b
  Vec3 normal{0, 1, 0};  // unit, world, from b to a
  Real depth = 0;        // m, overlap at the deepest point
  // Of the point with the largest force: shapes of a and b (in World::shapes), and their materials
  // (in World::materials).
  std::uint32_t shape_a = 0, shape_b = 0, material_a = 0, material_b = 0;
  // m/s: closing speed at the point, from the velocities at the previous update; for begin events,
  // a measure of the loudness of an impact.
  Real approach = 0;
};

/// Tracks pairs in contact and reports changes. Use one object per World:
///
///   ContactEvents events(simulation.world);
///   simulation.step();
///   for (const ContactEvent& event : events.update(simulation.world)) ...
///
/// A pair stays in contact while its distance is below 0.1 mm. Impulses equal the change of
/// momentum, impacts included. With several substeps, forces are those of the last one. An end may
/// name bodies that no longer exist.
///
/// Overlaps with sensors are evaluated at the end of the last step: a body that passes a thin
/// sensor within one step is missed. Overlaps do not report shapes.
class ContactEvents {
 public:
  /// Pairs that are in contact already do not report a begin.
  explicit ContactEvents(const World& world) : time_(world.time) { update(world); }

  /// Compares the World with the last one seen. Reports begins and persists in the order of the
  /// indices of a and b, then ends likewise; valid until the next update.
  std::span<const ContactEvent> update(const World& world);
  /// The events of the last update.
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
