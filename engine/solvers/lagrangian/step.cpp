// One step: reads the bodies, integrates, writes them back.
#include <algorithm>
#include <utility>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/lagrangian/integrator.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/solvers/lagrangian/radau.hpp"
#include "engine/solvers/lagrangian/surface_spots.hpp"

namespace pantin::detail::lagrangian {
namespace {

void gather(const World& world, Island& m, Real h) {
  Motions& s = m.scratch.state;
  Vec3 low(1e300), high(-1e300);
  for (std::size_t b = 0; b < m.count(); ++b) {
    const Body& body = world.bodies.values()[m.slots[b]];
    s.x[b] = body.pose.position, s.q[b] = body.pose.rotation;
    s.v[b] = body.velocity, s.w[b] = body.angular_velocity;
    low = glm::min(low, s.x[b]), high = glm::max(high, s.x[b]);
    m.fresh = m.fresh || body.restart;
    const Force* f = world.forces.find(m.bodies[b]);
    m.scratch.applied[2 * b] = f ? f->force : Vec3(0);
    m.scratch.applied[2 * b + 1] = f ? f->torque : Vec3(0);
  }
  find_touches(world, m, h);
  m.size = glm::length(high - low), m.reach = 0;
  for (const std::uint32_t source : m.touch_sources) {
    const SurfaceContact& c = world.surface_contacts.values()[source];
    for (const ContactSurface* one : {&c.on_a, &c.on_b})
      m.reach = std::max(m.reach, std::min(glm::length(one->pose.position) +
                                               (one->skin ? one->skin->size() : one->curve->size()),
                                           Real(1e2)));
  }
  for (const Block& b : m.blocks) {
    if (b.kind != BlockKind::joint) continue;
    // World anchors depend on the position, not on the size.
    const Joint& j = world.links.values()[b.source].joint;
    if (b.body[0] < m.count()) m.reach = std::max(m.reach, glm::length(j.anchor_a));
    if (b.body[1] < m.count()) m.reach = std::max(m.reach, glm::length(j.anchor_b));
  }
  m.size = std::max(m.size, m.reach);
}

/// Records the state before the step, for contacts.
void note_entry(Island& m) {
  m.scratch.entry = m.scratch.state;
  PANTIN_ASSERT(m.scratch.frame_starts.size() == m.frames.size());
  for (std::size_t i = 0; i < m.frames.size(); ++i) m.scratch.frame_starts[i] = m.frames[i].start();
}

/// One of the two links that a gear couples; `end` is the index of its bodies in Block::ends.
struct GearSide {
  const Block& block;
  int end;
};
GearSide first_of(const Block& gear) { return {gear, 0}; }
GearSide second_of(const Block& gear) { return {gear, 2}; }

/// A coordinate of a gear, on the revolution nearest to `before`.
Real value_of(const World& world, const Island& m, const GearSide& side, Real before) {
  const auto& [b, end] = side;
  PANTIN_ASSERT(b.kind == BlockKind::gear && (end == 0 || end == 2));
  const Gear& r = world.gears.values()[b.source];
  Real c = 0;
  write_coordinate(
      {world.links[end == 0 ? r.first : r.second].joint, m.scratch.body_states[b.body[b.ends[end]]],
       m.scratch.body_states[b.body[b.ends[end + 1]]], before},
      end == 0 ? b.coordinate : b.second, {&c, nullptr, nullptr});
  return c;
}

}  // namespace

void forget_turns(Island& m) {
  for (BlockMemory& memory : m.memory)
    memory.before[0] = memory.before[1] = 0, memory.counted = false;
  for (JointForce& e : m.joint_forces) e.before = 0;
}

void count_turns(const World& world, Island& m) {
  PANTIN_ASSERT(m.memory.size() == m.blocks.size());
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    Block& b = m.blocks[i];
    Real* before = m.memory[i].before;
    const bool anew = !std::exchange(m.memory[i].counted, true);
    if (b.kind == BlockKind::gear) {
      const Gear& r = world.gears.values()[b.source];
      if (anew && r.has_offset && r.second_travels && r.ratio != 0)
        before[0] = (value_of(world, m, second_of(b), 0) - r.offset) / r.ratio;
      before[0] = value_of(world, m, first_of(b), before[0]);
      if (anew && r.has_offset) before[1] = r.ratio * before[0] + r.offset;
      before[1] = value_of(world, m, second_of(b), before[1]);
      if (anew && !r.has_offset) b.bound = before[1] - r.ratio * before[0];
      continue;
    }
    if (b.kind == BlockKind::belt) {
      const Belt& belt = world.belts.values()[b.source];
      for (std::size_t end = 0; end < 2; ++end) {
        if (anew) before[end] = belt.pulleys[(b.first_place + end) % belt.pulleys.size()].angle;
        before[end] = belt_angle(world, m, {b, end, before[end]});
      }
      continue;
    }
    if (b.kind != BlockKind::joint && b.kind != BlockKind::limit && b.kind != BlockKind::drive &&
        b.kind != BlockKind::spring)
      continue;
    const Joint& joint = world.links.values()[b.source].joint;
    const bool counts = b.kind == BlockKind::joint && info_of(joint.kind).counts_turns;
    if (b.kind == BlockKind::joint && !counts) continue;
    if (!counts && b.coordinate != Coordinate::angle && b.coordinate != Coordinate::second)
      continue;
    const auto value = [&](Coordinate which) {
      Real c = 0;
      write_coordinate(
          {joint, m.scratch.body_states[b.body[0]], m.scratch.body_states[b.body[1]], before[0]},
          which, {&c, nullptr, nullptr});
      return c;
    };
    // The travel of a screw determines its revolutions.
    const Real pitch = info_of(joint.kind).slide_per_turn(joint);
    const bool told = pitch != 0;
    if (anew && told) before[0] = value(Coordinate::travel) / pitch;
    if (anew && !told && b.kind == BlockKind::drive)
      before[0] = m.scratch.body_states[b.body[2]].position.x;
    Real c = value(counts ? Coordinate::angle : b.coordinate);
    if (anew && !told && b.kind == BlockKind::limit && !b.lock) {
      // The range may contain another revolution than the nearest.
      const AngleLimit& range =
          b.coordinate == Coordinate::second ? joint.limits->second : joint.limits->angle;
      const Real middle = 0.5 * (range.low + range.high);
      c = middle + std::remainder(c - middle, 2 * kPi);
    }
    before[0] = c;
  }
  for (JointForce& e : m.joint_forces) e.before = coordinate_row(world, m, e).value;
}

