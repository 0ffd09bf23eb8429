#pragma once
/// Free bodies in contact, while they are stepped: see free_bodies.cpp.
#include <cstdint>
#include <vector>

#include "engine/base/disjoint_sets.hpp"
#include "engine/base/math.hpp"

namespace pantin::detail::articulated {

/// A body in contact during one step: free, or fixed or kinematic, with zeros for what resists.
struct FreeBody {
  std::uint32_t slot = 0, island = UINT32_MAX;
  Pose pose;
  Vec3 velocity{0}, spin{0};  // m/s, rad/s
  Vec3 angular_momentum{0};   // kg m^2/s, world axes
  Real per_mass = 0;          // 1/kg
  Vec3 per_inertia{0};        // 1/(kg m^2), principal
  Mat3 response{0};           // inverse inertia, world axes
  Vec3 acceleration{0};       // m/s^2, of weight and applied force
  Vec3 torque{0};             // N m
  Real drag = 0;              // 1/s
  Vec3 before{0};             // velocity at the start of the substep
  bool touched = false;       // a contact bears it in this substep
};

/// One contact point of two of them.
struct FreeContact {
  std::uint32_t contact = 0;   // in contacts_of(world)
  std::uint32_t a = 0, b = 0;  // bodies of the group
  Vec3 axes[3];                // the normal, from b to a, and two across it
  Vec3 core_a{0}, core_b{0};   // in the bodies' frames; for round shapes a radius below the surface
  Real radius_a = 0, radius_b = 0;
  Vec3 arm_a{0}, arm_b{0};                                       // m, world
  Real gap = 0;                                                  // m
  Real along = 0, aside = 0, cross_first = 0, cross_second = 0;  // response, 1/kg
  Real friction = 0, restitution = 0;
  Real rest = 0;      // see Contact
  Real settling = 0;  // m, by which that was short of the load
  Real shallow = 0;   // m: overlaps up to here are removed without speed
  Vec3 impulse{0};    // N s of a substep, along the axes; between steps the mean force, N
  Vec3 passed{0};     // N s over the step so far
};

inline bool have_same_bodies(const FreeContact& c, const FreeContact& d) {
  return c.a == d.a && c.b == d.b;
}

/// A vector given by its components along the axes of a contact.
inline Vec3 to_world(const FreeContact& c, Vec3 v) {
  return v.x * c.axes[0] + v.y * c.axes[1] + v.z * c.axes[2];
}

/// Scratch memory of the free bodies of a step.
struct FreeScratch {
  /// What touches: its bodies, free ones first, and its contacts.
  struct Range {
    std::size_t first_body = 0, bodies = 0, first_contact = 0, contacts = 0;
  };
  DisjointSets sets{0};                       // of islands
  std::vector<std::uint32_t> group_of;        // by island
  std::vector<std::uint8_t> eligible, awake;  // by group, which is its first island
  std::vector<std::uint32_t> order;           // of contacts
  std::vector<std::uint32_t> index;           // of a body in its group, by slot
  std::vector<Range> groups;
  std::vector<FreeBody> bodies;
  std::vector<FreeContact> contacts;
};

}  // namespace pantin::detail::articulated
