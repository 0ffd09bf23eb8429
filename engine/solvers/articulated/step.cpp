#include <algorithm>
#include <cstddef>

#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/articulated/articulated.hpp"

namespace pantin::articulated {
namespace {

constexpr std::size_t words(std::size_t bytes) { return bytes / sizeof(Real); }

static_assert(sizeof(Body) % sizeof(Real) == 0);
static_assert(offsetof(Quat, x) == 0 && offsetof(Quat, w) == 3 * sizeof(Real));

const BodyLayout kLayout{words(sizeof(Body)), words(offsetof(Body, pose.position)),
                         words(offsetof(Body, pose.rotation)), words(offsetof(Body, velocity)),
                         words(offsetof(Body, spin))};

/// Where roots and holds are to be, from pins and from bodies that are moved otherwise.
void aim(const World& world, Island& a) {
  a.room.targets.clear();
  const auto place = [&](std::uint32_t body, std::uint32_t pin, Vec3 anchor) {
    return body != UINT32_MAX ? point_on(world, body, anchor) : world.pins.values()[pin].target;
  };
  for (Tree& t : a.trees) {
    if (a.parents[t.first] == kHeld) {
      const Vec3 now = place(t.held_body, t.held_pin, t.anchor);
      t.target_before = a.aimed ? t.target : now, t.target = now;
    }
    for (int n = 0; n < 3; ++n) a.room.targets.push_back(t.target[n]);
  }
  for (Hold& h : a.holds) {
    if (h.partner != UINT32_MAX) continue;  // loops have no place in the world
    const Vec3 now = place(h.held_body, h.held_pin, h.held_anchor);
    h.target_before = a.aimed ? h.target : now, h.target = now;
    if (!a.aimed) h.gap_before = h.target - point_on(world, a.slots[h.column], h.anchor);
  }
  a.aimed = true;
}

/// Bodies whose motion was changed by hand: forget what no longer holds.
void notice_changes(World& world, Island& a, Real h) {
  bool changed = false, jumped = false;
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    changed = changed || b.restart, jumped = jumped || b.teleport;
  }
  for (const Tree& t : a.trees)
    if (t.held_body != UINT32_MAX) jumped = jumped || world.bodies.values()[t.held_body].teleport;
  a.changed = changed || jumped;
  if (a.changed) a.calm_steps = 0;
  const Real ratio = jumped ? 0 : (a.last_step > 0 && !a.fresh ? h / a.last_step : 1);
  if (ratio != 1) {
    a.calm_steps = 0;
    for (std::size_t c = 0; c < a.count(); ++c)
      a.memory.set(kLoad, c, ratio * ratio * a.memory.vec(kLoad, c));
    for (Cord& cord : a.cords) cord.load *= ratio * ratio;
    for (Hold& hold : a.holds) hold.load *= ratio * ratio;
  }
  for (Tree& t : a.trees) {
    if (a.parents[t.first] != kFree || !(changed || a.fresh || !t.keeps_spin)) continue;
    t.spin_momentum = spin_momentum(world, a, t), t.keeps_spin = true;
  }
}

void collect_forces(const World& world, Island& a) {
  a.forced = !world.forces.empty();
  if (!a.forced) return;
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Force* f = world.forces.find(a.bodies[c]);
    const Real mass = a.constants.at(kMass, c);
    a.room.forces.set(0, c, f ? f->force / mass : Vec3(0));
    a.room.forces.set(3, c, f ? f->torque : Vec3(0));
  }
}

/// What multiplies h^2 in the displacement that a steady force at a joint or a string makes in one
/// step. The second-order rule brakes it by the drag, as it does the weight.
Real share_of_forces(const Island& a, Real h) {
  if (a.fresh) return 0.5;
  if (!a.second_order) return 1;
  Real mass = 0, drag = 0;
  for (std::size_t c = 0; c < a.count(); ++c)
    mass += a.constants.at(kMass, c), drag += a.constants.at(kMass, c) * a.constants.at(kDrag, c);
  return 4.0 / 9 / (1 + 2.0 / 3 * h * drag / mass);
}