namespace {

/// First step of an island, or first step after a change by the caller: projection onto the
/// constraints.
bool start(const World& world, Island& m, Real h) {
  update_kinematics(m), update_frames(world, m, 0, h);
  count_turns(world, m);
  write_all_rows(world, m, {true, true});
  for (SurfaceCoordinates& touch : m.scratch.state.touches) touch.slip = 0;
  begin_active_set(world, m);
  if (m.unilateral && !m.rubs) resolve_impacts(world, m, Impact::inelastic);
  std::fill(m.mean_lambda.begin(), m.mean_lambda.end(), 0.0);
  if (!project(world, m, 0, h)) return false;
  find_rank(m);
  return true;
}

std::uint32_t worst_block(const Island& m) {
  std::uint32_t worst = 0;
  Real most = -1;
  for (std::uint32_t i = 0; i < m.blocks.size(); ++i)
    for (std::size_t r = 0; r < m.blocks[i].rows && is_active(m, i); ++r)
      if (const Real c = std::abs(m.scratch.c[m.blocks[i].first_row + r]); !(c <= most))
        most = c, worst = i;
  return worst;
}

void allocate_scratch(Island& m) {
  StepScratch& r = m.scratch;
  r.pattern = make_pattern(m, Hubs::allowed);
  const std::size_t bodies = m.count(), all = bodies + m.frames.size();
  r.values.assign(r.pattern.numbers, 0);
  r.scales.assign(m.rows, 1);
  r.body_states.assign(all, {}), r.inverse_inertia.assign(bodies, Mat3(1));
  r.jacobian.assign(m.vectors, Vec3(0)), r.jacobian_before = r.jacobian;
  for (auto* rows :
       {&r.c, &r.gamma, &r.right, &r.lambda, &r.step_lambda, &r.sum_lambda, &r.weights,
        &r.dependence, &r.lambda_before, &r.impulses, &r.impulses_at_start, &r.impulses_before})
    rows->assign(m.rows, 0);
  r.row_residual.assign(r.pattern.unknowns, 0);
  for (auto* twice : {&r.force, &r.solution, &r.applied, &r.momenta, &r.momenta_before,
                      &r.end_accelerations, &r.force_residuals})
    twice->assign(2 * bodies, Vec3(0));
  r.motion.assign(2 * all, Vec3(0));
  r.frame_starts.assign(m.frames.size(), {});
  for (Motions* s : {&r.state, &r.start, &r.from, &r.begin})
    s->x.assign(bodies, {}), s->q.assign(bodies, kIdentity), s->v.assign(bodies, {}),
        s->w.assign(bodies, {}), s->touches.assign(m.touches.size(), {});
  r.touching.assign(m.touches.size(), {});
  const IntegratorRow& by = row_of(m.settings.integrator);
  const bool estimates = by.step_estimated && m.settings.step_tolerance > 0;
  const int stages = estimates        ? by.stages_estimated
                     : by.takes_means ? integrators::rk4.stages
                                      : by.stages;
  PANTIN_ASSERT(static_cast<std::size_t>(stages) <= std::size(r.rates));
  for (int i = 0; i < stages; ++i)
    r.rates[i].assign(3 * bodies, Vec3(0)), r.quat_rates[i].assign(bodies, kIdentity);
  if (by.collocates) allocate_collocation(m);
  allocate_blows(m);
  if (m.driven) static_cast<IslandMemory&>(m.entry_memory) = m;
  m.faults.reserve(2 * m.blocks.size() + m.elastic_paths.size() + 1);
  r.ready = true;
}

enum class Events : bool { none, some };
/// Advances the gathered state. False: failure.
bool take_step(World& world, Island& m, Real h, Events events) {
  const bool begins = m.fresh;
  bool good = all_within_bounds(m) && m.scratch.lost_touch == UINT32_MAX;
  std::fill(m.scratch.impulses.begin(), m.scratch.impulses.end(), 0.0);
  if (good && begins) good = start(world, m, h) && m.scratch.lost_touch == UINT32_MAX;
  std::swap(m.scratch.impulses, m.scratch.blow.at_start);
  if (good) find_following_gaps(world, m, h);
  m.events = 0;
  std::fill(m.scratch.impulses.begin(), m.scratch.impulses.end(), 0.0);
  m.cannot_close = begins && !good && all_within_bounds(m);
  if (good && events == Events::some) {
    good = advance_among_limits(world, m, h);
    if (!good && may_yield(world, m)) return false;
    if (!good && m.scratch.lost_touch == UINT32_MAX) {  // this step ignores limits and cables
      gather(world, m, h);
      for (BlockMemory& memory : m.memory) memory.active = false;
      std::fill(m.scratch.impulses.begin(), m.scratch.impulses.end(), 0.0);
      good = advance(world, m, {0, h, h});
      if (good) m.rescues = std::max(1, m.rescues);
    }
  }
  if (good && events == Events::none) good = advance(world, m, {0, h, h});
  return good && !any_sank(world, m);
}

/// The same, without surface joints that are lost, and with drives that yield.
bool take_whole_step(World& world, Island& m, Real h) {
  const auto take = [&] {
    Events events = m.unilateral ? Events::some : Events::none;
    // A contact that leaves its surface and releases is an event.
    const auto may_try_again = [&] {
      if (events == Events::some || !may_release(world, m)) return release_lost(world, m);
      events = Events::some, m.scratch.lost_touch = UINT32_MAX;
      return true;
    };
    bool good = take_step(world, m, h, events);
    while (!good && may_try_again()) {
      gather(world, m, h);
      good = take_step(world, m, h, events);
    }
    return good;
  };
  if (!m.driven) return take();
  begin_drives(world, m, h);
  IslandMemory &now = m, &before = m.entry_memory;
  before = now;
  bool good = take();
  const auto outcome = [&] { return good ? StepOutcome::taken : StepOutcome::failed; };
  for (std::size_t n = 0; n < m.frames.size() && yield_drives(world, m, h, outcome()); ++n) {
    for (std::size_t i = 0; i < m.frames.size(); ++i) before.frames[i].lag = m.frames[i].lag;
    now = before;
    m.released = 0, m.scratch.worst_relative_residual = 0;
    std::erase_if(m.faults, [](const auto& f) { return f.kind == Fault::inconsistent; });
    gather(world, m, h);
    good = take();
  }
  return good;
}

}  // namespace

