// Groups solved as a whole: at rest in one step, or in motion in each part of it.
//
// The velocities v at the end of the step are those at which
//   1/2 (v - v*)^T M (v - v*) + 1/2 sum over points of R |p|^2
// is least, with v* those without contacts. The impulse p of a point is (goal - J v) / R, projected
// to Coulomb's cone. Joints, limits and cables are points of such a kind (group_rest_links.cpp).
// The compliance R is so small that loads leave no visible overlap. Newton's method uses a factor
// of M + J^T G J, whose blocks are pairs of bodies that touch or are joined: sparse as their graph
// (rest_newton.cpp). Groups at rest take at most one iteration, whatever their weight.
// [Castro, Permenter & Han 2022]
//
// The convex problem would lift sliding bodies: points separate at the sliding speed times the
// friction. The goals are corrected by that, until it agrees with the sliding found; then Coulomb's
// law holds. [Acary & Cadoux 2013]
//
// Where bodies move, sweeps are faster as a rule (step_group.cpp): points that slide or roll take
// many iterations. But they leave loads that are heavy for the bodies below a sag, and towers of
// small bodies fall by it. Such groups are solved here in motion, too. Where the search does not
// converge, nothing is done, and sweeps follow.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/impulses/rest_newton.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// Sizes of a body: contacts that slide farther in a step than this are left to substeps.
constexpr Real kSlides = 2e-3;
/// m/s: bodies that glide strike others if points close faster.
constexpr Real kStrikes = 0.1;
/// At rest, gliding, and in motion.
constexpr Exactness kAtRest{.compliance = kRestCompliance,
                            .balanced = 1e-9,
                            .nearly = 1e-7,
                            .sinks = 1e-5,
                            .lifted = 1e-5,
                            .nearly_lifted = 1e-3,
                            .liftings = 3},
    kGliding =
        [] {
          Exactness gliding = kAtRest;
          gliding.liftings = 12;
          return gliding;
        }(),
    kInMotion{.compliance = 100 * kRestCompliance,
              .balanced = 1e-6,
              .nearly = 1e-5,
              .sinks = 1e-3,
              .lifted = 1e-3,
              .nearly_lifted = 0.1,
              .liftings = 3};
/// Lifts of less than this fraction of the sliding need no correction.
constexpr Real kLiftedOfSliding = 1e-3;
/// Corrections of the compliance, at most; one that leaves more of a sinking is the last.
constexpr int kHardenings = 8;
constexpr Real kStillSinks = 0.5;
/// Multiples of a shallow overlap: deeper ones are left to sweeps, which separate them faster.
constexpr Real kDeep = 2;
/// Largest speed that closes an overlap, sizes of a body per second; overlap that stays, in sizes
/// of a body, and the largest that stays between bodies with joints; the fraction of that where
/// they hardly move.
constexpr Real kCloses = 1e-2, kSunk = 1e-6, kSunkJoined = 0.05, kSunkAtRest = 0.1;
/// Margin of the predicted active set, as a fraction of the speed that weight gives in a step.
constexpr Real kMayPress = 0.1;
/// m/s: speeds without contacts count as this at least.
constexpr Real kLeastSpeed = 1e-6;
/// Newton iterations in a step, in a part of it in which bodies glide, and in motion: so many
/// iterations times contacts that may act, within bounds.
constexpr int kMostOfStep = 120, kMostOfPart = 80, kLeastInMotion = 20;
constexpr std::size_t kWorkInMotion = 10000;
/// Of these the first, from the impulses of the last step: in whole steps, in calm parts, in
/// motion.
constexpr int kFirstIterations = 2, kSwingIterations = 12, kMovingIterations = 6;
/// In motion, overlaps are closed at up to this many sizes of a body per second.
constexpr Real kClosesInMotion = 2;

/// What bodies may do in the step: nothing but swing light arms, glide on one another, or anything.
enum class Solving : std::uint8_t { at_rest, gliding, in_motion };
Solving solving_of(const Group& g, Real h) {
  return may_glide_for(g, h) ? Solving::gliding : Solving::at_rest;
}

