#pragma once
/// Contacts between bodies.
#include <cstdint>
#include <functional>
#include <tuple>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"
#include "engine/world/entity.hpp"

namespace pantin {

struct World;

/// One contact point of two bodies that touch or may touch within the step.
struct Contact {
  // Slots in World::bodies; a is dynamic. Of two solvers' bodies, a is the one that adjusts later.
  std::uint32_t slot_a = 0, slot_b = 0;
  std::uint64_t key = 0;        // identifies shapes and features; equal in the next step
  Vec3 point_a{0}, point_b{0};  // in the bodies' mass-centre frames, m
  Vec3 normal{0, 1, 0};         // unit, world, from b to a
  Real gap = 0;                 // m, at the start of the step; below 0: overlap
  Real friction = 0, restitution = 0;
  Real rolling = 0, spinning = 0;  // m
  Vec3 surface_velocity{0};        // m/s, world: of a's surface minus that of b's surface
  // Results of the step:
  Vec3 lambda{0};         // multiplier on a, kg m, world
  Vec3 torque_lambda{0};  // of rolling and spinning friction, kg m^2
  Real rest = 0;          // m, spring offset that cancels the static compression of a soft contact
  bool active = false;    // exerts a force
  Vec3 force{0};          // N, on a, mean over the step
  Vec3 torque{0};         // N m, likewise, of rolling and spinning friction
  Real depth = 0;         // m, penetration after the step, never negative

  static void fields(auto& self, auto&& field) {
    field("slot_a", self.slot_a);
    field("slot_b", self.slot_b);
    field("key", self.key);
    field("point_a", passive(self.point_a));
    field("point_b", passive(self.point_b));
    field("normal", passive(self.normal));
    field("gap", passive(self.gap));
    field("friction", passive(self.friction));
    field("restitution", passive(self.restitution));
    field("rolling", passive(self.rolling));
    field("spinning", passive(self.spinning));
    field("surface_velocity", passive(self.surface_velocity));
    field("lambda", self.lambda);
    field("torque_lambda", self.torque_lambda);
    field("rest", self.rest);
    field("active", passive(self.active));
    field("force", passive(self.force));
    field("torque", passive(self.torque));
    field("depth", passive(self.depth));
  }
};

/// Two bodies that come near each other, passed to a ContactFilter. `a` has the lower index.
struct ContactPair {
  Entity a, b;
  // At the nearest points: shapes in World::shapes, and the geometry of the contact.
  std::uint32_t shape_a = 0, shape_b = 0;
  Vec3 point{0};         // world, m, on b
  Vec3 normal{0, 1, 0};  // unit, world, from b to a
  Real gap = 0;          // m; below 0: overlap
};

/// Whether two bodies collide. See StepSettings::filter.
using ContactFilter = std::function<bool(const ContactPair&)>;

namespace detail {

/// A body that overlaps a sensor (Collision::sensor).
struct SensorOverlap {
  Entity sensor, body;
  Vec3 point{0};         // world, m: on the body, where the overlap is deepest
  Vec3 normal{0, 1, 0};  // unit, world, from the body to the sensor
  Real depth = 0;        // m, at the deepest point

  static void fields(auto& self, auto&& field) {
    field("sensor", self.sensor);
    field("body", self.body);
    field("point", self.point);
    field("normal", self.normal);
    field("depth", self.depth);
  }
};

/// Sensor overlaps at the end of the last step: each pair once, ordered by the indices of the
/// sensor and the body.
const std::vector<SensorOverlap>& sensor_overlaps_of(const World& world);

}  // namespace detail

/// Contacts of the last step, sorted by bodies and key: of bodies that are awake, and of those that
/// fell asleep in it.
const std::vector<Contact>& contacts_of(const World& world);
std::vector<Contact>& contacts_of(World& world);
/// Contacts between bodies at rest, sorted likewise.
const std::vector<Contact>& resting_contacts_of(const World& world);

/// Calls `each(contact)` for all contacts of both lists, sorted.
template <class Each>
void each_contact(const World& world, const Each& each) {
  auto resting = resting_contacts_of(world).begin();
  const auto end = resting_contacts_of(world).end();
  const auto order = [](const Contact& c) { return std::tie(c.slot_a, c.slot_b, c.key); };
  for (const Contact& c : contacts_of(world)) {
    for (; resting != end && order(*resting) < order(c); ++resting) each(*resting);
    each(c);
  }
  for (; resting != end; ++resting) each(*resting);
}

}  // namespace pantin