void write_back(World& world, const Island& m) {
  const Motions& s = m.scratch.state;
  for (std::size_t b = 0; b < m.count(); ++b) {
    Body& body = world.bodies.values()[m.slots[b]];
    body.pose = {s.x[b], s.q[b]};
    body.velocity = s.v[b], body.angular_velocity = s.w[b];
    body.restart = body.teleport = false;
  }
}

void prepare(World& world) {
  Islands& all = world.memory.of<Islands>();
  if (all.scratch.prepared == all.list.size()) return;
  all.scratch.prepared = all.list.size();
  for (Island& m : all.list)
    if (!m.scratch.ready) allocate_scratch(m);
}

void step(World& world, Island& m, Real h) {
  PANTIN_ASSERT(h > 0);
  m.lost_contact = Entity{}, m.released = 0, m.scratch.lost_touch = UINT32_MAX;
  m.scratch.relooked = m.scratch.turned_over = 0;
  m.lost = Entity{}, m.scratch.worst_relative_residual = 0, m.scratch.stepped = false;
  std::erase_if(m.faults, [](const auto& f) { return f.kind == Fault::inconsistent; });
  m.substeps = m.iterations = m.events = m.solves = 0;
  if (m.unfit) {
    m.lost = m.unfit, m.cannot_close = false;
    return;
  }
  PANTIN_ASSERT(m.scratch.ready);
  gather(world, m, h);
  const bool solid = !world.collisions.empty();
  if (solid) note_entry(m);
  const auto acts = [](Vec3 v) { return v != Vec3(0); };
  m.scratch.pushed = std::any_of(m.scratch.applied.begin(), m.scratch.applied.end(), acts);
  const bool good = take_whole_step(world, m, h);
  const bool open = !good || m.scratch.worst_relative_residual > 1e-2;
  if (open && !m.blocks.empty()) {
    Fault f;
    f.kind = Fault::inconsistent;
    f.block = good ? m.scratch.worst_relative_block : worst_block(m);
    f.residual = good ? m.scratch.worst_relative_residual : m.residual;
    m.faults.push_back(f);
  }
  if (!good) {
    m.lost = m.bodies.front();
    if (const SurfaceContact* c = world.surface_contacts.find(m.lost_contact))
      m.lost = std::find(m.bodies.begin(), m.bodies.end(), c->a) != m.bodies.end() ? c->a : c->b;
    for (std::size_t b = 0; b < m.count() && !m.lost_contact; ++b)
      if (!is_within_bounds(m.scratch.state, b) || !(m.mass[b] > 0) || !(m.inertia[b].x > 0) ||
          !(m.inertia[b].y > 0) || !(m.inertia[b].z > 0) || !is_finite(m.scratch.applied[2 * b]) ||
          !is_finite(m.scratch.applied[2 * b + 1])) {
        m.lost = m.bodies[b];
        break;
      }
    m.fresh = true;
    return;
  }
  for (std::size_t r = 0; r < m.rows; ++r) m.forces[r] = m.scratch.impulses[r] / h;
  count_turns(world, m);
  follow_cables(world, m, h), follow_belts(world, m);
  write_back(world, m), write_back_touches(world, m);
  for (std::size_t i = 0; i < m.frames.size(); ++i) {
    PANTIN_ASSERT(m.count() + i < m.scratch.body_states.size());
    const BodyState& at = m.scratch.body_states[m.count() + i];
    note_end(world, m.frames[i], at);
  }
  m.scratch.stepped = solid;
}

