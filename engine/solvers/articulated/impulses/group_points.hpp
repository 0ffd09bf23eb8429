#pragma once
/// Contact points of a group: their response in a substep, and impulses, point by point and pair by
/// pair.
#include "engine/solvers/articulated/impulses/group_pair.hpp"

namespace pantin::detail::articulated {

/// Purpose of a sweep: solve contacts with springs, or relax velocities without them.
enum class Sweep : std::uint8_t { solves, relaxes };
/// The end from which a sweep goes over the contacts.
enum class Order : std::uint8_t { forwards, backwards };
inline Order turned(Order order, int times) {
  return (order == Order::backwards) != (times % 2 == 1) ? Order::backwards : Order::forwards;
}

struct Substep {
  Real h = 0;
  Real reach = 0;  // s: contacts and limits reached within this time are active
  GroupPart part;
  Softness between, against_fixed;
  Real before_limits = 0;  // rad: clearance from which a spring acts before a limit
  bool hard = false;       // contacts without springs
  int most_sweeps = 1;
  bool few_points = false;  // trees at few points: their impacts are iterated further
  bool strikes = false;     // of those: directly after an impact
  bool in_haste = false;    // longer than accuracy asks for: see Pace
  bool alone = false;       // one body: shallow overlaps are closed at the end of the step
  Real enough = 0;          // m/s: tolerance of the iteration, of few bodies or points
  Real replayed = 0;        // N s: of free bodies, the largest impulse that is replayed
};

/// Groups of at most so many free bodies are iterated to convergence, without springs.
inline constexpr std::size_t kFewBodies = 3;
/// m/s: least closing speed of an impact with restitution; least one that divides a substep.
inline constexpr Real kLeastBlow = 0.05, kLeastTimed = 0.5;
/// m/s: the fastest separation of overlaps.
inline constexpr Real kPushSpeed = 1;

/// Half of the drag, in a substep before the forces and again after the contacts: so drag does not
/// reduce the load of bodies at rest.
void slow_down(GroupBody& b, Real h);
/// Moves a free or kinematic body.
void move(GroupBody& b, Vec3 velocity, Real h);

// Number of substeps of a group, and where impacts divide them (group_substeps.cpp).
int substeps_of(const Group& g, Real h);
/// If a rim rolls far, all its points become the one lowest point that moves around it.
void join_rims(const Group& g, Real h);
/// Sets the contact springs for a section s of a substep of h seconds.
void set_springs(Substep& s, Real h);
/// 1/s^2: stiffness of the contact springs in a step of h seconds, for a unit of mass.
Real spring_stiffness(Real h);
/// Whether trees touch at few points, and no joint has an actuator: their impacts are iterated
/// further. Motors at their caps would need too many sweeps.
bool has_few_points(const Group& g, Real h);
/// s: time of the first impact of separated points; h if there is none before h or it is immediate.
/// Between substeps velocities are those of mass centres.
Real first_strike(const Group& g, Real h);

/// Numbers of a row, padded to whole vectors.
inline constexpr std::size_t padded(std::size_t rows) { return (rows + 3) / 4 * 4; }

inline const Softness& spring_of(const Group& g, const GroupContact& c, const Substep& s) {
  return g.is_fixed(c) ? s.against_fixed : s.between;
}

inline Arms arms_of(const GroupContact& c) { return {c.arm_a, c.arm_b}; }
inline Arms leads_of(const GroupContact& c) { return {c.lead_a, c.lead_b}; }
inline PairOf pair_of(const GroupContact& c) { return {c.a, c.b, c.cross}; }

/// Sets `centre` of bodies without joints to their mass centres.
void centre_bodies(const Group& g);
/// Moves a contact of two NURBS shapes to where they are closest at the current poses
/// (group_skins.cpp).
void follow(const Group& g, GroupContact& c);
/// Updates arms and gap of a contact at the current poses.
void place(const Group& g, GroupContact& c);
/// Velocities are evaluated where the contact is half a substep later, so that points move along
/// the chord of their path. Impulses act at the current position.
void lead(const Group& g, GroupContact& c, Real h);
/// Numbers of Group::numbers that the responses of a pair need: rows are three a point, and three
/// of rolling friction.
inline constexpr std::size_t most_responses(std::size_t rows) { return rows * padded(rows); }
/// Computes the responses of the active contacts of a pair to one another: speeds along the axes of
/// all, by impulses along the axes of each. Contacts that joints leave hardly any response become
/// inactive.
void prepare_pair(const Group& g, GroupPair& p);
/// Applies the accumulated impulse of a contact to its bodies.
void push(const Group& g, const GroupContact& c);
/// Iterations over the points of a pair; they end when changes fall below this fraction of the
/// first one. Among trees they go on: a residual of one pair would go on oscillating through the
/// joints.
inline constexpr int kPointIterations = 8;
inline constexpr Real kPairTolerance = 0.02;
/// The least normal speed that a contact requires, with and without an impulse.
struct Goal {
  Real speed = 0, parted = 0;
  Softness spring;
};
Goal goal_of(const GroupContact& c, const Softness& spring, const Substep& s, Sweep sweep);
/// A point of two bodies in an impact.
struct BlowPoint {
  GroupContact* contact = nullptr;
  Real speed = 0;   // m/s, of separation after it
  Vec3 impulse{0};  // N s, along the axes
};
/// An impact of two bodies at one or several points at once, with friction: none separates more
/// slowly than its speed after it, and those that got an impulse do not faster.
class Blow {
 public:
  void add(GroupContact& c, Real speed);
  /// `left`: iterations that are left for the impacts of a substep; fewer are taken once there are
  /// none.
  void solve(const Pair& pair, int& left);
  std::span<const BlowPoint> points() const { return std::span(points_).first(count_); }