Rule rule_of(const Island& a) {
  const Solver s = a.settings.solver;
  if (s == Solver::sweep || s == Solver::paper) return Rule::verlet;
  if (s == Solver::shake2) return Rule::midpoint;
  return a.second_order ? Rule::bdf2 : Rule::euler;
}

bool has_rows(const Island& a) { return !a.holds.empty() || !a.cords.empty(); }

bool touches_bear(const World& world, const Island& a) {
  return std::any_of(a.room.touches.begin(), a.room.touches.end(),
                     [&](const Touch& t) { return contacts_of(world)[t.contact].active; });
}

/// Does the articulation ask for more than free ball joints in this step?
bool is_plain(const Island& a) {
  return !has_rows(a) && a.joints.empty() && a.room.touches.empty();
}

/// The general solve from the predicted poses, leaf to root: loads of strings, pins and loops too.
void gather_once(World& world, Island& a, Real h) {
  StepScratch& r = a.room;
  // The blocks of the bodies stay the same from pass to pass; contacts do not.
  r.joint_blocks = r.base;
  a.rows_hold = !a.iterates && touches_bear(world, a);
  if (a.rows_hold) add_touches(world, a, r.joint_blocks);
  gather_joints(a);
  if (has_rows(a)) solve_rows(world, a, h, kPosition, kRotation, false);
}

/// ... and root to leaf: final poses, and what contacts and stops bear. True if settled.
bool close_once(World& world, Island& a, Real h) {
  const bool settled = close_joints(world, a, h, kPosition, kRotation, false);
  kernels().commit(packed(world, a), kRotation);
  return (a.iterates ? settle_iterated(world, a) : settle_touches(world, a)) && settled;
}

constexpr Real kFarOff = 1e-2;  // of the size: a residual that the first answer could not see

/// Strings, pins and loops are met to first order; what the turning of the bodies left is closed
/// again from the final poses, with stops and contacts as they were found to bear.
void close_rows(World& world, Island& a, Real h) {
  const Packed p = packed(world, a);
  StepScratch& r = a.room;
  const Real enough = 0.1 * a.settings.tolerance * a.size;
  Real worst = std::max(worst_stretch(world, a), worst_hold(a));
  if (!(worst > enough)) return;
  if (worst > kFarOff * a.size) {
    // A jump: solved once more from the prediction, with joints as stiff as it loads them.
    fill_base(a, true);
    add_string_stiffness(world, a, r.base, kPosition, kRotation);
    gather_once(world, a, h);
    close_once(world, a, h);
    worst = std::max(worst_stretch(world, a), worst_hold(a));
  }
  // The loads of the step itself are kept for the next one.
  for (std::size_t c = 0; c < a.count(); ++c) r.loads[c] = a.memory.vec(kLoad, c);
  for (int round = 0; round < a.settings.rounds && worst > enough; ++round) {
    kernels().prepare(p, kFinalPosition, kFinalRotation, false);
    if (!a.joints.empty()) set_terms(world, a, h, kFinalRotation, true);
    keep_gaps(a);
    fill_base(a, true);
    r.joint_blocks = r.base;
    gather_joints(a);
    solve_rows(world, a, h, kFinalPosition, kFinalRotation, true);
    close_joints(world, a, h, kFinalPosition, kFinalRotation, true);
    kernels().commit(p, kFinalRotation);
    // What the whole way would have loaded the joints with stiffens the next round.
    for (std::size_t c = 0; r.part < 1 && c < a.count(); ++c)
      a.memory.set(kLoad, c, a.memory.vec(kLoad, c) / r.part);
    a.rounds_used = round + 1;
    const Real now = std::max(worst_stretch(world, a), worst_hold(a));
    // A long way to go may lead round a bend; what cannot be reached stands still.
    if (std::abs(worst - now) < a.settings.stall_drop * worst) break;
    worst = now;
  }
  for (std::size_t c = 0; c < a.count(); ++c) a.memory.set(kLoad, c, r.loads[c]);
}