/// A step, or a part of it, and what may happen in it.
struct Task {
  const GroupPart& part;
  Solving how;

  const Exactness& exactness() const {
    return how == Solving::in_motion ? kInMotion : how == Solving::gliding ? kGliding : kAtRest;
  }
  int most_iterations(const Group& g) const {
    if (how == Solving::at_rest) return kMostOfStep;
    if (how == Solving::gliding) return kMostOfPart;
    const auto near = std::count_if(g.rest_contacts.begin(), g.rest_contacts.end(),
                                    [](const RestContact& r) { return r.near; });
    return std::clamp(static_cast<int>(kWorkInMotion / (1 + static_cast<std::size_t>(near))),
                      kLeastInMotion, kMostOfStep);
  }
};

/// m/s^2: the largest acceleration of a body by weight and applied force.
Real weight_of(const Group& g) {
  Real most = 0;
  for (const GroupBody& b : g.bodies) most = std::max(most, glm::length(b.acceleration));
  return most;
}

/// Inertia about the mass centre, world axes.
Mat3 inertia_of(const GroupBody& b) {
  const Mat3 r = glm::mat3_cast(b.pose.rotation);
  const Vec3 i = Real(1) / b.per_inertia;
  return Mat3(i.x * r[0], i.y * r[1], i.z * r[2]) * glm::transpose(r);
}

void begin_bodies(const Group& g, Real h) {
  for (GroupBody& b : g.bodies) b.centre = b.pose.position;
  for (std::size_t i = 0; i < g.resting.size(); ++i) {
    GroupBody& b = g.bodies[i];
    RestBody& r = g.resting[i];
    if (b.node != kNoNode) b.response = inverse_inertia(b, b.pose.rotation);
    r.touches = b.node == kNoNode;
    const Real kept = std::exp(-0.5 * h * b.drag);
    r.inertia = inertia_of(b);
    r.free.force = kept * b.velocity + h * b.acceleration;
    r.free.torque = b.response * (kept * b.angular_momentum + h * b.torque);
  }
}

/// m/s, without contacts and joints: an arm may swing, and bodies glide towards others.
Real closing_speed(const Group& g, const GroupContact& c) {
  return std::max(-speed_of(g, c, &RestBody::free).x, -speed_of(g, c, &RestBody::motion).x);
}

/// Whether one of the bodies has joints. Shallow overlaps of such bodies stay: joints could not
/// follow if each point were separated at its own speed.
bool is_joined(const Group& g, const GroupContact& c) {
  return has_joints(g, g.a(c)) || has_joints(g, g.b(c));
}

/// m/s: at which the convex problem separates a contact that does not hold, at this speed.
Real lift_of(const GroupContact& c, const RestContact& r, Vec3 speed) {
  return c.friction * std::hypot(speed.y - r.goal.y, speed.z - r.goal.z);
}

/// m/s: a bound on the speed of a body's points without contacts.
Real speed_bound(const Group& g, std::uint32_t body) {
  const Wrench motion = motion_of(g, body, &RestBody::free);
  if (body >= g.resting.size()) return glm::length(motion.force);
  return glm::length(motion.force) + 2 * size_of(g.bodies[body]) * glm::length(motion.torque);
}

/// Whether a contact may act. In motion what stops one body may make it strike the next.
bool may_act(const Group& g, const GroupContact& c, const Task& task) {
  const Real h = task.part.h;
  return c.gap < 2 * h * std::max(kRestSpeed, closing_speed(g, c)) ||
         (task.how == Solving::in_motion &&
          c.gap < h * (speed_bound(g, c.a) + speed_bound(g, c.b)));
}

/// m/s: the fastest that an overlap is closed.
Real closes_at(const Task& task, Real size) {
  return task.how == Solving::in_motion ? std::min(kPushSpeed, kClosesInMotion * size)
                                        : kCloses * size;
}