 private:
  BlowPoint points_[kMostPoints];
  std::size_t count_ = 0;
};
/// m/s: the fastest at which fixed or kinematic bodies approach each other that bear against the
/// group from opposite sides, with the speed at which overlaps with them are separated. 0: none do.
Real closing_speed_of_walls(const Group& g, const Substep& s);
/// Whether sweeps that ended with this change of speed, m/s, cannot converge: kinematic bodies or
/// overlaps require a body to move in opposite directions.
bool is_jammed(const Group& g, const Substep& s, Real change);
/// One sweep over the contacts, pair by pair, from either end. Returns the largest change of speed,
/// m/s.
Real sweep_contacts(const Group& g, const Substep& s, Sweep sweep, Order order);

// Before impulses (group_prepare.cpp).

/// Prepares trees and loops; closes the gaps of loops first.
void prepare_closed(const Group& g, const GroupPart& part, Real h);
/// After it, where no impulses follow: the velocities before.
void restore_velocities(const Group& g);
/// Shortens inextensible cables that are too long, by moving bodies; leaves the group prepared.
void shorten_all(const Group& g, const GroupPart& part, Real h);
/// Prepares trees, ties and contacts at the current poses.
void prepare_group(const Group& g, const Substep& s);
/// Keeps contacts active that have an impulse or no gap at the current poses.
void prepare_touching(const Group& g);

/// Adapts Contact::rest to the springs' compression under lasting loads, while bodies hardly move.
/// Among trees only the two bodies have to be calm, since an arm may swing for long; towers would
/// creep unless all bodies are. Points of the same two bodies share the mean: else the most loaded
/// one would take ever more load.
void take_up(const Group& g, const Substep& s, Real h);

/// Whether the body has joints to others that move.
inline bool has_joints(const Group& g, const GroupBody& b) {
  return b.node != kNoNode && g.trees[g.nodes[b.node].tree].count > 1;
}

/// Whether an overlap is so deep that it is still being parted.
inline bool is_deep(const GroupContact& c) { return c.gap < -c.shallow - c.rest; }
/// At the end of a step of h seconds, with `centre` and gaps of the final poses: parts deep
/// overlaps of bodies without joints that hardly move (group_parting.cpp).
void part_overlaps(const Group& g, Real h);

/// Impacts with restitution in the substep, pair by pair until none approaches, so that a row of
/// balls passes on an impact. Returns whether there were any (group_impacts.cpp).
bool collide_elastically(const Group& g, const Substep& s);

// Rolling and spinning friction (group_rolling.cpp), of bodies that have it.

/// The larger response to impulses along two axes, a mean would overshoot in the softer direction:
/// the larger eigenvalue of a symmetric 2 x 2 matrix whose columns are `stride` numbers apart.
inline Real larger_response(const Real* first, std::size_t stride) {
  const Real k1 = first[0], k2 = first[stride + 1], k12 = first[stride];
  return 0.5 * (k1 + k2) + std::sqrt(0.25 * (k1 - k2) * (k1 - k2) + k12 * k12);
}

/// Where the responses of a pair hold those to its torques: the first number, and from one torque
/// to the next.
struct RollingRows {
  const Real* first;
  std::size_t stride;
};

/// Sets the responses to torques, given those of all rows of the torque.
void prepare_rolling(GroupRolling& r, const RollingRows& rows);
/// Solves the torques on the two bodies, bounded by the normal impulses, given the relative spin
/// along the axes. Returns the change of impulse.
Vec3 solve_rolling(const Group& g, GroupRolling& r, const Real* spin);
/// m/s: the change of speed at a contact by a change of the torque impulse.
Real speed_of(const Group& g, const GroupRolling& r, Vec3 change);
/// Applies the accumulated torque impulse to its bodies, within the bounds of the normal impulses.
void push(const Group& g, GroupRolling& r);

}  // namespace pantin::detail::articulated
