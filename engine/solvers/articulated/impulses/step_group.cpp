// Bodies and trees in contact: several short substeps a step, one impulse iteration each.
//
// A contact has one normal impulse and two tangential ones; Coulomb's cone bounds friction. Points
// of the same two bodies are iterated together. Impulses on bodies of trees propagate through the
// joints, which stay closed (group_trees.cpp). Where several bodies touch, contacts are springs and
// dampers, as stiff as the substep allows: heaps stay calm, whatever residual the iteration leaves.
// A second iteration without springs (relaxation) removes the velocities that the springs added.
// The compression under lasting loads is compensated over time. A body that touches only fixed ones
// is iterated to convergence, without springs.
// [Macklin 2019, small steps; Catto 2024, soft contacts and relaxation]
#include <algorithm>
#include <limits>
#include <optional>

#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/impulses/group_lanes.hpp"
#include "engine/solvers/articulated/impulses/group_resting.hpp"
#include "engine/solvers/articulated/impulses/group_sweeps.hpp"
#include "engine/solvers/articulated/impulses/group_ties.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/articulated/procedural/push_out.hpp"
#include "engine/solvers/budget.hpp"

namespace pantin::detail::articulated {
namespace {

/// Groups of more bodies are iterated to convergence too, in substeps with an impact, if they have
/// no more points than this.
constexpr std::size_t kFewPoints = 32;
/// Most sections of a substep, which is divided at impacts.
constexpr int kMostParts = 6;
/// Tolerances relative to 1 m/s plus the speed: one body, few bodies without friction.
constexpr Real kEnoughAlone = 1e-12, kEnoughWhereSmooth = 1e-10;
constexpr int kSweepsOfFew = 1000, kBlowSweeps = 30, kSmoothBlowSweeps = 1600, kRollingSweeps = 20;
/// Factor on GroupLoops::open at the end of a step.
constexpr Real kLeftOpen = 1e-3;
/// Pairs of a group above which it is swept less often: a large pile always has an impact
/// somewhere.
constexpr std::size_t kManyToSweep = 96;
constexpr int kSweepsInHaste = 2, kSweepsOfLanes = 4, kSweepsOfManyPairs = 2,
              kImpactSweepsOfTrees = 6, kSweepsOfFewPoints = 24, kBlowSweepsOfTrees = 400,
              kSweepsOnCables = 50;
/// s: in shorter substeps the tolerance falls with the cube of their length, to keep symmetry.
constexpr Real kSubstepOfFewPoints = 1 / 470.0;
/// A contact with an impulse above kBlow times the previous one is an impact. A load moves no
/// faster than kLoadSpeed, m/s, with friction below the fraction kHeld of its bound.
constexpr Real kBlow = 10, kLoadSpeed = 0.2, kHeld = 0.99995;
/// Sweeps from zero where truncated ones added energy.
constexpr int kSweepsFromNone = 12;
/// Multiples of the deepest overlap: half-spaces of nearly opposite normals, as of a body that fits
/// exactly between two walls, meet farther away, where nothing holds it.
constexpr Real kFarthestOut = 20;
/// s: at rest, compressions are compensated at once.
constexpr Real kForGood = std::numeric_limits<Real>::infinity();
/// Whether a contact carries bodies that hardly move and do not slide. Its warm start is the last
/// impulse, otherwise the smaller of the last two.
bool is_load(const Group& g, const GroupContact& c) {
  const Vec3 a = g.a(c).velocity, b = g.b(c).velocity;
  const Real held = kHeld * c.friction * c.impulse.x;
  const Real aside = c.impulse.y * c.impulse.y + c.impulse.z * c.impulse.z;
  return aside < held * held && std::max(glm::dot(a, a), glm::dot(b, b)) < kLoadSpeed * kLoadSpeed;
}

/// Warm start from the previous substep. Among trees, loads are carried over; impacts are not.
void warm_start(const Group& g) {
  push_actuators(g);
  push_limits(g);
  for (const GroupTie& t : g.ties)
    if (t.kind != GroupTie::Kind::rigid) push_tie(g, t);
  for (GroupContact& c : g.contacts) {
    if (c.impulse == Vec3(0)) {
      c.before = 0;
      continue;
    }
    const Real last = c.impulse.x;
    if (!g.trees.empty() && last > c.before && !(last <= kBlow * c.before && is_load(g, c)))
      c.impulse *= c.before / last;
    c.before = last;
    if (!c.in_lanes) push(g, c);
  }
  push_lanes(g);
  for (GroupRolling& r : g.rollings) push(g, r);
}

/// Rescales stored impulses to a substep whose length is multiplied by `by`.
void change_length(const Group& g, Real by) {
  scale_impulses(g, by);
  for (GroupContact& c : g.contacts) c.before *= by;
  for (GroupTie& t : g.ties) t.impulse *= by;
  for (GroupNode& n : g.nodes) {
    n.pulled *= by, n.pulled_earlier *= by;
    for (GroupLimit& limit : n.limits) limit.impulse *= by, limit.before *= by;
  }
}

/// Whether impulses may only remove energy, which truncated sweeps have to respect.
bool is_bounded(const Group& g) {
  return (!g.trees.empty() || !g.ties.empty()) && is_left_alone(g);
}

/// Whether free bodies collide at few enough points for one solve: a row of balls, a rack.
bool is_blow(const Group& g, const Substep& s) {
  if (!g.trees.empty() || !g.ties.empty()) return false;
  std::size_t points = 0;
  for (const GroupContact& c : g.contacts) points += c.works;
  if (points > kFewPoints) return false;
  return std::any_of(g.contacts.begin(), g.contacts.end(), [&](const GroupContact& c) {
    const Vec3 speed = speed_at(g.a(c), c.arm_a) - speed_at(g.b(c), c.arm_b);
    const Real closing = -glm::dot(c.axes[0], speed);
    return c.works && closing > kLeastBlow && c.gap < s.h * closing;
  });
}

/// Truncated iterations between overlapping bodies may add energy: the impulses are then solved
/// again from zero. Each sweep of these removes energy, or adds at most the work of obstacles. What
/// springs and elastic cables have stored in the substep is lost to the motion.
void keep_energy(const Group& g, const Substep& s, Real before) {
  const Real stored = elastic_energy(g);
  const auto allowed = [&] { return before + work_of_surfaces(g, before) - stored; };
  if (kinetic_energy(g) <= (1 + kSlightGain) * allowed()) return bound_energy(g, allowed());
  forget_impulses(g);
  for (int n = 0; n < kSweepsFromNone; ++n)
    if (sweep_group(g, s, Sweep::relaxes, turned(Order::forwards, n)) < kEnoughAtFewPoints) break;
  settle_trees(g);
  bound_energy(g, allowed());
}

/// Sweeps over free bodies without cables, at most.
int sweeps_of_free(const Group& g, const Substep& s) {
  if (g.laned.empty() || s.in_haste) return 1;
  return g.pairs.size() > kManyToSweep ? kSweepsOfManyPairs : kSweepsOfLanes;
}

/// Impulses that walls exert on a jammed body from both sides grow from substep to substep. None is
/// replayed that is larger than this multiple of what weight and momentum of all can ask for, N s.
constexpr Real kReplayed = 10;
Real most_replayed(const Group& g, Real h) {
  Real mass = 0, momentum = h * whole_weight(g.bodies), led = 0;
  for (const GroupBody& b : g.bodies) {
    const Real speed = glm::length(b.velocity);
    if (b.per_mass == 0)
      led = std::max(led, speed);
    else
      mass += 1 / b.per_mass, momentum += speed / b.per_mass;
  }
  return kReplayed * (momentum + mass * led);
}

void take_substep(const Group& g, const Substep& s, Order order) {
  if (s.hard) return take_hard_substep(g, s, order);
  prepare_group(g, s);
  if (is_blow(g, s)) {
    Substep at_once = s;
    at_once.hard = true, at_once.most_sweeps = kBlowSweeps;
    if (!has_friction(g)) at_once.most_sweeps = kSmoothBlowSweeps;
    for (GroupContact& c : g.contacts) c.before = c.impulse.x;
    take_hard_substep(g, at_once, order);
    for (GroupContact& c : g.contacts)  // an impact is not replayed
      if (c.impulse.x > c.before) c.impulse *= c.before / c.impulse.x;
    return;
  }
  const bool collided = collide_elastically(g, s);
  for (GroupBody& b : g.bodies)
    if (b.per_mass > 0 && b.node == kNoNode) {
      b.before = b.velocity, b.touched = false;
      slow_down(b, s.h), accelerate(b, s.h);
    }
  const bool on_cables = has_cables(g);
  if (on_cables) begin_cables(g, s.h);
  const bool is_bound = is_bounded(g) || g.pressed;
  if (is_bound && collided) settle_trees(g);
  const Real energy = is_bound ? kinetic_energy(g) + elastic_energy(g) : 0;
  if (is_bound) remember_free(g);
  const bool is_free = g.trees.empty() && g.ties.empty();
  for (std::size_t i = 0; is_free && i < g.contacts.size(); ++i)
    if (GroupContact& c = g.contacts[i]; c.impulse.x > s.replayed)
      c.impulse *= s.replayed / c.impulse.x;
  warm_start(g);
  Ending solved(g, s);
  const int sweeps = is_free        ? sweeps_of_free(g, s)
                     : s.in_haste   ? kSweepsInHaste
                     : s.strikes    ? kBlowSweepsOfTrees
                     : s.few_points ? s.most_sweeps
                     : on_cables    ? kSweepsOnCables
                                    : kImpactSweepsOfTrees;
  for (int n = 0; n < sweeps; ++n)
    if (solved.is_reached(sweep_group(g, s, Sweep::solves, turned(order, n)))) break;
  if (on_cables) touch_by_impulses(g);
  for (const GroupContact& c : g.contacts)
    if (c.impulse.x > 0 && !on_cables) g.a(c).touched = g.b(c).touched = true;
  settle_trees(g);
  bound_drives(g, s.h);
  for (GroupBody& b : g.bodies)
    // Free flight uses the mean velocity, which is exact for a parabola; in contact, the end
    // velocity satisfies the contacts.
    if (b.node == kNoNode)
      move(b, b.touched || b.per_mass == 0 ? b.velocity : 0.5 * (b.before + b.velocity), s.h);
  move_trees(g, s.part);
  follow_cables(g);
  Ending relaxed(g, s);
  for (int n = 0; n < (s.few_points || is_tied(g) ? sweeps : 1); ++n)
    if (relaxed.is_reached(sweep_group(g, s, Sweep::relaxes, turned(order, n + 1)))) break;
  settle_trees(g);
  if (is_bound) keep_energy(g, s, energy);
  release_trees(g, s.part);
  for (GroupBody& b : g.bodies)
    if (b.per_mass > 0) slow_down(b, s.h);
  add_passed(g);
}

/// A substep of few bodies, divided at impacts, so that bodies fly freely until then.
void take_parts(const Group& g, const Substep& whole, Order order) {
  if (!whole.hard && !whole.few_points) return take_substep(g, whole, order);
  Substep s = whole;
  Real left = whole.h;
  for (int n = 1; left > 0; ++n) {
    const Real h = n < kMostParts ? first_strike(g, left) : left;
    PANTIN_ASSERT(h > 0 && h <= left);
    if (h != s.h) change_length(g, h / s.h);
    s.h = s.part.h = h, left -= h;
    s.part.end = left > 0 ? whole.part.end - left / whole.part.whole : whole.part.end;
    set_springs(s, whole.h);
    s.strikes = n > 1 && whole.few_points;
    s.reach = s.strikes ? whole.h : h;
    if (s.strikes) s.between = s.against_fixed = Softness{};
    if (whole.hard)
      for (GroupContact& c : g.contacts) c.before = c.impulse.x;
    take_substep(g, s, order);
    s.part.begin = s.part.end;
    if (!whole.hard || n == 1) continue;
    for (GroupContact& c : g.contacts)  // an impact is not replayed
      if (c.impulse.x > c.before) c.impulse *= c.before / c.impulse.x;
  }
  if (s.h != whole.h) change_length(g, whole.h / s.h);
}

/// Updates the final gaps; parts deep overlaps; closes shallow ones of a body that touches only
/// fixed ones.
void finish_group(const Group& g, Real h) {
  centre_bodies(g);  // the last substep moved bodies away from their `centre`
  for (GroupContact& c : g.contacts) follow(g, c), place(g, c);
  part_overlaps(g, h);
  if (!g.is_single()) return;
  GroupBody& body = g.bodies.front();
  for (int round = 0; round < 4; ++round) {
    HalfSpaces planes;
    Real deepest = 0;
    for (const GroupContact& c : g.contacts) {
      const Vec3 n = c.axes[0];
      const Real gap = glm::dot(n, body.pose.position + c.arm_a - g.b(c).pose.position - c.arm_b);
      if (gap < 0 && gap > -c.shallow) planes.add(n, -gap), deepest = std::max(deepest, -gap);
    }
    const std::optional<Vec3> way = way_out(planes, kFarthestOut * deepest);
    if (!way) break;
    body.pose.position += *way;
  }
  for (GroupContact& c : g.contacts) place(g, c);
}

}  // namespace

Mat3 inverse_inertia(const GroupBody& b, Quat q) {
  const Mat3 r = glm::mat3_cast(q);
  const Vec3 per = b.per_inertia;
  return Mat3(per.x * r[0], per.y * r[1], per.z * r[2]) * glm::transpose(r);
}

void slow_down(GroupBody& b, Real h) {
  const Real half = std::exp(-0.5 * h * b.drag);
  b.velocity *= half, b.angular_momentum *= half, b.spin *= half;
}

void move(GroupBody& b, Vec3 velocity, Real h) {
  b.pose.position += h * velocity;
  if (b.per_mass == 0) {
    b.pose.rotation = glm::normalize(from_rotation_vector(h * b.spin) * b.pose.rotation);
    return;
  }
  const Quat half = from_rotation_vector(0.5 * h * b.spin) * b.pose.rotation;
  const Vec3 mean = inverse_inertia(b, half) * b.angular_momentum;
  b.pose.rotation = glm::normalize(from_rotation_vector(h * mean) * b.pose.rotation);
  b.response = inverse_inertia(b, b.pose.rotation);
  b.spin = b.response * b.angular_momentum;
}

namespace {

bool has_bounces(const Group& g) {
  return std::any_of(g.contacts.begin(), g.contacts.end(),
                     [](const GroupContact& c) { return c.restitution > 0; });
}

/// Whether a contact with restitution carries no load: a body bounces on it. In the free motion
/// between impacts the group applies weight half a substep early; loaded contacts compensate that.
bool is_bouncing(const Group& g) {
  return std::any_of(g.contacts.begin(), g.contacts.end(),
                     [](const GroupContact& c) { return c.restitution > 0 && c.impulse.x == 0; });
}

/// Tries the step as one of a group at rest. Then, or before, stored impulses become those of a
/// substep, from the mean forces.
Rest rest_or_not(const Group& g, Real h, Real substep) {
  if (g.resting.empty() || g.waits) {
    change_length(g, substep);
    return Rest::fails;
  }
  change_length(g, h);
  const Rest rest = rest_group(g, {h, 0, 1, h});
  change_length(g, substep / h);
  return rest;
}

/// What is tried for the next part of a step: only arms that touch nothing move, or bodies without
/// joints glide; or any motion of bodies that are pressed; or sweeps.
enum class Whole : std::uint8_t { calm, moving, none };

/// Whether one body is kUneven times as heavy as another.
bool is_uneven(const Group& g) {
  constexpr Real kUneven = 100;
  Real least = std::numeric_limits<Real>::infinity(), most = 0;
  for (const GroupBody& b : g.bodies)
    if (b.per_mass > 0) least = std::min(least, b.per_mass), most = std::max(most, b.per_mass);
  return most > kUneven * least;
}

/// Tries a part of the step as a whole. Notes in `rest` if a search was in vain. Returns what to
/// try next; with `none` this part is left to sweeps, too.
Whole solve_whole(const Group& g, const Substep& s, Whole as, Rest& rest) {
  if (as == Whole::calm) {
    const Rest now = rest_group(g, s.part);
    if (now == Rest::taken) return Whole::calm;
    if (now == Rest::missed) rest = now;
    if (!g.pressed) return Whole::none;
  }
  if (has_bounces(g)) {
    prepare_group(g, s);
    collide_elastically(g, s);
  }
  const Rest now = move_group(g, s.part);
  if (now == Rest::missed) rest = now;
  if (now == Rest::taken) return Whole::moving;
  // Sweeps cannot correct what heavy bodies press on light ones.
  if (is_uneven(g)) scale_impulses(g, 0);
  return Whole::none;
}

}  // namespace

Rest step_group(const Group& g, Real h, Pace& pace) {
  assert_gathered(g);
  const int substeps = substeps_of(g, h);
  join_rims(g, h);
  Substep s;
  PANTIN_ASSERT(substeps > 0);
  s.h = s.reach = h / substeps;
  set_springs(s, s.h);
  s.hard = g.has_at_most(kFewBodies), s.alone = g.is_single();
  s.few_points = has_few_points(g, h);
  s.most_sweeps = !s.alone ? kSweepsOfFew : g.rollings.empty() ? kHardSweeps : kRollingSweeps;
  const bool rough = std::any_of(g.contacts.begin(), g.contacts.end(),
                                 [](const GroupContact& c) { return c.friction > 0; });
  s.enough = s.alone ? kEnoughAlone : rough ? kEnoughOfFew : kEnoughWhereSmooth;
  s.enough *= 1 + glm::length(g.bodies.front().velocity);
  if (s.few_points) {
    const Real longer = std::max(Real(1), kSubstepOfFewPoints / s.h);
    s.most_sweeps =
        static_cast<int>(std::min(kSweepsOfFewPoints * longer, Real(kBlowSweepsOfTrees)));
    s.enough = kEnoughAtFewPoints / (longer * longer * longer);
  }
  const bool is_bound = is_bounded(g);
  const Real energy = energy_of_bodies(g) + elastic_energy(g);
  for (GroupBody& b : g.bodies) b.from = b.pose.position;
  Rest rest = rest_or_not(g, h, s.h);
  const bool rests = rest == Rest::taken;
  for (GroupContact& c : g.contacts) {
    c.before = c.impulse.x;
    if (s.hard) c.rest = 0;  // the offset of a heap's springs does not apply without springs
  }
  const bool may_be_calm = rest == Rest::moves && substeps > 1;
  Whole whole = may_be_calm ? Whole::calm : g.pressed ? Whole::moving : Whole::none;
  s.part = {s.h, 0, 0, h};
  s.replayed = rests ? 0 : most_replayed(g, s.h);
  bool in_haste = false;
  for (int n = 0, left = rests ? 0 : substeps; left > 0; ++n, --left) {
    // Loops would open in longer substeps.
    const int fewer = g.loops.empty() ? pace.affordable(left) : pace.all_of(left);
    if (fewer < left) {
      change_length(g, Real(left) / fewer), s.replayed *= Real(left) / fewer;
      s.h = s.reach = s.part.h = s.h * left / fewer;
      set_springs(s, s.h);
      s.few_points = false, s.in_haste = in_haste = true, left = fewer;
    }
    s.part.begin = s.part.end;
    const Real after = in_haste ? s.part.begin + (1 - s.part.begin) / left : Real(n + 1) / substeps;
    s.part.end = left == 1 ? 1 : after;
    if (in_haste && whole == Whole::calm) whole = g.pressed ? Whole::moving : Whole::none;
    if (whole != Whole::none) whole = solve_whole(g, s, whole, rest);
    if (whole == Whole::none) take_parts(g, s, turned(Order::forwards, n));
    pace.note_substep();
  }
  if (!s.hard) take_up(g, s, rests || whole != Whole::none ? kForGood : h);
  const GroupPart end{0, 1, 1, h};
  if (has_cables(g)) {
    centre_bodies(g);
    prepare_closed(g, end, s.h);
    shorten_all(g, end, s.h);
    restore_velocities(g);
  }
  if (!g.loops.empty()) {
    for (GroupLoops& l : g.loops) l.open *= kLeftOpen;
    prepare_closed(g, end, s.h);
    close_cuts(g);
    restore_velocities(g);
  }
  stiffen(g, 0);
  if (!g.trees.empty()) {  // motions that the joints allow at the final poses
    prepare_trees(g, end);
    settle_trees(g);
    release_trees(g, end);
  }
  if (is_bound && (is_bouncing(g) || has_cables(g)))
    slow_bodies(g, energy_of_bodies(g),
                energy - elastic_energy(g) + work_of_external_forces(g) +
                    work_of_surfaces(g, energy, &GroupContact::passed, substeps));
  finish_group(g, h);
  change_length(g, 1 / s.h);
  return rest;
}

}  // namespace pantin::detail::articulated
