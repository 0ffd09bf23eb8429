#pragma once
/// Contacts of bodies of this solver: declarations of contacts.cpp, contact_points.cpp and
/// contact_solve.cpp.
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {

/// m/s: speed at which initial overlaps are pushed apart.
inline constexpr Real kPushSpeed = 1;
/// m: bodies that rest on others may separate by this much while all of them fall.
inline constexpr Real kNearlyShut = 1e-7;

/// Finishes the step of `h` seconds with the contacts of all islands; writes bodies and contacts.
void resolve_contacts(World& world, Real h);

/// Solves the contacts of one group and moves its islands. False: not to the tolerance.
bool resolve(World& world, const ContactGroup& g);
/// The same in as many parts of the step as the group needs (contact_parts.cpp).
bool resolve_in_parts(World& world, ContactGroup g);

// Contact points (contact_points.cpp).

/// Fills the scratch with points, ends, members and groups. The islands concerned are at the end of
/// their step, except that limits become points.
void gather_contacts(World& world, Real h);
/// Substeps that the bodies of a group take: more than one where loose bodies roll on their rims,
/// whose contact points travel around.
int parts_of(const World& world, const ContactGroup& g);
/// Merges the points of a rim that are fixed to the body into the travelling one: it is the
/// deepest.
void join_rims(const ContactGroup& g);
/// Recomputes gaps and arms at the current poses.
void place_points(World& world, const ContactGroup& g);
/// Speeds and accelerations of the points, after place_points.
void find_speeds(const World& world, const ContactGroup& g);
/// Computes the responses between the ends of a member.
void find_responses(World& world, const GroupMember& member);
/// Computes the response of every point to itself, after those of the members.
void find_own_responses(World& world, const ContactGroup& g);
/// Adds the force of an end along its axes, or of a limit, to two vectors a body.
void add_end_force(const ContactScratch& r, const ContactEnd& end, Vec3 along,
                   std::span<Vec3> force);

// Rolling and spinning friction (contact_rolling.cpp).

/// Adds one point of torques for each pair of bodies with rolling friction, after their contacts.
void list_rolling(const World& world, ContactScratch& r, Real h);
/// Finds the contacts of each pair, once points are sorted.
void find_rolling_points(ContactScratch& r);
bool is_any_closed(const ContactScratch& r, const RollingAt& all);
/// Bounds on the torques divided by the arm, N s.
contact::RollingBounds rolling_bounds(const ContactScratch& r, const RollingAt& all);
/// Relative angular velocity times the arm, as the speed of such a point.
Vec3 rolling_speed(const World& world, const ContactScratch& r, const ContactPoint& p);
/// Response of a body without joints to such a point, 1/kg.
Real free_rolling(const Island& m, std::uint32_t column, const RollingAt& all);
/// The impulse of such a point, from `torque`, that stops the rolling as far as its bounds allow.
Vec3 solve_rolling(const ContactScratch& r, const ContactPoint& p, Vec3 torque);

// Solvers (contact_solve.cpp).

/// Operators of the islands' responses, as the iterations use them.
struct Couplings {
  ContactScratch& scratch;
  const ContactGroup& group;
  /// Applies an impulse, or the displacement it causes, along the axes of a point.
  void push(const ContactPoint& p, Vec3 impulse) const;
  void displace(const ContactPoint& p, Vec3 shift) const;
};
/// Restitution: bodies that collide within the step, pair by pair.
void collide(const Couplings& with);
/// Solves for the impulses that act at the end of the step, and the displacements they cause.
/// False: the tolerance is not reached.
bool hold(const Couplings& with);
/// The same for contacts that are closed already, warm-started, after their speeds were recomputed.
bool hold_on(const Couplings& with);
/// The largest tangential response of a point to itself.
Real softest_of(const Mat3& response);
/// Whether the bodies can rotate about the normal at all.
bool can_spin(const Mat3& response);
/// The impulse that stops a point completely.
Vec3 stop(const Mat3& response, Vec3 free);
/// Residual, N s: largest difference of closed points from the impulse that each alone would have.
Real error_of(const Couplings& with);
/// Newton's method from the current impulses (contact_newton.cpp); keeps the best iterate. Returns
/// whether it meets the tolerance, N s. `attempt` counts the calls for the same points.
bool polish(const Couplings& with, Real tolerance, int attempt);
/// Displacements that still separate closed points. Returns the deepest overlap beyond the allowed
/// one, m.
Real open_overlaps(const Couplings& with);

}  // namespace pantin::detail::lagrangian