/// Joints closed one after the other, as if what is nearer the root could not give way.
void close_kinematic(Island& a, const Packed& p, Real h) {
  for (const Tree& t : a.trees)
    if (a.parents[t.first] == kFree && t.count > 1) place_free_root(a, t, h);
  if (a.settings.solver == Solver::paper) {
    literal_sweep(a, h);
    return;
  }
  const Kernels& k = kernels();
  k.levers(p, kPosition, kRotation);
  k.sweep(p, a.room.targets.data(), kPosition, a.settings.turn_stiffness);
  k.commit(p, kRotation);
}

/// A body whose state, or whose final place, is none; the first one.
Entity find_lost(const World& world, const Island& a) {
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    if (!(is_finite(b.pose) && is_finite(b.velocity) && is_finite(b.spin))) return a.bodies[c];
    const Vec3 x = a.room.work.vec(kAttach, c);
    if (!(glm::dot(x, x) < kTooFar * kTooFar) || !is_finite(a.room.work.quat(kTurn, c)))
      return a.bodies[c];
  }
  return a.bodies.front();
}

/// Tells pins and strings how they fared.
void report_holds(World& world, Island& a, Real h) {
  const Real to_force = 1 / (a.force_share * h * h);
  for (Hold& hold : a.holds) {
    const Vec3 at = point_on(world, a.slots[hold.column], hold.anchor);
    const Vec3 to = hold.partner == UINT32_MAX
                        ? hold.target
                        : point_on(world, a.slots[hold.partner], hold.held_anchor);
    hold.gap_before = to - at;
    hold.residual = glm::length(hold.gap_before);
    if (hold.held_pin == UINT32_MAX) continue;
    Pin& pin = world.pins.values()[hold.held_pin];
    pin.residual = hold.residual, pin.reachable = hold.reachable;
    pin.missed = pin.grip == Grip::exact && pin.residual > a.settings.tolerance * a.size;
  }
  for (const Tree& t : a.trees) {
    if (t.held_pin == UINT32_MAX) continue;
    Pin& pin = world.pins.values()[t.held_pin];
    const Vec3 at = point_on(world, a.slots[t.first], pin.anchor);
    pin.residual = glm::length(t.target - at), pin.reachable = true;
    pin.missed = pin.residual > a.settings.tolerance * a.size;
  }
  for (const Cord& cord : a.cords)
    world.strings.values()[cord.string].tension = to_force * cord.load;
}

}  // namespace

Packed packed(World& world, Island& a) {
  return {a.count(),
          a.slots.data(),
          a.parents.data(),
          reinterpret_cast<Real*>(world.bodies.values().data()),
          kLayout,
          a.constants.data(),
          a.memory.data(),
          a.room.work.data(),
          a.room.nodes.data(),
          a.forced ? a.room.forces.data() : nullptr,
          a.is_chain};
}

Vec3 point_at(const Island& a, std::size_t column, Vec3 anchor, Work position_row,
              Work rotation_row) {
  return a.room.work.vec(position_row, column) + a.room.work.quat(rotation_row, column) * anchor;
}

Vec3 point_on(const World& world, std::uint32_t slot, Vec3 anchor) {
  return to_world(world.bodies.values()[slot].pose, anchor);
}