/// Whether no body is faster than one at rest may be.
bool hardly_moves(const Group& g) {
  const auto is_slow = [](const GroupBody& b) {
    return glm::length(b.velocity) + size_of(b) * glm::length(b.spin) < kRestSpeed;
  };
  return std::all_of(g.bodies.begin(), g.bodies.begin() + g.resting.size(), is_slow);
}

/// Whether a contact is not for this method: bodies that glide strike others, or bounce, or an
/// overlap is so deep that sweeps must separate it.
bool is_too_wild(const Group& g, const GroupContact& c, Solving how) {
  if (how == Solving::in_motion) return false;
  const Real comes = -speed_of(g, c, &RestBody::motion).x;
  return (how == Solving::gliding && comes > kStrikes) ||
         (c.restitution > 0 && comes > kLeastBlow) || c.gap < -kDeep * c.shallow;
}

/// Contacts that may act in the step. False if one of them is not for this method.
bool begin_contacts(const Group& g, const Task& task) {
  const Real h = task.part.h, margin = kMayPress * h * weight_of(g);
  const Real sunk = hardly_moves(g) ? kSunkAtRest : 1;
  for (std::size_t i = 0; i < g.contacts.size(); ++i) {
    GroupContact& c = g.contacts[i];
    RestContact& r = g.rest_contacts[i];
    place(g, c);
    r.near = may_act(g, c, task);
    if (!r.near) continue;
    if (is_too_wild(g, c, task.how)) return false;
    g.resting[c.a].touches = true;
    if (c.b < g.resting.size()) g.resting[c.b].touches = true;
    Pair pair{{g, c.a}, {g, c.b}, nullptr};
    pair.a.response = pair.b.response = nullptr;  // without joints
    Real response = 0;
    for (const Vec3& axis : c.axes)
      response += glm::dot(axis, response_of(pair, arms_of(c), axis)) / 3;
    r.compliance = task.exactness().compliance * response, r.sank = 0;
    const Real size = size_of(g.a(c));
    const Real stays =
        is_joined(g, c) ? sunk * std::min(c.shallow, kSunkJoined * size) : kSunk * size;
    const Real deep = std::max(Real(0), -c.gap - stays);
    r.goal.x = c.gap > 0 ? -c.gap / h : std::min(kRestClosed * deep / h, closes_at(task, size));
    r.may_press = speed_of(g, c, &RestBody::free).x < r.goal.x + margin;
    r.goal.y = -c.surface_first, r.goal.z = -c.surface_second;
    r.lift = holds(c) ? 0 : lift_of(c, r, speed_of(g, c, &RestBody::motion));
    r.goal.x -= r.lift;
  }
  Real fast = kRestSpeed;
  for (std::uint32_t i = 0; task.how == Solving::in_motion && i < g.resting.size(); ++i)
    fast = std::max(fast, speed_bound(g, i));
  begin_links(g, task.part, fast);
  predict_links(g, margin);
  return true;
}

/// Finds the blocks of the factor: of contacts that may act, joints, ties and rolling friction.
void find_pattern(const Group& g) {
  g.rest_pattern.find([&](auto&& visit) {
    const auto add = [&](std::uint32_t a, std::uint32_t b) {
      if (a != b && a < g.resting.size() && b < g.resting.size())
        visit(g.resting[a].row, g.resting[b].row);
    };
    for (std::size_t i = 0; i < g.contacts.size(); ++i)
      if (g.rest_contacts[i].near) add(g.contacts[i].a, g.contacts[i].b);
    for (const GroupNode& n : g.nodes)
      if (n.parent != kNoNode) add(n.body, g.nodes[n.parent].body);
    for (const GroupTie& t : g.ties) add(t.a, t.b);
    for (const GroupRolling& r : g.rollings) add(g.contacts[r.first].a, g.contacts[r.first].b);
  });
}