ConstraintWrench joint_wrench(const Island& m, std::size_t block) {
  ConstraintWrench sum;
  if (!m.scratch.ready) return sum;
  PANTIN_ASSERT(block < m.blocks.size() && m.blocks[block].count > 1);
  Vec3 pull[2] = {Vec3(0), Vec3(0)};
  const Block& joint = m.blocks[block];
  // In the step in which it begins to slide, the multipliers are those of before.
  const bool slides = may_slip(joint) && !m.memory[block].active;
  // A joint's limits follow it.
  for (std::size_t i = slides ? block + 1 : block; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    if (i > block && (b.kind != BlockKind::limit || b.source != joint.source)) break;
    add_constraint_force({b, jacobian_of(m, b), 1}, &m.forces[b.first_row], pull);
  }
  if (slides) {
    const SurfaceFound& found = m.scratch.touching[joint.first_place];
    // The mean load of the step; `found` has that of its end.
    const Real grip =
        joint.carrier == UINT32_MAX ? found.grip : std::abs(load_of(m, joint, m.forces));
    const Vec3 rubbed = joint.bound * grip * found.along;
    pull[0] += rubbed, pull[1] += glm::cross(found.arm[1], rubbed);
  }
  sum.force = pull[0], sum.torque = pull[1];
  return sum;
}

