#pragma once
/// Contact points of a group: how they respond in a substep, and impulses on them, point by point
/// and pair by pair.
#include "engine/solvers/articulated/impulses/group_pair.hpp"

namespace pantin::detail::articulated {

/// What a sweep over contacts aims at.
enum class Sweep : std::uint8_t { solves, relaxes };
/// From which end it goes over them.
enum class Order : std::uint8_t { forwards, backwards };
inline Order turned(Order order, int times) {
  return (order == Order::backwards) != (times % 2 == 1) ? Order::backwards : Order::forwards;
}

struct Substep {
  Real h = 0;
  Real reach = 0;  // s: what touches within so long, or comes to a limit, is stopped by then
  GroupPart part;
  Softness between, against_fixed;
  Real before_limits = 0;  // rad: from there on springs act before a limit
  bool hard = false;       // without springs
  int most_sweeps = 1;
  bool few_points = false;  // of trees: their impacts are iterated further
  bool strikes = false;     // of those: something has just struck
  bool alone = false;       // one body: its shallow overlaps are closed at the end of the step
  Real enough = 0;  // m/s: smaller changes of speed end the iteration, of few bodies or points
};

/// So many free bodies are iterated until nothing changes, without springs.
inline constexpr std::size_t kFewBodies = 3;
/// m/s: slower strikes are no blows, and give nothing back; below the second they do not end a part
/// of a substep.
inline constexpr Real kLeastBlow = 0.05, kLeastTimed = 0.5;

/// Half of the drag before the forces of a substep, half after its contacts: what rests is not
/// lighter for its drag.
void slow_down(GroupBody& b, Real h);
/// A free body, and a fixed one that is led.
void move(GroupBody& b, Vec3 velocity, Real h);

// How many substeps a group takes, and where they are divided (group_substeps.cpp).
int substeps_of(const Group& g, Real h);
/// Points of a rim that stay on their body become the one that goes around, where it goes far.
void join_rims(const Group& g, Real h);
/// The springs of contacts in a substep that is part of one of h seconds.
void set_springs(Substep& s, Real h);
/// Of trees at few points impacts are iterated further; motors at their caps would ask for too
/// much.
bool has_few_points(const Group& g, Real h);
/// When what flies first strikes something, s, if that is within h, and not all at once; else h.
/// Between substeps velocities are those of mass centres.
Real first_strike(const Group& g, Real h);

inline const Softness& spring_of(const Group& g, const GroupContact& c, const Substep& s) {
  return g.is_fixed(c) ? s.against_fixed : s.between;
}

inline Arms arms_of(const GroupContact& c) { return {c.arm_a, c.arm_b}; }
inline Arms leads_of(const GroupContact& c) { return {c.lead_a, c.lead_b}; }
inline PairOf pair_of(const GroupContact& c) { return {c.a, c.b, c.cross}; }

/// Arms of bodies without joints start at their mass centres.
void centre_bodies(const Group& g);
/// Arms and gap of a contact where its bodies are now.
void place(const Group& g, GroupContact& c);
/// Velocities count where the contact is half a substep later: so points go along the chord of
/// their way, while impulses act where they are.
void lead(const Group& g, GroupContact& c, Real h);
/// The response of a contact.
void prepare_contact(const Group& g, GroupContact& c);
/// The impulses that a contact has, on its bodies.
void push(const Group& g, const GroupContact& c);
/// Normal speed that a contact asks for at least.
struct Goal {
  Real speed = 0;
  Softness spring;
};
/// One point, with friction: returns the change of its impulse, N s, which is not pushed yet.
Vec3 solve_point(const Pair& pair, GroupContact& c, const Goal& goal);
/// Whether sweeps that ended with such a change of speed, m/s, can have no result: bodies that move
/// by themselves, or overlaps, ask from both sides for room that there is not.
bool is_jammed(const Group& g, const Substep& s, Real change);
/// Every contact once, those of the same bodies together, from either end. Returns the largest
/// change of speed, m/s.
Real sweep_contacts(const Group& g, const Substep& s, Sweep sweep, Order order);

/// Lasting loads compress the springs; while nothing moves, that is taken up by and by. Among trees
/// the two bodies alone count, since an arm may swing for long; towers creep unless all of them
/// does. Points of the same two bodies share it: else the one that bears most would be given ever
/// more to bear.
void take_up(const Group& g, const Substep& s, Real h);

/// Impacts of the substep, pair by pair until none approaches: a row of balls passes a blow on.
/// Whether there were any (group_impacts.cpp).
bool collide_elastically(const Group& g, const Substep& s);

// Rolling and spinning friction (group_rolling.cpp), of bodies that have it.

/// What torques change of the relative turning.
void prepare_rolling(const Pair& pair, GroupRolling& r);
/// Torques on the two bodies, bounded by the normal impulses. Returns the change of speed at the
/// contact, m/s.
Real solve_rolling(const Group& g, Pair& pair, GroupRolling& r);
/// The impulse that it has, as far as the normal impulses of its contacts allow it, on its bodies.
void push(const Group& g, GroupRolling& r);

}  // namespace pantin::detail::articulated