/// Calls `visit(contact, lift)` for the contacts of the problem, with the lifts of the sliding
/// found.
template <class Visit>
void each_lift(const Group& g, const Visit& visit) {
  for (std::size_t i = 0; i < g.contacts.size(); ++i)
    if (RestContact& r = g.rest_contacts[i]; r.near)
      visit(r, r.cone.at == At::inside ? 0 : lift_of(g.contacts[i], r, r.speed));
}

/// m/s: by how much goals are off the lifts of the sliding found, where contacts act.
Real error_of_lifts(const Group& g) {
  Real most = 0;
  each_lift(g, [&](const RestContact& r, Real lift) {
    if (r.cone.at != At::apex)
      most = std::max(most, std::abs(lift - r.lift) - kLiftedOfSliding * lift);
  });
  return most;
}

/// Moves on to the velocities with these goals at which every contact acts as found.
bool follow_lifts(const Group& g) {
  find_residuals(g, Acting::as_found);
  if (!find_direction(g)) return false;
  advance_search(g, 1);
  return true;
}

/// Solves again with corrected goals until they agree with the sliding found. In motion, bodies
/// that slide may be lifted for a part of a step if that finds nothing.
bool settle_lifts(const Group& g, const Task& task, Search& s) {
  const Exactness& e = s.exactness;
  for (int n = 0;; ++n) {
    const Real error = error_of_lifts(g);
    if (error <= e.lifted * s.typical) return true;
    if (n == e.liftings) return error <= e.nearly_lifted * s.typical;
    if (task.how == Solving::in_motion) keep_found(g);
    each_lift(g, [](RestContact& r, Real lift) { r.goal.x -= lift - r.lift, r.lift = lift; });
    if (follow_lifts(g) && iterate(g, kIterations, s)) continue;
    if (task.how == Solving::in_motion) return return_to_kept(g), true;
    // Sweeps would be worse for bodies that glide.
    if (task.how != Solving::gliding || !iterate_softer(g, s)) return false;
  }
}

/// Reduces the compliance under heavy loads on light bodies. Whether there are any. Where walls
/// close on a body a point yields as fast however stiff it is: it stays as it is.
bool harden(const Group& g, const Search& s) {
  const Real most = s.exactness.sinks * s.typical;
  bool any = false;
  for (RestContact& r : g.rest_contacts) {
    const Real sinks = r.compliance * r.cone.impulse.x;
    if (!r.near || !(sinks > most) || most == 0) continue;
    if (r.sank > 0 && sinks > kStillSinks * r.sank) continue;
    r.sank = sinks, r.compliance *= 0.5 * most / sinks, any = true;
  }
  return harden_links(g, most) || any;
}

/// Whether no contact slides far at the velocities found.
bool is_at_rest(const Group& g, Real h) {
  for (std::size_t i = 0; i < g.contacts.size(); ++i) {
    const RestContact& r = g.rest_contacts[i];
    if (!r.near || r.cone.at != At::surface) continue;
    const Vec3 over = r.speed - r.goal;
    const Real most = kSlides / h * size_of(g.a(g.contacts[i]));
    if (over.y * over.y + over.z * over.z > most * most) return false;
  }
  return true;
}

/// Solves again with stiffer points until no load sinks. In motion, what was found before is kept
/// where that finds nothing.
bool settle_loads(const Group& g, const Task& task, Search& s) {
  const bool may_yield = task.how == Solving::in_motion;
  for (int n = 0;; ++n) {
    if (may_yield) keep_found(g);
    if (!harden(g, s)) return true;
    if (n < kHardenings && iterate(g, kIterations, s)) continue;
    if (may_yield) return_to_kept(g);
    return may_yield;
  }
}

/// Finds the velocities. Whether the search converged.
bool find_velocities(const Group& g, const Task& task, Search& s) {
  start_search(g);
  const bool moves = task.how == Solving::in_motion;
  const int first = moves                           ? kMovingIterations
                    : task.part.h < task.part.whole ? kSwingIterations
                                                    : kFirstIterations;
  s.is_exact = resume_search(g) && iterate(g, first, s);
  if (!s.is_exact && moves && !iterate_yielding(g, s)) return false;
  if (!s.is_exact && !moves) {
    start_search(g);
    if (!iterate(g, kFirstIterations, s) && !iterate_softer(g, s)) return false;
    s.is_exact = true;
  }
  return !s.is_exact || (settle_loads(g, task, s) && settle_lifts(g, task, s));
}

