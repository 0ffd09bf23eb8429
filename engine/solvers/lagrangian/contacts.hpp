#pragma once
/// Contacts of exact bodies: what contacts.cpp, contact_points.cpp and contact_solve.cpp share.
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {

/// Finishes the step of `h` seconds with the contacts of all islands; writes bodies and contacts.
void resolve_contacts(World& world, Real h);

// Where things touch (contact_points.cpp).

/// Fills the scratch with points, ends, members and groups; the islands concerned are at the end of
/// their step, limits aside, which become points.
void gather_contacts(World& world, Real h);
/// In how many parts the bodies of a group take their step: more than one where loose ones roll on
/// their rims, whose points go around.
int parts_of(const World& world, const ContactGroup& g);
/// Points of a rim that stay on their body become the one that goes around: it is the deepest.
void join_rims(const ContactGroup& g);
/// Gaps and arms where the bodies are now.
void place_points(World& world, const ContactGroup& g);
/// Speeds and accelerations of the points, after place_points.
void find_speeds(const World& world, const ContactGroup& g);
/// The response of the ends of a member to one another.
void find_responses(World& world, const GroupMember& member);
/// The response of every point to itself, after those of the members.
void find_own_responses(World& world, const ContactGroup& g);
/// Adds the force of an end along its axes, or of a limit, to two vectors a body.
void add_end_force(const ContactScratch& r, const ContactEnd& end, Vec3 along,
                   std::span<Vec3> force);

// Rolling and spinning friction (contact_rolling.cpp).

/// Adds a point of torques for every two bodies that have it, after their contacts.
void list_rolling(const World& world, ContactScratch& r, Real h);
/// Where the contacts of each are, once points are sorted.
void find_rolling_points(ContactScratch& r);
bool is_any_closed(const ContactScratch& r, const RollingAt& all);
/// N s: of the torques, over the arm.
contact::RollingBounds rolling_bounds(const ContactScratch& r, const RollingAt& all);
/// The speed of such a point: that of turning, over the arm.
Vec3 rolling_speed(const World& world, const ContactScratch& r, const ContactPoint& p);
/// 1/kg: what a body would give way by to it without joints.
Real free_rolling(const Island& m, std::uint32_t column, const RollingAt& all);
/// The impulse `torque` of such a point, all others as they are, that stops what it can.
Vec3 solve_rolling(const ContactScratch& r, const ContactPoint& p, Vec3 torque);

// What solves them (contact_solve.cpp).

/// The islands' responses as the iterations see them.
struct Couplings {
  ContactScratch& scratch;
  const ContactGroup& group;
  /// An impulse, and what it displaces, along the axes of a point.
  void push(const ContactPoint& p, Vec3 impulse) const;
  void displace(const ContactPoint& p, Vec3 shift) const;
};
/// Impulses of restitution: bodies that meet within the step, one pair after the other.
void collide(const Couplings& with);
/// Impulses that hold at the end of the step, and what they displace. False: not within the
/// tolerance.
bool hold(const Couplings& with);
/// The same of what is closed already, from what it holds, after its speeds were found anew.
bool hold_on(const Couplings& with);
/// The largest tangential response of a point to itself.
Real softest_of(const Mat3& response);
/// Whether the bodies can turn about the normal at all.
bool can_spin(const Mat3& response);
/// The impulse at which the whole speed of a point ends.
Vec3 stop(const Mat3& response, Vec3 free);
/// What closed points are from their impulses as each one alone would have it, N s.
Real error_of(const Couplings& with);
/// Newton's method from the impulses as they are (contact_newton.cpp): the best that it finds.
/// Whether that is within the tolerance, N s. `attempt` counts the calls for the same points.
bool polish(const Couplings& with, Real tolerance, int attempt);
/// Displacements that are still needed to open closed points. Returns the deepest overlap beyond
/// what may stay, m.
Real open_overlaps(const Couplings& with);

}  // namespace pantin::detail::lagrangian