namespace {

/// Room for the general solve; made when a step first needs it.
void make_room_for_passes(Island& a) {
  StepScratch& r = a.room;
  const std::size_t n = a.count(), rows = 3 * a.holds.size() + a.cords.size();
  if (r.forces_in.empty() && a.iterates) r.forces_in.assign(n, {}), r.torques_in.assign(n, {});
  if (r.joint_nodes.size() == n) return;
  r.joint_nodes.assign(n, {}), r.base.assign(n, {}), r.joint_blocks.assign(n, {});
  r.terms.assign(a.joints.empty() ? 0 : n, {});
  r.slide.assign(n, Vec3(0)), r.turn.assign(n, Vec3(0)), r.levers.assign(n, Vec3(0));
  r.gaps.assign(n, Vec3(0)), r.loads.assign(n, Vec3(0));
  r.rotations.assign(n, kNoTurn);
  if (rows == 0) return;
  r.forces_in.assign(n, {}), r.torques_in.assign(n, {});
  r.on_path.assign(std::max(n, rows), 0);
  r.rows.reserve(rows), r.response.assign(rows * rows, 0);
  r.factor.assign(rows * rows, 0), r.solved.assign(rows, 0);
}

bool has_free_tree(const Island& a) {
  return std::any_of(a.trees.begin(), a.trees.end(),
                     [&](const Tree& t) { return a.parents[t.first] == kFree; });
}

bool touches_anything(const World& world, const Island& a) {
  return std::any_of(a.bodies.begin(), a.bodies.end(),
                     [&](Entity e) { return world.collisions.find(e) != nullptr; });
}

}  // namespace

void prepare(World& world) {
  for (Island& a : islands_of(world)) {
    if (a.room.targets.capacity() > 0) continue;  // a copy brings no scratch along
    const std::size_t n = a.count(), padded = a.slots.size();
    const bool shake = a.settings.solver == Solver::shake2;
    StepScratch& r = a.room;
    r.work.resize(kWorkRows, n);
    for (std::size_t c = n; c < padded; ++c) r.work.at(kTurn + 3, c) = 1;  // padding turns nowhere
    r.nodes.assign(kNodeSize * n, 0);
    r.targets.reserve(3 * a.trees.size());
    if (!world.forces.empty()) r.forces.resize(6, n);
    if (!a.is_chain || shake) r.blocks.assign(kBlockSize * n, 0);
    if (shake) r.slide.assign(n, Vec3(0)), r.turn.assign(n, Vec3(0));
    if (shake || has_free_tree(a)) r.loads.assign(n, Vec3(0));  // also outboard masses
    if (has_rows(a) || !a.joints.empty()) make_room_for_passes(a);
    if (!world.collisions.empty() && touches_anything(world, a)) {
      r.touches.reserve(8 * n);
      make_room_for_passes(a);
    }
  }
}

bool is_stirred(const World& world, const Island& a) {
  if (world.gravity != a.resting_in) return true;
  for (const Tree& t : a.trees)
    if (t.target != t.target_before) return true;
  for (const Hold& h : a.holds)
    if (h.target != h.target_before) return true;
  for (const Entity e : a.bodies) {
    const Body& b = world.bodies[e];
    if (b.restart || b.teleport || b.velocity != Vec3(0) || b.spin != Vec3(0)) return true;
    const Force* f = world.forces.find(e);
    if (f && (f->force != Vec3(0) || f->torque != Vec3(0))) return true;
  }
  return false;
}

void stir(World& world, Island& a, Real h) {
  a.resting = false, a.still_for = 0;
  update(world, a, h);
}

/// What does not move is where it is, for others that look for it.
void predict_still(const World& world, Island& a) {
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Pose& pose = world.bodies.values()[a.slots[c]].pose;
    a.room.work.set(kPosition, c, pose.position), a.room.work.set(kRotation, c, pose.rotation);
  }
}

