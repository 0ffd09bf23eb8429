#pragma once
/// Contacts of this solver's bodies while a step is finished: see contacts.cpp.
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/disjoint_sets.hpp"
#include "engine/base/math.hpp"
#include "engine/contact/detect.hpp"
#include "engine/contact/rolling_friction.hpp"

namespace pantin::detail::lagrangian {

inline constexpr std::uint32_t kNoIndex = UINT32_MAX;

/// A fixed or kinematic body, or one of another solver, at the end of the step.
struct Obstacle {
  Pose pose;
  Vec3 velocity{0}, spin{0};
  bool moves() const { return velocity != Vec3(0) || spin != Vec3(0); }
};

/// One end of a contact, on a body of an island; or the row of a limit.
struct ContactEnd {
  std::uint32_t island = 0;  // in the solver's list
  std::uint32_t member = 0;  // the same in ContactScratch::members
  std::uint32_t point = 0;   // in ContactScratch::points
  std::uint32_t column = 0;  // of the body in its island
  Real sign = 1;             // -1: on the contact's body b
  Vec3 arm{0};               // m, world, from the mass centre: where impulses act
  Vec3 lead{0};              // m, likewise: the contact point at the end of the step
};

/// The row of a limit or a cable that may be active at the end of the step.
struct LimitRowAt {
  std::uint32_t island = 0, block = 0;
  std::uint32_t count = 0, body[8] = {};  // columns; frames are left out
  Vec3 j[16];                             // two a body
  Real gap = 0, frame_rate = 0;           // m or rad; what frames add to its rate
  bool was_active = false;                // in the step
};

/// Rolling and spinning friction of two bodies (contact_rolling.cpp).
struct RollingAt {
  std::uint32_t first = 0, count = 0;  // of the bodies' contacts, in ContactScratch::points
  std::size_t first_length = 0;        // in ContactScratch::lengths
  Real arm = 1;                        // m: torques are this times the point's impulses
};

/// Bodies, limit or rolling friction that a contact point acts on, and their response.
struct PointPlace {
  std::uint32_t contact = kNoIndex;             // in contacts_of(world), or none
  std::uint32_t limit = kNoIndex;               // in ContactScratch::limits
  std::uint32_t rolling = kNoIndex;             // in ContactScratch::rollings
  std::uint32_t group = 0;                      // the lowest island that it is coupled to
  std::uint32_t end[2] = {kNoIndex, kNoIndex};  // in ContactScratch::ends; none: an obstacle
  std::uint32_t owner[2] = {kNoIndex, kNoIndex}, column[2] = {};  // islands and bodies of those
  Vec3 axes[3];
  contact::TouchedPlace on[2];  // contact points on the bodies, in any orientation
  Obstacle obstacle[2];         // where there is no end
  Real friction = 0, restitution = 0;
  Real gap_before = 0;  // m, at the start of the step
  Real gap = 0;         // m, at its end with all displacements so far
  Real pull = 0;        // m/s^2, along the normal, without contacts
  Vec3 speed{0};        // m/s, at the end, with all impulses so far
  Mat3 response{0};     // 1/kg
};

/// A contact point. Three-component vectors are along its axes: the normal, from b to a, and two
/// tangents. A limit uses the first alone. Rolling friction is a point of its own, without a
/// contact.
struct ContactPoint : PointPlace {
  Vec3 impulse{0};          // N s on a, total
  Vec3 lasting{0};          // N s, part that acts at the end of the step
  Vec3 borne{0};            // the same, as result of the step
  Vec3 more{0};             // N s, change of the impulse at the displaced poses
  Vec3 whole{0};            // N s, total of the substeps so far
  Real least = 0;           // N s, lower bound of `lasting` along the normal: contacts may reduce
                            // the impulse that a limit gave in the step
  Vec3 shift{0};            // kg m: displacement impulse, not applied yet
  Vec3 held{0};             // kg m, part of it due to `lasting` and overlaps
  Real share = 0.5;         // fraction of the step over which `lasting` displaces
  Vec3 best{0}, kept{0};    // N s: best iterates, of Newton's method and of all attempts
  std::size_t unknown = 0;  // in the equations of its group
  bool works = true;        // the bodies respond to it
  bool closed = false;      // it is closed at the end of the step

  bool is_contact() const { return contact != kNoIndex; }
  bool is_limit() const { return limit != kNoIndex; }
  bool is_rolling() const { return !is_contact() && !is_limit(); }
};

/// An island in a group.
struct GroupMember {
  std::uint32_t group = 0, island = 0;
  std::uint32_t first_end = 0, ends = 0;
  std::size_t first_response = 0;  // 3 ends squared numbers, by rows
  Real kinetic = 0;                // J, before contacts
};

/// Islands coupled by contacts, or a single one in contact with obstacles.
struct ContactGroup {
  std::span<ContactPoint> points;
  std::span<GroupMember> members;
  Real h = 0;
};

/// Scratch memory of contacts.
struct ContactScratch {
  struct Range {
    std::size_t first_point = 0, points = 0, first_member = 0, members = 0;
  };
  DisjointSets sets{0};  // of islands
  std::vector<ContactPoint> points;
  std::vector<ContactEnd> ends;  // by member and point
  std::vector<LimitRowAt> limits;
  std::vector<RollingAt> rollings;
  std::vector<contact::RollingLengths> lengths;  // over the arm, by point
  std::vector<GroupMember> members;
  std::vector<Range> groups;
  std::vector<Real> responses;
  std::vector<Real> matrix, right;    // of Newton's method
  std::vector<std::uint8_t> touched;  // by island
  std::vector<ContactPoint> again;    // points at the start of a part of the step
  int unsolved = 0;                   // groups of the step that missed the tolerance
  Entity unsolved_at;                 // a body of the first
};

}  // namespace pantin::detail::lagrangian
