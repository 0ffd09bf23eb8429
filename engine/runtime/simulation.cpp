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
void drive(World& world, Real h) {
  const Real until = world.time + h;
  for (std::size_t i = 0; i < world.drives.size(); ++i) {
    Body* b = world.bodies.find(world.drives.owners()[i]);
    if (!b || b->motion != Motion::driven) continue;
    const Pose to = pose_at(world.drives.values()[i], until);
    b->velocity = (to.position - b->pose.position) / h;
    b->spin = spin_between(b->pose.rotation, to.rotation, h);
    b->pose = to;
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

StepReport step_world(World& world, const StepSettings& settings, const Systems& systems,
                      StageTimes* times, std::span<Pose> drawn_from) noexcept {
  StepReport report;
  report.tick = world.tick, report.time = world.time;
  const int substeps = std::max(1, settings.substeps);
  const Real h = settings.h / substeps;
  if (!(h > 0) || !std::isfinite(h)) return report;
  rebuild_if_changed(world);
  std::vector<Articulation>& all = world.articulations;
  StageTimes ignored;
  StageTimes& clock = times ? *times : ignored;
  const auto run = [&](Place place) { run_systems(systems, place, world, settings.h, report); };

  for (int part = 0; part < substeps; ++part) {
    Stopwatch watch(times != nullptr);
    run(Place::before_drive);
    drive(world, h);
    rebuild_if_changed(world);
    watch.lap(clock.drive);

    run(Place::before_update);
    note_teleports(world, drawn_from);
    for_each_articulation(world.mechanisms.size(), settings.threads, [&](std::size_t i) {
      if (!is_coupled(world.mechanisms[i])) lagrangian::step(world, world.mechanisms[i], h);
    });
    begin_coupled(world);
    for_each_articulation(all.size(), settings.threads,
                          [&](std::size_t i) { procedural::update(world, all[i], h); });
    watch.lap(clock.update);

    run(Place::before_touch);
    procedural::touch(world, h);
    watch.lap(clock.touch);

    run(Place::before_adjust);
    for_each_articulation(all.size(), settings.threads, [&](std::size_t i) {
      all[i].lost = Entity{};
      if (!all[i].mutual && !steps_coupled(world, i))
        procedural::adjust(world, all[i], h, all[i].lost);
    });
    step_coupled(world, h);
    adjust_mutual(world, settings.threads, h);
    settle_mutual(world, h);
    if (!world.mechanisms.empty()) procedural::tell_pressures(world);
    watch.lap(clock.adjust);
    world.time += h;
  }
  ++world.tick;
  for (Force& f : world.forces.values()) f = Force{};
  for (std::uint32_t slot : world.kinematic) {
    Body& b = world.bodies.values()[slot];
    b.restart = b.teleport = false;
  }

  Stopwatch watch(times != nullptr);
  run(Place::before_measure);
  for (const Mechanism& m : world.mechanisms) {
    if (!m.lost || m.cannot_close || report.status == Status::diverged) continue;
    report.status = Status::diverged, report.body = m.lost, report.residual = m.residual;
  }
  for (const Articulation& a : all) {
    if (!a.lost || report.status == Status::diverged) continue;
    report.status = Status::diverged, report.body = a.lost;
    report.residual = pantin::measure(world).worst_gap;
  }
  collect(world, report);
  if (settings.measure) report.measures = measure(world), report.measured = true;
  watch.lap(clock.measure);
  report.tick = world.tick, report.time = world.time;
  run(Place::after_step);
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