void update(World& world, Island& a, Real h) {
  a.room.predicted = true;
  if (a.unfit) {
    a.finite = false;
    return predict_still(world, a);
  }
  if (a.resting) {
    aim(world, a);
    if (!is_stirred(world, a)) return predict_still(world, a);
    a.resting = false, a.still_for = 0;
  }
  if (!world.forces.empty() && a.room.forces.numbers().empty()) a.room.forces.resize(6, a.count());
  aim(world, a);
  notice_changes(world, a, h);
  collect_forces(world, a);
  a.second_order = a.settings.solver == Solver::automatic && !a.fresh && a.calm_steps >= 2;
  a.force_share = share_of_forces(a, h);
  const Packed p = packed(world, a);
  const StartSums start = kernels().predict(
      p, {h, {world.gravity.x, world.gravity.y, world.gravity.z}, rule_of(a), a.fresh});
  a.energy_before = start.kinetic + start.potential, a.kinetic_before = start.kinetic;
  a.damped = start.damped;
  a.finite = start.finite;
  a.momentum_before = Vec3(start.momentum[0], start.momentum[1], start.momentum[2]);
  if (a.finite && a.settings.solver != Solver::automatic) begin_watch(world, a);
}

void begin_passes(World& world, Island& a, Real h) {
  a.disturbed = a.limited = false;
  a.rounds_used = a.passes_used = a.stops_hit = a.drives_capped = 0;
  a.stop_work = 0, a.iterates = false;
  if (!a.finite || a.settings.solver != Solver::automatic || is_plain(a)) return;
  make_room_for_passes(a);
  const bool tension = a.settings.tension_stiffness;
  kernels().prepare(packed(world, a), kPosition, kRotation, false);
  if (!a.joints.empty()) set_terms(world, a, h, kRotation, false);
  keep_gaps(a);
  fill_base(a, tension);
  if (tension) add_string_stiffness(world, a, a.room.base, kPosition, kRotation);
  aim_touches(world, a, h);
  if (!a.joints.empty() && touches_bear(world, a)) soften_stops(a);
}

namespace {

bool takes_passes(const Island& a) {
  return a.finite && a.settings.solver == Solver::automatic && !is_plain(a);
}

}  // namespace

void begin_iterating(World& world, Island& a) {
  if (a.iterates || !takes_passes(a)) return;
  a.iterates = true;
  make_room_for_passes(a);
  for (std::size_t c = 0; c < a.joints.size(); ++c)
    for (Stop& stop : a.room.terms[c].stops) {
      stop.bend = 0;
      if (stop.both_ways) continue;
      stop.on = false, stop.weight = 0;
      stop.load = std::max(Real(0), a.joint_memory[c].loads[&stop - a.room.terms[c].stops]);
    }
  for (Touch& t : a.room.touches) {
    t.bend = Vec3(0);
    if (t.side > 0) contacts_of(world)[t.contact].load = contacts_of(world)[t.contact].before;
  }
}

void begin_pass(World& world, Island& a, Real h) {
  if (!takes_passes(a)) return;
  ++a.passes_used;
  gather_once(world, a, h);
  answer_freely(a, kPosition);
  find_load_response(world, a);
}

bool end_pass(World& world, Island& a, Real h) {
  if (!takes_passes(a)) return true;
  add_iterated_loads(world, a);
  return close_once(world, a, h);
}

void iterate_mutual(World& world, Real h) {
  std::vector<Island*>& all = world.memory.of<Islands>().scratch.mutual;
  all.clear();
  for (Island& a : islands_of(world))
    if (a.mutual && takes_passes(a)) all.push_back(&a);
  iterate_loads(world, all, h, 100, 1e-9);
}