/// Writes such velocities to the bodies without joints.
void set_velocities(const Group& g, Wrench RestBody::*motion) {
  for (std::size_t i = 0; i < g.resting.size(); ++i) {
    GroupBody& b = g.bodies[i];
    const RestBody& r = g.resting[i];
    if (b.node != kNoNode) continue;
    b.velocity = (r.*motion).force;
    b.spin = (r.*motion).torque, b.angular_momentum = r.inertia * b.spin;
  }
}

/// Gives all bodies the velocities that were found. Beside trees that move, impulses act on free
/// bodies as on the trees, which keeps the momentum.
void take_velocities(const Group& g, const Task& task) {
  set_rest_impulses(g);
  for (GroupBody& b : g.bodies.first(g.resting.size())) b.before = b.velocity;
  const bool pushes = task.how == Solving::in_motion && !g.nodes.empty();
  if (pushes) set_velocities(g, &RestBody::free);
  push_resting_trees(g, task.part);
  if (pushes) return;
  set_velocities(g, &RestBody::motion);
  for (const GroupNode& n : g.nodes)
    if (g.resting[n.body].pressed > 0) g.trees[n.tree].stands = true;
}

/// Moves bodies by the velocities that were found.
void move_bodies(const Group& g, const Task& task) {
  const Real h = task.part.h;
  for (GroupBody& b : g.bodies)
    if (b.per_mass == 0 && (b.velocity != Vec3(0) || b.spin != Vec3(0))) move(b, b.velocity, h);
  for (std::size_t i = 0; i < g.resting.size(); ++i) {
    GroupBody& b = g.bodies[i];
    if (b.node != kNoNode) continue;
    // The mean velocity is exact for a parabola.
    const bool flies = task.how == Solving::in_motion && g.resting[i].pressed == 0;
    move(b, flies ? 0.5 * (b.before + b.velocity) : b.velocity, h);
  }
}

/// Arms of contacts on trees refer to joints while impulses act. Moves their origins by this
/// multiple of the way from there to the mass centres.
void move_origins(const Group& g, Real by) {
  const auto way = [&](std::uint32_t body) {
    const std::uint32_t node = g.bodies[body].node;
    return node == kNoNode ? Vec3(0) : by * g.nodes[node].arm;
  };
  for (std::size_t i = 0; !g.nodes.empty() && i < g.contacts.size(); ++i)
    if (GroupContact& c = g.contacts[i]; g.rest_contacts[i].near)
      c.arm_a -= way(c.a), c.arm_b -= way(c.b);
}

/// Takes back the velocities at which overlaps were closed.
void relax(const Group& g, Real h, Search& s) {
  keep_found(g);
  bool any = false;
  for (RestContact& r : g.rest_contacts) {
    const Real closes = r.goal.x + r.lift;
    if (r.near && closes > 0) r.goal.x -= closes, any = true;
  }
  if (!any) return;
  s.left = std::max(s.left, g.nodes.empty() ? kIterations : kMostOfPart);
  move_origins(g, 1);
  const bool found = (follow_lifts(g) && iterate(g, kIterations, s)) ||
                     (!g.nodes.empty() && iterate_yielding(g, s));
  if (!found) return_to_kept(g);
  move_origins(g, -1);
  if (!found) return;
  if (g.nodes.empty())
    set_velocities(g, &RestBody::motion);
  else
    push_trees_again(g, h);
  for (GroupBody& b : g.bodies.first(g.resting.size()))
    if (b.node == kNoNode) b.spin = b.response * b.angular_momentum;
}