Real joint_gap(const World& world, const Island& m, std::size_t block) {
  const auto body_states = [&](Entity e) {
    const Body& b = world.bodies[e];
    return BodyState{b.pose.position, b.pose.rotation, glm::mat3_cast(b.pose.rotation), {}, {}};
  };
  PANTIN_ASSERT(m.blocks[block].kind == BlockKind::joint);
  const Link& link = world.links.values()[m.blocks[block].source];
  Real c[6] = {}, sum = 0;
  write_rows({link.joint, body_states(link.a), body_states(link.b), m.memory[block].before[0]},
             {c, nullptr, nullptr});
  for (const Real x : c) sum += x * x;
  return std::sqrt(sum);
}

void place_for_inspection(const World& world, Island& m, Real h) {
  allocate_scratch(m);
  gather(world, m, h);
  update_kinematics(m), update_frames(world, m, 0, h);
}

std::vector<Fault> inspect(const World& world, std::size_t number) {
  PANTIN_ASSERT(number < islands_of(world).size());
  Island m = islands_of(world)[number];
  constexpr Real kInspectionStep = 1e-3;
  place_for_inspection(world, m, kInspectionStep);
  m.faults.clear();
  const bool closed = start(world, m, kInspectionStep);
  std::vector<Fault> found = m.faults;
  if (!closed) {
    const std::uint32_t worst = worst_block(m);
    for (std::uint32_t i = 0; i < m.blocks.size(); ++i) {
      Real row_residual = 0;
      for (std::size_t r = 0; r < m.blocks[i].rows && is_active(m, i); ++r)
        row_residual = std::max(row_residual, std::abs(m.scratch.c[m.blocks[i].first_row + r]));
      if (i == worst || row_residual > 0.1 * m.residual)
        found.push_back({Fault::inconsistent, i, 0, row_residual});
    }
  }
  for (std::uint32_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    if (b.kind == BlockKind::joint && !on_right_branch(world.links.values()[b.source].joint,
                                                       m.scratch.body_states[b.body[0]].rotation,
                                                       m.scratch.body_states[b.body[1]].rotation))
      found.push_back({Fault::wrong_branch, i, 0, 0});
  }
  return found;
}

}  // namespace pantin::detail::lagrangian
