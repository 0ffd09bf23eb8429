#include <algorithm>
#include <cstddef>

#include "engine/solvers/procedural/internal.hpp"
#include "engine/solvers/procedural/procedural.hpp"

namespace pantin::procedural {
namespace {

constexpr std::size_t words(std::size_t bytes) { return bytes / sizeof(Real); }

static_assert(sizeof(Body) % sizeof(Real) == 0);
static_assert(offsetof(Quat, x) == 0 && offsetof(Quat, w) == 3 * sizeof(Real));

const BodyLayout kLayout{words(sizeof(Body)), words(offsetof(Body, pose.position)),
                         words(offsetof(Body, pose.rotation)), words(offsetof(Body, velocity)),
                         words(offsetof(Body, spin))};

/// Where roots and holds are to be, from pins and from bodies that are moved otherwise.
void aim(const World& world, Articulation& a) {
  a.room.targets.clear();
  const auto place = [&](std::uint32_t body, std::uint32_t pin, Vec3 anchor) {
    return pin != UINT32_MAX ? world.pins.values()[pin].target : point_on(world, body, anchor);
  };
  for (Tree& t : a.trees) {
    if (a.parents[t.first] == kHeld) {
      const Vec3 now = place(t.held_body, t.held_pin, t.anchor);
      t.target_before = a.aimed ? t.target : now, t.target = now;
    }
    for (int n = 0; n < 3; ++n) a.room.targets.push_back(t.target[n]);
  }
  for (Hold& h : a.holds) {
    const Vec3 now = place(h.held_body, h.held_pin, h.held_anchor);
    h.target_before = a.aimed ? h.target : now, h.target = now;
    if (!a.aimed) h.gap_before = h.target - point_on(world, a.slots[h.column], h.anchor);
  }
  a.aimed = true;
}

/// Bodies whose motion was changed by hand: forget what no longer holds.
void notice_changes(World& world, Articulation& a, Real h) {
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

void collect_forces(const World& world, Articulation& a) {
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
Real share_of_forces(const Articulation& a, Real h) {
  if (a.fresh) return 0.5;
  if (!a.second_order) return 1;
  Real mass = 0, drag = 0;
  for (std::size_t c = 0; c < a.count(); ++c)
    mass += a.constants.at(kMass, c), drag += a.constants.at(kMass, c) * a.constants.at(kDrag, c);
  return 4.0 / 9 / (1 + 2.0 / 3 * h * drag / mass);
}

Rule rule_of(const Articulation& a) {
  const Solver s = a.settings.solver;
  if (s == Solver::sweep || s == Solver::paper) return Rule::verlet;
  if (s == Solver::shake2) return Rule::midpoint;
  return a.second_order ? Rule::bdf2 : Rule::euler;
}

/// Joints closed by articulated masses, strings and reachable held points as rows of the solve.
void close_with_rows(World& world, Articulation& a, const Packed& p, Real h) {
  const Kernels& k = kernels();
  k.prepare(p, kPosition, kRotation, a.settings.tension_stiffness);
  k.fill_blocks(p, a.room.blocks.data());
  if (a.settings.tension_stiffness) add_string_stiffness(world, a, kPosition, kRotation);
  k.gather_tree(p, a.settings.tension_stiffness, a.room.blocks.data());
  solve_rows(world, a, h, kPosition, kRotation, false);
  k.close(p, a.room.targets.data(), kPosition);
  k.commit(p, kRotation);

  // Strings are met to first order; what the turning of the bodies left is closed again.
  const Real enough = 0.1 * a.settings.tolerance * a.size;
  for (int round = 0; round < a.settings.rounds && worst_stretch(world, a) > enough; ++round) {
    for (std::size_t c = 0; c < a.count(); ++c) a.room.loads[c] = a.memory.vec(kLoad, c);
    k.prepare(p, kFinalPosition, kFinalRotation, false);
    k.fill_blocks(p, a.room.blocks.data());
    k.gather_tree(p, false, a.room.blocks.data());
    solve_rows(world, a, h, kFinalPosition, kFinalRotation, true);
    k.close(p, a.room.targets.data(), kFinalPosition);
    k.commit(p, kFinalRotation);
    for (std::size_t c = 0; c < a.count(); ++c)
      a.memory.set(kLoad, c, a.memory.vec(kLoad, c) + a.room.loads[c]);
  }
}

/// Joints closed one after the other, as if what is nearer the root could not give way.
void close_kinematic(Articulation& a, const Packed& p, Real h) {
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
Entity find_lost(const World& world, const Articulation& a) {
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
void report_holds(World& world, Articulation& a, Real h) {
  const Real to_force = 1 / (a.force_share * h * h);
  for (Hold& hold : a.holds) {
    const Vec3 at = point_on(world, a.slots[hold.column], hold.anchor);
    hold.gap_before = hold.target - at;
    hold.residual = glm::length(hold.gap_before);
    if (hold.held_pin == UINT32_MAX) continue;
    Pin& pin = world.pins.values()[hold.held_pin];
    pin.residual = hold.residual, pin.reachable = hold.reachable;
  }
  for (const Tree& t : a.trees) {
    if (t.held_pin == UINT32_MAX) continue;
    Pin& pin = world.pins.values()[t.held_pin];
    const Vec3 at = point_on(world, a.slots[t.first], pin.anchor);
    pin.residual = glm::length(pin.target - at), pin.reachable = true;
  }
  for (const Cord& cord : a.cords)
    world.strings.values()[cord.string].tension = to_force * cord.load;
}

}  // namespace

Packed packed(World& world, Articulation& a) {
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
          a.room.inverse.empty() ? nullptr : a.room.inverse.data(),
          a.is_chain && a.room.inverse.empty() && a.settings.solver != Solver::shake2};
}

Vec3 point_at(const Articulation& a, std::size_t column, Vec3 anchor, Work position_row,
              Work rotation_row) {
  return a.room.work.vec(position_row, column) + a.room.work.quat(rotation_row, column) * anchor;
}

Vec3 point_on(const World& world, std::uint32_t slot, Vec3 anchor) {
  return to_world(world.bodies.values()[slot].pose, anchor);
}

void prepare(World& world) {
  for (Articulation& a : world.articulations) {
    const std::size_t n = a.count(), padded = a.slots.size();
    const std::size_t rows = 3 * a.holds.size() + a.cords.size();
    const bool tree = !a.is_chain || rows > 0 || a.settings.solver == Solver::shake2;
    StepRoom& r = a.room;
    r.work.resize(kWorkRows, n);
    for (std::size_t c = n; c < padded; ++c) r.work.at(kTurn + 3, c) = 1;  // padding turns nowhere
    r.nodes.assign(kNodeSize * n, 0);
    r.targets.reserve(3 * a.trees.size());
    if (!world.forces.empty()) r.forces.resize(6, n);
    if (tree) r.blocks.assign(kBlockSize * n, 0);
    if (tree) r.slide.assign(n, Vec3(0)), r.turn.assign(n, Vec3(0));
    if (tree || a.parents.front() == kFree) r.loads.assign(n, Vec3(0));  // also outboard masses
    if (rows > 0) {
      r.levers.assign(n, Vec3(0));
      r.inverse.assign(6 * n, 0), r.on_path.assign(std::max(n, rows), 0);
      r.rows.reserve(rows), r.response.assign(rows * rows, 0);
      r.factor.assign(rows * rows, 0), r.solved.assign(rows, 0);
    }
  }
}

void update(World& world, Articulation& a, Real h) {
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
}

bool adjust(World& world, Articulation& a, Real h, Entity& lost) {
  if (!a.finite) {  // joints could hide it
    lost = find_lost(world, a);
    return false;
  }
  const Packed p = packed(world, a);
  const Kernels& k = kernels();
  const Solver solver = a.settings.solver;
  a.disturbed = a.limited = false;
  a.rounds_used = 0;
  const FinishInput in{h,
                       {world.gravity.x, world.gravity.y, world.gravity.z},
                       rule_of(a),
                       a.fresh,
                       a.settings.calm_angle};
  const Real* targets = a.room.targets.data();
  const bool rows = !a.holds.empty() || !a.cords.empty();
  const bool one_held_tree = a.trees.size() == 1 && a.parents.front() == kHeld;
  EndSums end;
  if (solver == Solver::automatic && !rows) {
    if (p.is_chain) {
      k.gather_chain(p, a.settings.tension_stiffness);
    } else {
      k.prepare(p, kPosition, kRotation, a.settings.tension_stiffness);
      k.fill_blocks(p, a.room.blocks.data());
      k.gather_tree(p, a.settings.tension_stiffness, a.room.blocks.data());
    }
    end = k.close_and_finish(p, targets, in);
  } else if (solver == Solver::sweep && !rows && one_held_tree) {
    end = k.sweep_and_finish(p, targets, a.settings.turn_stiffness, in);
  } else {
    if (solver == Solver::automatic)
      close_with_rows(world, a, p, h);
    else if (solver == Solver::shake2)
      close_shake(world, a, p, h);
    else
      close_kinematic(a, p, h);
    if (rows) relax(world, a, solver != Solver::automatic);
    end = k.finish(p, in);
  }
  if (!end.sane) {
    lost = find_lost(world, a);
    return false;
  }
  if (repair_momentum(world, a, h)) {
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
  const bool small_turns = end.largest_turn2 < a.settings.calm_angle * a.settings.calm_angle;
  a.disturbed = a.disturbed || !small_turns;
  if (solver == Solver::automatic) limit_energy(world, a, p, end, h);
  const bool calm = !a.limited && !a.disturbed;
  a.calm_steps = calm ? std::min(a.calm_steps + 1, 1000) : 0;
  if (rows || a.trees.front().held_pin != UINT32_MAX) report_holds(world, a, h);
  for (std::size_t c = 0; a.changed && c < a.count(); ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    b.restart = b.teleport = false;
  }
  a.fresh = false;
  a.last_step = h;
  return true;
}

}  // namespace pantin::procedural