/// Limits the energy to that of the motion without contacts, and the work of surfaces: softer
/// points and lifts that were not corrected may add some.
void limit_energy(const Group& g) {
  if (!is_left_alone(g)) return;
  Real free = 0;
  for (std::size_t i = 0; i < g.resting.size(); ++i) {
    const RestBody& r = g.resting[i];
    g.bodies[i].free_velocity = r.free.force, g.bodies[i].free_spin = r.free.torque;
    free += 0.5 * (glm::dot(r.free.force, r.free.force) / g.bodies[i].per_mass +
                   glm::dot(r.free.torque, r.inertia * r.free.torque));
  }
  note_approach(g);
  slow_bodies(g, energy_of_bodies(g), free + work_of_surfaces(g, free));
}

/// Impacts, and what walls press that close on bodies, are not replayed: between substeps, no
/// impulse is larger than the weight of all bodies can press.
void forget_impacts(const Group& g, Real h) {
  const Real most = std::max(h * whole_weight(g.bodies), Real(1e-30));  // it still acts
  for (GroupContact& c : g.contacts)
    if (c.impulse.x > most) c.impulse *= most / c.impulse.x;
}

/// m/s: of what bears the group, or of its mass centre.
Vec3 ground_velocity(const Group& g) {
  if (g.bodies.size() > g.resting.size()) return g.bodies[g.resting.size()].velocity;
  Vec3 momentum(0);
  Real mass = 0;
  for (std::size_t i = 0; i < g.resting.size(); ++i)
    momentum += g.resting[i].free.force / g.bodies[i].per_mass, mass += 1 / g.bodies[i].per_mass;
  return momentum / mass;
}

/// m/s, at the contacts that may act, without them.
Real fastest_closing(const Group& g) {
  Real most = 0;
  for (std::size_t i = 0; i < g.contacts.size(); ++i)
    if (g.rest_contacts[i].near) most = std::max(most, closing_speed(g, g.contacts[i]));
  return most;
}

Rest solve_group(const Group& g, const Task& task) {
  PANTIN_ASSERT(g.resting.size() == free_bodies(g.bodies));
  const Real h = task.part.h;
  const bool moves = task.how == Solving::in_motion;
  begin_bodies(g, h);
  start_search(g);
  if (!begin_contacts(g, task)) return Rest::fails;
  if (!moves && !are_calm(g, task.part)) return Rest::moves;
  Search s{task.exactness(), h * weight_of(g), kLeastSpeed, task.most_iterations(g)};
  const Vec3 ground = moves ? ground_velocity(g) : Vec3(0);
  for (const RestBody& r : g.resting)
    s.fastest = std::max(s.fastest, glm::length(r.free.force - ground));
  if (moves) s.typical = std::max(s.typical, fastest_closing(g));
  if (task.how != Solving::at_rest || !rests_as_before(g, s)) {
    find_pattern(g);
    if (!find_velocities(g, task, s)) return Rest::missed;
  }
  if (task.how == Solving::at_rest && !is_at_rest(g, h)) return Rest::moves;
  if (!moves && !are_calm(g, task.part)) return Rest::moves;
  take_velocities(g, task);
  move_bodies(g, task);
  move_trees(g, task.part);
  if (moves) relax(g, h, s);
  for (GroupContact& c : g.contacts) c.passed += c.impulse;
  for (GroupRolling& r : g.rollings) r.passed += r.impulse;
  release_trees(g, task.part);
  if (moves) limit_energy(g), forget_impacts(g, h);
  for (GroupBody& b : g.bodies)
    if (b.per_mass > 0) slow_down(b, h);
  if (g.nodes.empty() && task.part.end == 1)
    for (GroupPair& p : g.pairs) prepare_pair(g, p);  // responses, for take_up
  return Rest::taken;
}

}  // namespace

Rest rest_group(const Group& g, const GroupPart& part) {
  if (g.resting.empty()) return Rest::fails;
  return solve_group(g, {part, solving_of(g, part.h)});
}

Rest move_group(const Group& g, const GroupPart& part) {
  if (g.resting.empty()) return Rest::fails;
  return solve_group(g, {part, Solving::in_motion});
}

}  // namespace pantin::detail::articulated