namespace {

/// Free ball joints alone: everything in one go.
EndSums close_plain(Island& a, const Packed& p, const FinishInput& in) {
  const Kernels& k = kernels();
  if (p.is_chain) {
    k.gather_chain(p, a.settings.tension_stiffness);
  } else {
    k.prepare(p, kPosition, kRotation, a.settings.tension_stiffness);
    k.fill_blocks(p, a.room.blocks.data());
    k.gather_tree(p, a.settings.tension_stiffness, a.room.blocks.data());
  }
  return k.close_and_finish(p, a.room.targets.data(), in);
}

/// Stops and drives after the last pass: what they bear is remembered, and told.
void finish_joints(Island& a, Real h) {
  for (std::size_t c = 0; c < a.joints.size(); ++c) {
    const PackedJoint& j = a.joints[c];
    if (!j.stiff) continue;
    bool hit = false;
    for (int s = 0; s < 4; ++s) {
      const Stop& stop = a.room.terms[c].stops[s];
      const bool bears = stop.on || (a.iterates && stop.load > 0);
      a.joint_memory[c].loads[s] = bears ? stop.load : 0;
      hit = hit || (bears && !stop.both_ways);
    }
    a.stops_hit += hit;
    a.drives_capped += j.drive != UINT32_MAX && a.joint_memory[c].share < 1;
    a.stop_work += work_of_springs(a, c, h);
  }
}

/// The kinetic and potential energy and the momentum of the bodies as they stand.
void sum_up(const World& world, const Island& a, EndSums& end) {
  end.kinetic = end.potential = 0;
  Vec3 momentum(0);
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    momentum += b.mass * b.velocity;
    const Vec3 w = glm::conjugate(b.pose.rotation) * b.spin;
    end.kinetic += 0.5 * (b.mass * glm::dot(b.velocity, b.velocity) + glm::dot(b.inertia, w * w));
    end.potential -= b.mass * b.gravity_scale * glm::dot(world.gravity, b.pose.position);
  }
  for (int n = 0; n < 3; ++n) end.momentum[n] = momentum[n];
}

}  // namespace

namespace {

constexpr Real kRestAfter = 0.5;  // s

/// Does it lie on others, without moving, long enough to be let lie? What touches other dynamic
/// bodies, or has muscles or strings, does not.
void notice_rest(World& world, Island& a, Real h) {
  const Real slow = a.settings.rest_speed;
  bool still = a.bears && !a.mutual && a.cords.empty();
  for (std::size_t c = 0; still && c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    still = glm::length(b.velocity) < slow && glm::length(b.spin) < 10 * slow;
    still = still && (a.joints.empty() || a.joints[c].drive == UINT32_MAX);
  }
  a.still_for = still ? a.still_for + h : 0;
  a.resting = a.still_for > kRestAfter;
  if (!a.resting) return;
  a.resting_in = world.gravity;
  for (std::uint32_t c = 0; c < a.count(); ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    b.velocity = b.spin = Vec3(0);
    a.memory.set(kLastSlide, c, Vec3(0)), a.memory.set(kLastTurn, c, Vec3(0));
    a.memory.set(kVelocityBefore, c, Vec3(0)), a.memory.set(kSpinMomentumBefore, c, Vec3(0));
  }
}

}  // namespace

namespace {

/// A solve among contacts or stops that ends nowhere (loads that no iteration could reconcile) moves
/// nothing: the bodies stay where they were, at rest, and the loads are forgotten. What flies free
/// goes on with the motion of its mass centre, left in `drift` (m/s). Counts as limited.
bool stays(World& world, Island& a, Real h, Vec3& drift) {
  Real fastest = 0, farthest = 0;
  bool finite = true, flies = a.room.touches.empty() && a.cords.empty() && a.holds.empty();
  for (const Tree& t : a.trees) flies = flies && a.parents[t.first] == kFree;
  drift = flies ? a.momentum_before / a.mass + h * world.gravity : Vec3(0);
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    const Vec3 x = a.room.work.vec(kFinalPosition, c);
    finite = finite && is_finite(x) && is_finite(a.room.work.quat(kFinalRotation, c));
    fastest = std::max(fastest, glm::length(b.velocity));
    farthest = std::max(farthest, glm::length(x - b.pose.position));
  }
  if (finite && farthest < 10 * a.size + 10 * h * fastest) return false;
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    a.room.work.set(kFinalPosition, c, b.pose.position + h * drift);
    a.room.work.set(kFinalRotation, c, b.pose.rotation);
    a.memory.set(kLoad, c, Vec3(0));
  }
  for (const Touch& t : a.room.touches) {
    Contact& contact = contacts_of(world)[t.contact];
    if (t.side > 0) contact.load = contact.force = Vec3(0), contact.active = false;
  }
  for (JointMemory& j : a.joint_memory) std::fill(std::begin(j.loads), std::end(j.loads), 0);
  return true;
}

}  // namespace

