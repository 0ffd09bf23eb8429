#include "engine/runtime/simulation.hpp"

#include <algorithm>
#include <chrono>

#include "engine/base/rotation.hpp"
#include "engine/runtime/coupling.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/solvers/procedural/procedural.hpp"

#ifdef PANTIN_HAS_TBB
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace pantin {
namespace {

/// Runs `work(i)` for every i below `count`, on `threads` threads; no two i share anything.
template <class Work>
void for_each_articulation(std::size_t count, [[maybe_unused]] int threads, const Work& work) {
#ifdef PANTIN_HAS_TBB
  if (threads > 1 && count > 1) {
    // Asking for more threads than there are cores makes TBB print a warning.
    tbb::task_arena arena(std::min(threads, tbb::this_task_arena::max_concurrency()));
    arena.execute([&] { tbb::parallel_for(std::size_t(0), count, work); });
    return;
  }
#endif
  for (std::size_t i = 0; i < count; ++i) work(i);
}

/// The scene's hands: bodies that follow a path are moved to where it is at the end of the step.
/// Those whose path leads nowhere stay, at rest; the first is told.
void drive(World& world, Real h, StepReport& report) {
  const Real until = world.time + h;
  for (std::size_t i = 0; i < world.drives.size(); ++i) {
    Body* b = world.bodies.find(world.drives.owners()[i]);
    if (!b || b->motion != Motion::driven) continue;
    const Pose to = pose_at(world.drives.values()[i], until);
    const Vec3 velocity = (to.position - b->pose.position) / h;
    const Vec3 spin = spin_between(b->pose.rotation, to.rotation, h);
    if (is_finite(to) && is_finite(velocity) && is_finite(spin)) {
      b->pose = to, b->velocity = velocity, b->spin = spin;
      continue;
    }
    b->velocity = b->spin = Vec3(0);
    if (report.status != Status::diverged)
      report.status = Status::diverged, report.body = world.drives.owners()[i];
  }
}

/// Driven bodies without a path are where they were put by hand, which may be nowhere.
void look_at_hands(const World& world, StepReport& report) {
  for (std::uint32_t slot : world.kinematic) {
    const Body& b = world.bodies.values()[slot];
    if (report.status == Status::diverged || world.is_exact(slot)) return;
    if (is_finite(b.pose) && is_finite(b.velocity) && is_finite(b.spin)) continue;
    report.status = Status::diverged, report.body = world.bodies.owners()[slot];
  }
}

/// Adds the seconds of a stage to its clock, if there is one.
class Stopwatch {
 public:
  explicit Stopwatch(bool on) : on_(on), last_(on ? Clock::now() : Clock::time_point()) {}
  void lap(Real& total) {
    if (!on_) return;
    const Clock::time_point now = Clock::now();
    total += std::chrono::duration<Real>(now - last_).count();
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  bool on_;
  Clock::time_point last_;
};

void run_systems(const Systems& systems, Place place, World& world, Real h, StepReport& report) {
  for (const PlacedSystem& system : systems.at(place)) {
    try {
      system.run(world, h);
    } catch (...) {
      report.status = Status::system_failed;
    }
  }
}

void note_teleports(const World& world, std::span<Pose> drawn_from) {
  const std::size_t count = std::min(drawn_from.size(), world.bodies.size());
  for (std::size_t i = 0; i < count; ++i)
    if (world.bodies.values()[i].teleport) drawn_from[i] = world.bodies.values()[i].pose;
}

void rebuild_if_changed(World& world) {
  if (world.built_for != world.structure()) {
    rebuild_articulations(world);
    procedural::prepare(world), lagrangian::prepare(world);
    return;
  }
  // A copied World brings no scratch along.
  if (!world.articulations.empty() && world.articulations.front().room.targets.capacity() == 0)
    procedural::prepare(world);
  if (!world.mechanisms.empty() && !world.mechanisms.front().room.ready) lagrangian::prepare(world);
}

/// Structural changes between the update and the adjust stage. True if there were any.
bool take_up_changes(World& world, Real h) {
  const bool copied =  // another World was put in this one's place: without its predictions
      std::any_of(world.articulations.begin(), world.articulations.end(),
                  [](const Articulation& a) { return a.room.work.numbers().empty(); });
  if (world.built_for == world.structure() && !copied) return false;
  for (Articulation& a : world.articulations) a.awaits_update |= a.room.work.numbers().empty();
  rebuild_if_changed(world);
  procedural::prepare(world), lagrangian::prepare(world);
  for (Mechanism& m : world.mechanisms) m.sits_out = m.sits_out || m.was == UINT32_MAX || copied;
  renumber_coupled(world);
  for (Articulation& a : world.articulations)
    if (a.awaits_update) procedural::update(world, a, h);
  return true;
}

/// What was pushed before the step acts in all its parts, what systems push in the part that runs.
void begin_forces(World& world) {
  ForceRoom& room = world.force_room;
  room.whole.clear();
  for (std::size_t i = 0; i < world.forces.size(); ++i)
    room.whole.push_back({world.forces.owners()[i], world.forces.values()[i]});
}

/// After the update stage: what comes later acts in the next part.
void note_felt(World& world) {
  ForceRoom& room = world.force_room;
  room.felt.clear();
  for (std::size_t i = 0; i < world.forces.size(); ++i)
    room.felt.push_back({world.forces.owners()[i], world.forces.values()[i]});
}

/// What came too late acts in the next part; after the last one in all parts of the next step, by
/// as much less. `left` is how many parts are to come.
void end_forces(World& world, int left, int parts) {
  ForceRoom& room = world.force_room;
  const auto each = [&](const auto& list, Real sign) {
    for (const auto& [owner, force] : list)
      if (Force* f = world.forces.find(owner))
        f->force += sign * force.force, f->torque += sign * force.torque;
  };
  const auto acted = [](const auto& p) {
    return p.second.force != Vec3(0) || p.second.torque != Vec3(0);
  };
  const bool any = std::any_of(room.felt.begin(), room.felt.end(), acted) ||
                   std::any_of(room.whole.begin(), room.whole.end(), acted);
  if (any) each(room.felt, -1);
  // Not even a number that is none outlives its part.
  for (const auto& [owner, force] : room.felt)
    if (Force* f = world.forces.find(owner);
        f && !(is_finite(force.force) && is_finite(force.torque)))
      *f = Force{};
  if (left > 0) return each(room.whole, 1);
  if (parts > 1)
    for (Force& f : world.forces.values())
      f.force /= static_cast<Real>(parts), f.torque /= static_cast<Real>(parts);
}

/// What the articulations have to say, gathered in their order.
void collect(const World& world, StepReport& report) {
  for (const Articulation& a : world.articulations) {
    report.rounds_used = std::max(report.rounds_used, a.rounds_used);
    report.limited += a.limited;
    report.resting += a.resting;
    report.passes_used = std::max(report.passes_used, a.passes_used);
    report.stops_hit += a.stops_hit, report.drives_capped += a.drives_capped;
    const Real bound = a.settings.tolerance * a.size;
    const auto note = [&](Real residual, Entity who) {
      if (residual > bound) ++report.unreached;
      if (residual > report.worst_residual)
        report.worst_residual = residual, report.worst_hold = who;
    };
    for (const Hold& h : a.holds) {
      if (h.compliance > 0) continue;
      note(h.residual, h.held_pin != UINT32_MAX ? world.pins.owners()[h.held_pin]
                                                : world.links.owners()[h.held_link]);
    }
    for (const Cord& c : a.cords) {
      const String& s = world.strings.values()[c.string];
      if (s.joint.compliance > 0) continue;
      note(stretch(s.joint, world.bodies[s.a].pose, world.bodies[s.b].pose),
           world.strings.owners()[c.string]);
    }
  }
  for (const Mechanism& m : world.mechanisms) {
    report.rows += static_cast<int>(m.equations()), report.rank += static_cast<int>(m.rank);
    report.worst_constraint = std::max(report.worst_constraint, m.residual);
    report.parts = std::max(report.parts, m.parts), report.events += m.events;
    report.rescued += m.rescues > 0;
    for (const MechanismFault& f : m.faults) {
      if (f.kind != MechanismFault::inconsistent || report.status != Status::ok) continue;
      report.status = Status::inconsistent;
      report.worst_hold = joint_of(world, m.blocks[f.block]), report.worst_residual = f.residual;
    }
  }
  report.faults = static_cast<int>(world.faults.size());
  if (report.faults > 0) report.fault = world.faults.front().link;
  for (const Contact& c : world.contacts) {
    report.contacts += c.active;
    report.worst_depth = std::max(report.worst_depth, c.depth);
  }
}

/// Articulations that touch one another are solved side by side, a pass each in turn.
void adjust_mutual(World& world, int threads, Real h) {
  std::vector<Articulation>& all = world.articulations;
  int passes = 0;
  for (const Articulation& a : all)
    if (a.mutual) passes = std::max(passes, a.settings.passes);
  if (passes == 0) return;
  const auto each = [&](const auto& work) {
    for_each_articulation(all.size(), threads, [&](std::size_t i) {
      if (all[i].mutual) work(all[i]);
    });
  };
  each([&](Articulation& a) {
    procedural::begin_passes(world, a, h);
    procedural::begin_iterating(world, a);
  });
  bool settled = false;
  for (int n = 0; n < passes && !settled; ++n) {
    each([&](Articulation& a) { procedural::begin_pass(world, a, h); });
    procedural::iterate_mutual(world, h);
    // Each notes for itself whether it is settled: nothing is shared between threads.
    each([&](Articulation& a) { a.settled = procedural::end_pass(world, a, h); });
    settled = true;
    for (const Articulation& a : all) settled = settled && (!a.mutual || a.settled);
  }
  each([&](Articulation& a) { procedural::finish_passes(world, a, h, a.lost); });
}

}  // namespace

namespace {

/// One step of a world: what all its parts share.
struct Step {
  World& world;
  const StepSettings& settings;
  const Systems& systems;
  StageTimes& clock;
  bool timed;
  std::span<Pose> drawn_from;
  Real h;  // s, of a part
  StepReport report;

  void run(Place place) { run_systems(systems, place, world, settings.h, report); }
};

/// Drive and update stage.
void predict(Step& s) {
  World& world = s.world;
  std::vector<Articulation>& all = world.articulations;
  Stopwatch watch(s.timed);
  drive(world, s.h, s.report);
  rebuild_if_changed(world);
  watch.lap(s.clock.drive);

  s.run(Place::before_update);
  rebuild_if_changed(world);
  look_at_hands(world, s.report);
  note_teleports(world, s.drawn_from);
  for (Mechanism& m : world.mechanisms) m.sits_out = false;
  for_each_articulation(world.mechanisms.size(), s.settings.threads, [&](std::size_t i) {
    if (!is_coupled(world.mechanisms[i])) lagrangian::step(world, world.mechanisms[i], s.h);
  });
  begin_coupled(world);
  for_each_articulation(all.size(), s.settings.threads,
                        [&](std::size_t i) { procedural::update(world, all[i], s.h); });
  note_felt(world);
  watch.lap(s.clock.update);
}

/// Touch and adjust stage.
void close(Step& s) {
  World& world = s.world;
  std::vector<Articulation>& all = world.articulations;
  Stopwatch watch(s.timed);
  s.run(Place::before_touch);
  take_up_changes(world, s.h);
  procedural::touch(world, s.h);
  watch.lap(s.clock.touch);

  s.run(Place::before_adjust);
  if (take_up_changes(world, s.h)) procedural::touch(world, s.h);
  for_each_articulation(all.size(), s.settings.threads, [&](std::size_t i) {
    all[i].lost = Entity{};
    if (!all[i].mutual && !steps_coupled(world, i))
      procedural::adjust(world, all[i], s.h, all[i].lost);
  });
  step_coupled(world, s.h);
  adjust_mutual(world, s.settings.threads, s.h);
  settle_mutual(world, s.h);
  if (!world.mechanisms.empty()) procedural::tell_pressures(world);
  watch.lap(s.clock.adjust);
}

/// What went wrong with an island, the worst first.
void note_failures(const World& world, StepReport& report) {
  for (const Mechanism& m : world.mechanisms) {
    if (!m.lost || m.cannot_close || report.status == Status::diverged) continue;
    report.status = Status::diverged, report.body = m.lost, report.residual = m.residual;
  }
  for (const Articulation& a : world.articulations) {
    if (!a.lost || report.status == Status::diverged) continue;
    report.status = Status::diverged, report.body = a.lost;
    report.residual = pantin::measure(world).worst_gap;
  }
  for (const Articulation& a : world.articulations)
    if (a.grew && report.status == Status::ok)
      report.status = Status::energy_grew, report.body = a.bodies.back();
}

}  // namespace

StepReport step_world(World& world, const StepSettings& settings, const Systems& systems,
                      StageTimes* times, std::span<Pose> drawn_from) noexcept {
  StageTimes ignored;
  const int substeps = std::max(1, settings.substeps);
  Step s{world, settings, systems, times ? *times : ignored, times != nullptr, drawn_from,
         settings.h / substeps, {}};
  StepReport& report = s.report;
  report.tick = world.tick, report.time = world.time;
  if (!(settings.h > 0) || !std::isfinite(settings.h)) return report;
  if (!(s.h >= kShortestStep && s.h <= kLongestStep)) {
    report.status = Status::bad_clock;
    return report;
  }
  rebuild_if_changed(world);
  begin_forces(world);
  bool sound = true;
  for (int part = 0; part < substeps && sound; ++part) {
    s.run(Place::before_drive);
    sound = std::isfinite(world.time);
    if (!sound) break;
    predict(s);
    close(s);
    note_failures(world, report);
    end_forces(world, substeps - part - 1, substeps);
    world.time += s.h;
  }
  if (!sound) {
    rebuild_if_changed(world);
    report.status = Status::bad_clock;
    return report;
  }
  ++world.tick;
  for (std::uint32_t slot : world.kinematic) {
    Body& b = world.bodies.values()[slot];
    b.restart = b.teleport = false;
  }
  collect(world, report);

  Stopwatch watch(times != nullptr);
  s.run(Place::before_measure);
  rebuild_if_changed(world);
  if (settings.measure) report.measures = measure(world), report.measured = true;
  watch.lap(s.clock.measure);
  report.tick = world.tick, report.time = world.time;
  s.run(Place::after_step);
  return report;
}

namespace {

Placed placed(const Body& b) {
  return {b.pose.position, b.pose.rotation, glm::mat3_cast(b.pose.rotation), b.velocity, b.spin};
}

/// Rulers of the joints of a mechanism.
void measure_joints(const World& world, const Mechanism& mechanism, Measures& m) {
  for (std::size_t i = 0; i < mechanism.blocks.size(); ++i) {
    const Block& block = mechanism.blocks[i];
    if (block.kind != BlockKind::joint) continue;
    const Real gap = lagrangian::joint_gap(world, mechanism, i);
    if (gap > m.worst_gap) m.worst_gap = gap, m.worst_link = world.links.owners()[block.source];
    m.worst_gap_rel = std::max(m.worst_gap_rel, gap / std::max(mechanism.size, Real(1e-3)));
  }
  for (const Effort& e : mechanism.efforts) {
    const Link& link = world.links.values()[e.link];
    Real x = 0;
    write_coordinate(link.joint, e.coordinate, placed(world.bodies[link.a]),
                     placed(world.bodies[link.b]), e.before, {&x, nullptr, nullptr});
    const JointExtras& extras = *link.joint.extras;
    const SpringDamper& s =
        e.coordinate == Coordinate::turn ? extras.turn.spring : extras.slide.spring;
    m.elastic += 0.5 * s.stiffness * (x - s.rest) * (x - s.rest);
  }
}

}  // namespace

Measures measure(const World& world) {
  Measures m;
  if (world.built_for != world.structure()) {  // changed since the last step
    World built = world;
    rebuild_articulations(built);
    return measure(built);
  }
  for (const Articulation& a : world.articulations) {
    for (std::size_t c = 0; c < a.count(); ++c) {
      if (a.links[c] == kNoSlot) continue;
      const Link& link = world.links.values()[a.links[c]];
      const Real gap =
          glm::length(residual(link.joint, world.bodies[link.a].pose, world.bodies[link.b].pose));
      if (gap > m.worst_gap) m.worst_gap = gap, m.worst_link = world.links.owners()[a.links[c]];
      m.worst_gap_rel = std::max(m.worst_gap_rel, gap / a.size);
      if (link.joint.kind == JointKind::ball && !link.joint.limits.any()) continue;
      const Quat turn = relative_turn(link.joint, world.bodies[link.a].pose.rotation,
                                      world.bodies[link.b].pose.rotation);
      m.worst_violation = std::max(m.worst_violation, violation(link.joint, turn));
    }
  }
  for (const Mechanism& mechanism : world.mechanisms) measure_joints(world, mechanism, m);
  for (const Body& b : world.bodies.values()) {
    if (b.motion != Motion::dynamic) continue;
    const Vec3 local = glm::conjugate(b.pose.rotation) * b.spin;
    const Vec3 l = b.pose.rotation * (b.inertia * local);
    m.kinetic += 0.5 * (b.mass * glm::dot(b.velocity, b.velocity) + glm::dot(l, b.spin));
    m.potential -= b.mass * b.gravity_scale * glm::dot(world.gravity, b.pose.position);
    m.momentum += b.mass * b.velocity;
    m.spin_momentum += l + b.mass * glm::cross(b.pose.position, b.velocity);
  }
  return m;
}

bool has_threads() {
#ifdef PANTIN_HAS_TBB
  return true;
#else
  return false;
#endif
}

namespace {

Error within_step(const std::string& what) {
  return {"Simulation: found " + what + " within a step, expected it between steps"};
}

}  // namespace

Result<Done> Simulation::insert(Place place, System system) {
  if (stepping_) return within_step("an insertion of a system");
  systems_.insert(place, std::move(system));
  return Done{};
}

Result<Done> Simulation::insert(Place place, SystemOrder order, System system) {
  if (stepping_) return within_step("an insertion of system '" + order.name + "'");
  return systems_.insert(place, std::move(order), std::move(system));
}

Result<Done> Simulation::remove(std::string_view name) {
  const std::string who = "system '" + std::string(name) + "'";
  if (stepping_) return within_step("a removal of " + who);
  if (systems_.remove(name)) return Done{};
  return Error{who + ": found no system of that name to remove"};
}

StepReport Simulation::take_step(std::span<Pose> drawn_from) {
  stepping_ = true;
  const StepReport report =
      step_world(world, settings, systems_, timing ? &times : nullptr, drawn_from);
  stepping_ = false;
  return report;
}

StepReport Simulation::step() { return take_step({}); }

Advance Simulation::advance(Real wall_seconds) {
  Advance done;
  if (std::isfinite(wall_seconds) && wall_seconds > 0) left_over_ += wall_seconds;
  const Real h = settings.h;
  if (!(h > 0) || !std::isfinite(h)) return done;
  while (left_over_ >= h && done.steps < most_steps) {
    before_.clear();
    for (const Body& b : world.bodies.values()) before_.push_back(b.pose);
    before_version_ = world.bodies.version();
    const StepReport report = take_step(before_);
    if (done.report.status == Status::ok) done.report = report;
    left_over_ -= h;
    ++done.steps;
  }
  if (left_over_ >= h) {
    // Whole steps that there is no time for are given up, the part of a step is kept.
    const Real whole = std::floor(left_over_ / h) * h;
    done.dropped = whole;
    left_over_ -= whole;
  }
  done.fraction = std::clamp(left_over_ / h, Real(0), std::nextafter(Real(1), Real(0)));
  return done;
}

Pose Simulation::interpolated(Entity body, Real fraction) const {
  const std::uint32_t slot = world.bodies.slot(body);
  if (slot == kNoSlot) return {};
  const Body& b = world.bodies.values()[slot];
  if (b.teleport || before_version_ != world.bodies.version() || slot >= before_.size())
    return b.pose;
  const Pose& from = before_[slot];
  return {glm::mix(from.position, b.pose.position, fraction),
          glm::slerp(from.rotation, b.pose.rotation, fraction)};
}

}  // namespace pantin