bool finish_passes(World& world, Island& a, Real h, Entity& lost) {
  if (!a.finite) {  // joints could hide it
    lost = a.unfit ? a.unfit : find_lost(world, a);
    return false;
  }
  const Packed p = packed(world, a);
  const Kernels& k = kernels();
  const Solver solver = a.settings.solver;
  FinishInput in{h,
                 {world.gravity.x, world.gravity.y, world.gravity.z},
                 rule_of(a),
                 a.fresh,
                 a.settings.calm_angle};
  const bool one_held_tree = a.trees.size() == 1 && a.parents.front() == kHeld;
  a.touching = a.bears = false;
  EndSums end;
  if (is_plain(a) && solver == Solver::automatic) {
    end = close_plain(a, p, in);
  } else if (is_plain(a) && solver == Solver::sweep && one_held_tree) {
    end = k.sweep_and_finish(p, a.room.targets.data(), a.settings.turn_stiffness, in);
  } else {
    if (solver == Solver::automatic) {
      if (has_rows(a)) close_rows(world, a, h);
      if (!a.joints.empty()) finish_joints(a, h);
      a.bears = touches_bear(world, a);
      a.touching = a.stops_hit > 0 || a.bears;
    } else if (solver == Solver::shake2) {
      close_shake(world, a, p, h);
    } else {
      close_kinematic(a, p, h);
    }
    if (!a.joints.empty() && solver != Solver::automatic) sweep_closed(world, a);
    if (has_rows(a)) relax(world, a, solver != Solver::automatic);
    if (!a.room.touches.empty()) push_out_trees(world, a);
    Vec3 drift(0);
    const bool may_stay = solver == Solver::automatic && (!a.room.touches.empty() || a.touching);
    const bool stayed = may_stay && stays(world, a, h, drift);
    if (stayed) a.touching = a.limited = true;
    // What strikes a stop or the ground stops there: no rule that looks farther back than the step.
    if (a.touching) a.disturbed = true;
    if (a.touching && solver == Solver::automatic) {
      in.rule = Rule::euler, in.first = false;
      a.second_order = a.fresh = false;
    }
    end = k.finish(p, in);
    if (stayed) {
      k.scale(p, 0, &drift[0]);
      end.kinetic = 0.5 * a.mass * glm::dot(drift, drift);
    }
  }
  if (!end.sane) {
    lost = find_lost(world, a);
    return false;
  }
  // Near others nothing is moved that was just kept apart from them; what they did to the angular
  // momentum is not to be given back later.
  if (a.room.touches.empty()) {
    if (repair_momentum(world, a, h)) sum_up(world, a, end);
  } else {
    for (Tree& t : a.trees) t.keeps_spin = false;
  }
  if (!a.room.touches.empty()) a.stop_work += finish_touches(world, a, h);
  const bool small_turns = end.largest_turn2 < a.settings.calm_angle * a.settings.calm_angle;
  a.disturbed = a.disturbed || !small_turns;
  if (solver == Solver::automatic)
    limit_energy(world, a, p, end, h);
  else
    end_watch(world, a, h);
  const bool calm = !a.limited && !a.disturbed;
  a.calm_steps = calm ? std::min(a.calm_steps + 1, 1000) : 0;
  if (has_rows(a) || a.trees.front().held_pin != UINT32_MAX) report_holds(world, a, h);
  for (std::size_t c = 0; a.changed && c < a.count(); ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    b.restart = b.teleport = false;
  }
  a.fresh = false;
  a.last_step = h;
  notice_rest(world, a, h);
  return true;
}

namespace {

/// After a wrong guess the next steps do not guess.
constexpr int kStepsIterating = 4;
/// Passes that guess cost a tenth of one that iterates.
constexpr int kGuesses = 8;
/// Passes are counted from the third when they iterate; more of them make nothing better.
constexpr int kIterations = 4;
/// With more contacts than this, iterating costs more than taking the step in parts.
constexpr std::ptrdiff_t kFewContacts = 24;
/// A step that does not settle is taken again in so many parts.
constexpr int kParts = 4;

std::ptrdiff_t bearing(const World& world, const Island& a) {
  return std::count_if(a.room.touches.begin(), a.room.touches.end(),
                       [&](const Touch& t) { return contacts_of(world)[t.contact].active; });
}

/// Passes from the predicted poses, until nothing changes. False if they run out before.
bool take_passes(World& world, Island& a, Real h, bool in_parts) {
  bool settled = !takes_passes(a);
  // Mostly the stops and contacts that bore in the last step bear in this one, and one pass, two
  // at most, confirm it. Otherwise their loads are iterated.
  const bool few = in_parts || bearing(world, a) <= kFewContacts;
  const int guesses = few && a.iterating > 0 ? 0 : a.settings.passes <= 2 ? a.settings.passes : kGuesses;
  for (int n = 0; n < guesses && !settled; ++n) {
    ++a.passes_used;
    gather_once(world, a, h);
    settled = close_once(world, a, h);
  }
  a.iterating = settled ? 0 : a.iterating > 0 ? a.iterating - 1 : kStepsIterating;
  if (settled || a.settings.passes <= 2) return settled;
  if (!in_parts && bearing(world, a) > kFewContacts) return false;
  begin_iterating(world, a);
  for (int n = 2; n < std::min(kIterations, a.settings.passes) && !settled; ++n) {
    begin_pass(world, a, h);
    Island* const alone[] = {&a};
    iterate_loads(world, alone, h, 100, 1e-8);
    settled = end_pass(world, a, h);
  }
  return settled;
}

/// The same step once more, in equal parts: what turns too far for one settles in several.
bool adjust_in_parts(World& world, Island& a, Real h, Entity& lost) {
  for (const Touch& t : a.room.touches)
    if (t.side > 0) contacts_of(world)[t.contact].load = contacts_of(world)[t.contact].before;
  int passes = a.passes_used;
  bool sound = true;
  const std::vector<Tree> trees = a.trees;  // where this step brings them
  for (int part = 1; part <= kParts && sound; ++part) {
    a.parts_left = kParts - part;
    update(world, a, h / kParts);
    for (std::size_t t = 0; t < trees.size(); ++t) {
      const Vec3 whole = trees[t].target - trees[t].target_before;
      a.trees[t].target = trees[t].target_before + Real(part) / kParts * whole;
      a.trees[t].target_before = a.trees[t].target - whole / Real(kParts);
      for (std::size_t n = 0; n < 3; ++n)
        a.room.targets[3 * t + n] = a.trees[t].target[static_cast<int>(n)];
    }
    begin_passes(world, a, h / kParts);
    take_passes(world, a, h / kParts, true);
    passes += a.passes_used;
    sound = finish_passes(world, a, h / kParts, lost);
  }
  a.passes_used = passes, a.parts_left = 0;
  return sound;
}

}  // namespace

bool adjust(World& world, Island& a, Real h, Entity& lost) {
  if (a.resting) {
    keep_touches(world, a, h);
    return true;
  }
  begin_passes(world, a, h);
  const bool settled = take_passes(world, a, h, false);
  if (!settled && !a.room.touches.empty() && a.settings.passes > 2)
    return adjust_in_parts(world, a, h, lost);
  return finish_passes(world, a, h, lost);
}

}  // namespace pantin::articulated
