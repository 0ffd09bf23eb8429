// One step: gather, integrate, stop at limits, project, write back.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/internal.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"

namespace pantin::lagrangian {
namespace {

/// A limit that is overstepped by less is met, m or rad.
constexpr Real kTouch = 1e-9;
/// Slower approaches are not given back, m/s or rad/s.
constexpr Real kQuiet = 1e-3;
constexpr int kMostEvents = 8, kMostSearches = 16, kMostHalvings = 6, kMostSteps = 200000;
/// More steps of the integrator than this make no step: it is given up and told.
constexpr int kMostParts = 1000;
/// Residual that a step of Runge-Kutta may leave to the projection, part of the way of bodies.
constexpr Real kMostOpened = 0.05;
/// Steps that Euler takes before the integrator is tried again.
constexpr int kPatience = 8;
/// Bodies that turn farther in a step, rad, have it halved; not by the implicit integrator.
constexpr Real kMostTurn = 0.5;

/// Bodies that are no more than the mass of what hangs on a point: where it is, moving with it.
void gather_hangings(Mechanism& m, Real h) {
  Motions& s = m.room.state;
  for (Hanging& g : m.hangings) {
    const std::size_t n = g.guess;
    const Vec3 arm = s.q[g.body] * g.anchor;
    s.x[n] = s.x[g.body] + arm, s.q[n] = kNoTurn;
    s.v[n] = s.v[g.body] + glm::cross(s.w[g.body], arm), s.w[n] = Vec3(0);
    // Of what hangs slack, nothing is felt.
    const bool slack = g.kind == BlockKind::string && !g.taut;
    m.mass[n] = (slack ? 1e-6 : 1) * g.mass;
    m.inertia[n] = Vec3(m.mass[n]);
    m.room.applied[2 * n] = g.asked / h;
    m.room.applied[2 * n + 1] = Vec3(0);
    g.start = s.v[n];
  }
}

/// What the mechanism was given at the points where something hangs.
void settle_hangings(Mechanism& m) {
  for (Hanging& g : m.hangings) {
    const Vec3 change = m.room.state.v[g.guess] - g.start;
    g.given = g.asked - m.mass[g.guess] * change;
  }
}

void gather(const World& world, Mechanism& m) {
  Motions& s = m.room.state;
  Vec3 low(1e300), high(-1e300);
  for (std::size_t b = 0; b + m.hangings.size() < m.count(); ++b) {
    const Body& body = world.bodies.values()[m.slots[b]];
    s.x[b] = body.pose.position, s.q[b] = body.pose.rotation;
    s.v[b] = body.velocity, s.w[b] = body.spin;
    low = glm::min(low, s.x[b]), high = glm::max(high, s.x[b]);
    m.fresh = m.fresh || body.restart;
    const Force* f = world.forces.find(m.bodies[b]);
    m.room.applied[2 * b] = f ? f->force : Vec3(0);
    m.room.applied[2 * b + 1] = f ? f->torque : Vec3(0);
  }
  m.size = glm::length(high - low), m.reach = 0;
  for (const Block& b : m.blocks) {
    if (b.kind != BlockKind::joint) continue;
    const Joint& j = world.links.values()[b.source].joint;
    m.reach = std::max({m.reach, glm::length(j.anchor_a), glm::length(j.anchor_b)});
  }
  m.size = std::max(m.size, m.reach);
}

void write_back(World& world, const Mechanism& m) {
  const Motions& s = m.room.state;
  for (std::size_t b = 0; b + m.hangings.size() < m.count(); ++b) {
    Body& body = world.bodies.values()[m.slots[b]];
    body.pose = {s.x[b], s.q[b]};
    body.velocity = s.v[b], body.spin = s.w[b];
    body.restart = body.teleport = false;
  }
}

/// A coordinate that a ratio couples; `end` 0: of its first link, 2: of its second.
Real value_of(const World& world, const Mechanism& m, const Block& b, int end, Real before) {
  const Ratio& r = world.ratios.values()[b.source];
  Real c = 0;
  write_coordinate(world.links[end == 0 ? r.first : r.second].joint,
                   end == 0 ? b.coordinate : b.second, m.room.placed[b.body[b.ends[end]]],
                   m.room.placed[b.body[b.ends[end + 1]]], before, {&c, nullptr, nullptr});
  return c;
}

/// Coordinates as they are now, so that whole turns are counted. `anew`: from the nearest turn, or
/// from the one that the slide of a screw or a rack tells.
void count_turns(const World& world, Mechanism& m, bool anew) {
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    Block& b = m.blocks[i];
    Real* before = m.memory[i].before;
    if (anew) before[0] = before[1] = 0;
    if (b.kind == BlockKind::ratio) {
      const Ratio& r = world.ratios.values()[b.source];
      if (anew && r.has_offset && r.slides_second && r.ratio != 0)
        before[0] = (value_of(world, m, b, 2, 0) - r.offset) / r.ratio;
      before[0] = value_of(world, m, b, 0, before[0]);
      if (anew && r.has_offset) before[1] = r.ratio * before[0] + r.offset;
      before[1] = value_of(world, m, b, 2, before[1]);
      if (anew && !r.has_offset) b.bound = before[1] - r.ratio * before[0];
      continue;
    }
    if (b.kind != BlockKind::joint && b.kind != BlockKind::limit && b.kind != BlockKind::spring)
      continue;
    const Joint& joint = world.links.values()[b.source].joint;
    const bool screw = b.kind == BlockKind::joint && joint.kind == JointKind::screw;
    if (b.kind == BlockKind::joint && !screw) continue;
    if (!screw && b.coordinate != Coordinate::turn && b.coordinate != Coordinate::second) continue;
    const auto value = [&](Coordinate which) {
      Real c = 0;
      write_coordinate(joint, which, m.room.placed[b.body[0]], m.room.placed[b.body[1]], before[0],
                       {&c, nullptr, nullptr});
      return c;
    };
    if (anew && screw && joint.extras->pitch != 0)
      before[0] = value(Coordinate::slide) / joint.extras->pitch;
    Real c = value(screw ? Coordinate::turn : b.coordinate);
    if (anew && b.kind == BlockKind::limit && !b.lock) {
      // A range that does not contain the nearest turn may contain another.
      const AngleLimit& range = b.coordinate == Coordinate::second ? joint.limits->second
                                                                   : joint.limits->turn;
      const Real middle = 0.5 * (range.low + range.high);
      c = middle + std::remainder(c - middle, 2 * kPi);
    }
    before[0] = c;
  }
  for (Effort& e : m.efforts) {
    if (anew) e.before = 0;
    e.before = coordinate_row(world, m, e.link, e.coordinate, e.body[0], e.body[1], e.before).value;
  }
}

/// Whether joints were opened by little beside the way that bodies went. A step of high order that
/// opens more passes a place where rows nearly depend on one another: it may end on another branch.
bool keeps_joints(const Mechanism& m, Real h) {
  Real speed = 0;
  for (std::size_t b = 0; b < m.count(); ++b)
    speed = std::max(speed,
                     glm::length(m.room.state.v[b]) + m.reach * glm::length(m.room.state.w[b]));
  return m.room.opened <= std::max(kMostOpened * h * speed, 1e-9 * m.size);
}

/// One step of the integrator, projected. False: not taken.
bool integrate(const World& world, Mechanism& m, const Span& span, Integrator integrator) {
  bool done = false;
  switch (integrator) {
    case Integrator::euler:
      done = step_euler(world, m, span);
      break;
    case Integrator::rattle:
      done = step_rattle(world, m, span);
      break;
    case Integrator::rk4:
      done = step_rk4(world, m, span);
      break;
    case Integrator::implicit:
      done = step_implicit(world, m, span);
      break;
  }
  ++m.parts;
  if (!done || !all_finite(m)) return false;
  m.fresh = false;
  if (integrator == Integrator::rattle) return true;  // ends on its joints by itself
  if (m.settings.stabilisation == Stabilisation::projection)
    return project(world, m, span.part(1), span.whole) && all_finite(m) &&
           (integrator != Integrator::rk4 || keeps_joints(m, span.h));
  place(m), place_frames(world, m, span.part(1), span.whole);
  write_all_rows(world, m, {true, false});
  m.residual = worst_residual(m);
  return all_finite(m);
}

/// Steps of the pair, each within the tolerance. False: they became too small.
bool integrate_adaptively(const World& world, Mechanism& m, const Span& span) {
  const Real goal = m.settings.step_tolerance;
  Real done = 0, h = m.try_step > 0 ? std::min(m.try_step, span.h) : span.h / 16;
  for (int n = 0; done < span.h * (1 - 1e-14); ++n) {
    if (n > kMostSteps || h < 1e-12 * span.whole) return false;
    const bool last = done + h > span.h * (1 - 1e-12);
    const Real now = last ? span.h - done : h;
    m.room.start = m.room.state;
    const Real lack = m.room.worst_lack;
    Real error = 0;
    const Span part{span.from + done, now, span.whole};
    bool good = step_rk54(world, m, part, error);
    ++m.parts;
    const Real factor_of = good ? 0.9 * std::pow(goal / std::max(error, 1e-300), 0.2) : 0.1;
    good = good && error <= goal;
    if (good && m.settings.stabilisation == Stabilisation::projection)
      good = project(world, m, part.part(1), span.whole);
    if (good) {
      done += now, m.fresh = false;
      if (!last || factor_of < 1) h = now * std::clamp(factor_of, 0.2, 5.0);
    } else {
      m.room.state = m.room.start, m.room.worst_lack = lack;
      h = now * std::clamp(factor_of, 0.1, 0.7);
    }
  }
  m.try_step = h;
  return true;
}

/// By one integrator, in halves where the step is too long for it: at most so many times halved.
bool go_by(const World& world, Mechanism& m, const Span& span, Integrator integrator,
           int most_halvings, int most_parts) {
  Real fastest = 0;
  for (std::size_t b = 0; b < m.count() && integrator != Integrator::implicit; ++b)
    fastest = std::max(fastest, glm::length(m.room.start.w[b]));
  int parts = 1;
  while (parts < 64 && fastest * span.h > kMostTurn * parts) parts *= 2;
  for (int halvings = 0;; parts *= 2) {
    bool good = true;
    for (int i = 0; i < parts && good; ++i)
      good = integrate(world, m, {span.from + i * span.h / parts, span.h / parts, span.whole},
                       integrator);
    if (good) return true;
    m.room.state = m.room.start;
    std::fill(m.loads.begin(), m.loads.end(), 0.0);
    m.fresh = true;
    if (++halvings > most_halvings || m.parts > most_parts) return false;
  }
}

/// As long as asked. What no part of the step was short enough for is done by Euler, which loses
/// energy but does not blow up; in the end with joints that stay open a little.
bool go(const World& world, Mechanism& m, const Span& span) {
  const Integrator chosen = m.settings.integrator;
  if (chosen == Integrator::rk4 && m.settings.step_tolerance > 0)
    return integrate_adaptively(world, m, span);
  m.room.start = m.room.state;
  const int before = m.rescues;
  m.rescues = 0;
  // After a rescue there is little hope in halves, and none at once.
  if (before % kPatience == 0 &&
      go_by(world, m, span, chosen, before > 0 ? 1 : kMostHalvings, kMostParts))
    return true;
  if (chosen != Integrator::euler &&
      go_by(world, m, span, Integrator::euler, kMostHalvings, 2 * kMostParts)) {
    m.rescues = before + 1;
  } else {
    m.rescues = before + 1;
    for (Vec3& w : m.room.state.w)  // what turns too fast for any step is slowed
      if (const Real turn = glm::length(w) * span.h; turn > 1) w /= turn;
    if (!integrate(world, m, span, Integrator::euler)) return m.rescues = 0, false;
  }
  m.fresh = chosen == Integrator::implicit;  // its accelerations are to be found anew
  return true;
}

bool is_one_sided(const Mechanism& m, std::size_t i) {
  const Block& b = m.blocks[i];
  return (b.kind == BlockKind::limit && !b.lock) || b.kind == BlockKind::string;
}

/// How far the nearest limit is that does not bear; below zero where one is overstepped.
Real clearance(const Mechanism& m) {
  Real least = 1e300;
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    if (is_one_sided(m, i) && !m.memory[i].active)
      least = std::min(least, m.room.c[m.blocks[i].first_row]);
  return least;
}

/// Limits that would have pulled let go. True if any did.
bool let_go(Mechanism& m) {
  bool any = false;
  Real scale = 0;
  for (Real load : m.loads) scale = std::max(scale, std::abs(load));
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    if (!is_one_sided(m, i) || !m.memory[i].active) continue;
    if (m.loads[m.blocks[i].first_row] >= -1e-9 * scale) continue;
    m.memory[i].active = false, any = true;
  }
  return any;
}

/// What reached a limit stops there, or is thrown back; blows reach through the whole mechanism.
void strike(const World& world, Mechanism& m) {
  MechanismRoom& room = m.room;
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    if (is_one_sided(m, i) && !m.memory[i].active && room.c[m.blocks[i].first_row] <= kTouch)
      m.memory[i].active = true;
  for (int round = 0; round < 8; ++round) {
    place(m);
    write_all_rows(world, m, {true, false});
    factor(m, false);
    std::vector<Real>& wanted = room.sum_lambda;
    std::fill(wanted.begin(), wanted.end(), 0.0);
    for (std::size_t i = 0; i < m.blocks.size(); ++i) {
      if (!is_one_sided(m, i) || !m.memory[i].active) continue;
      const Block& b = m.blocks[i];
      const Real rate = rate_of(m, b, 0);
      const Real bounce = b.kind == BlockKind::limit
                              ? world.links.values()[b.source].joint.extras->restitution
                              : 0;
      if (rate < -kQuiet) wanted[b.first_row] = -bounce * rate;
    }
    room.start.v = room.state.v, room.start.w = room.state.w;
    project_twists(m, wanted);
    bool pulled = false;
    for (std::size_t i = 0; i < m.blocks.size(); ++i) {
      if (!is_one_sided(m, i) || !m.memory[i].active) continue;
      const std::size_t row = m.blocks[i].first_row;
      const bool leaves = wanted[row] > 0;
      if (room.lambda[row] < 0) m.memory[i].active = false, pulled = true;
      else if (leaves && round == 7) m.memory[i].active = false;
    }
    if (!pulled) {
      for (std::size_t i = 0; i < m.blocks.size(); ++i)
        if (is_one_sided(m, i) && wanted[m.blocks[i].first_row] > 0) m.memory[i].active = false;
      return;
    }
    room.state.v = room.start.v, room.state.w = room.start.w;
  }
}

/// A step among limits: as far as the first that is reached, then on with what is left.
bool go_among_limits(World& world, Mechanism& m, Real h) {
  MechanismRoom& room = m.room;
  Real done = 0;
  m.events = 0;
  // What is left after so many blows is taken at once.
  for (int tries = 0; done < h * (1 - 1e-12); ++tries) {
    room.begin = room.state;
    place(m), place_frames(world, m, done / h, h);
    write_all_rows(world, m, {true, false});
    const Real at_start = clearance(m);
    bool again = false;
    const auto attempt = [&](Real length) {
      room.state = room.begin;
      m.fresh = m.fresh || again, again = true;
      return go(world, m, {done, length, h});
    };
    Real length = h - done;
    if (!attempt(length)) return false;
    for (int n = 0; n < 16 && let_go(m); ++n)
      if (!attempt(length)) return false;
    if (Real left = clearance(m); left < -kTouch && tries < kMostEvents) {
      // Where the first limit is met: regula falsi, an end that stays loses half its weight
      // (Illinois).
      Real low = 0, high = length, at_low = std::max(at_start, kTouch), at_high = left;
      int side = 0;
      bool met = false;
      for (int n = 0; n < kMostSearches && !met && high - low > 1e-12 * h; ++n) {
        length = low + (high - low) * at_low / (at_low - at_high);
        if (!attempt(length)) return false;
        left = clearance(m);
        met = std::abs(left) <= kTouch;
        if (left < 0) {
          high = length, at_high = left;
          if (side < 0) at_low *= 0.5;
          side = -1;
        } else {
          low = length, at_low = left;
          if (side > 0) at_high *= 0.5;
          side = 1;
        }
      }
      if (!met && !attempt(length = high)) return false;
    }
    done += length;
    bool reached = false;
    for (std::size_t i = 0; i < m.blocks.size(); ++i)
      reached = reached || (is_one_sided(m, i) && !m.memory[i].active &&
                            room.c[m.blocks[i].first_row] <= kTouch);
    if (!reached) continue;
    ++m.events;
    strike(world, m);
    if (m.settings.integrator == Integrator::implicit) m.fresh = true;
    place_frames(world, m, done / h, h);
    if (!project(world, m, done / h, h)) return false;
  }
  return true;
}

/// The first step of a mechanism, or the first after something was changed by hand: onto its joints.
bool start(const World& world, Mechanism& m, Real h) {
  place(m), place_frames(world, m, 0, h);
  count_turns(world, m, !m.counted);
  m.counted = true;
  write_all_rows(world, m, {true, true});
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    m.memory[i].active = is_one_sided(m, i) && m.room.c[m.blocks[i].first_row] <= kTouch;
  write_all_rows(world, m, {true, false});
  for (std::size_t i = 0; i < m.blocks.size(); ++i)  // what is leaving its limit may go
    if (m.memory[i].active && rate_of(m, m.blocks[i], 0) > kQuiet) m.memory[i].active = false;
  std::fill(m.loads.begin(), m.loads.end(), 0.0);
  return project(world, m, 0, h);
}

std::uint32_t worst_block(const Mechanism& m) {
  std::uint32_t worst = 0;
  Real most = -1;
  for (std::uint32_t i = 0; i < m.blocks.size(); ++i)
    for (std::size_t r = 0; r < m.blocks[i].rows && bears(m, i); ++r)
      if (const Real c = std::abs(m.room.c[m.blocks[i].first_row + r]); !(c <= most))
        most = c, worst = i;
  return worst;
}

void make_room(Mechanism& m) {
  MechanismRoom& r = m.room;
  r.pattern = make_pattern(m);
  const std::size_t bodies = m.count(), all = bodies + m.frames.size();
  r.values.assign(r.pattern.numbers, 0);
  r.scales.assign(m.rows, 1);
  r.placed.assign(all, {}), r.give.assign(bodies, Mat3(1));
  r.jacobian.assign(m.vectors, Vec3(0)), r.jacobian_before = r.jacobian;
  for (auto* rows : {&r.c, &r.gamma, &r.right, &r.lambda, &r.step_lambda, &r.sum_lambda, &r.weights})
    rows->assign(m.rows, 0);
  r.lack.assign(r.pattern.unknowns, 0);
  for (auto* twice : {&r.force, &r.correction, &r.applied, &r.momenta, &r.residuals})
    twice->assign(2 * bodies, Vec3(0));
  r.motion.assign(2 * all, Vec3(0));
  for (Motions* s : {&r.state, &r.start, &r.from, &r.begin})
    s->x.assign(bodies, {}), s->q.assign(bodies, kNoTurn), s->v.assign(bodies, {}),
        s->w.assign(bodies, {});
  const bool pair = m.settings.integrator == Integrator::rk4 && m.settings.step_tolerance > 0;
  const std::size_t stages = pair ? 7 : m.settings.integrator == Integrator::rk4 ? 4 : 0;
  for (std::size_t i = 0; i < stages; ++i)
    r.rates[i].assign(3 * bodies, Vec3(0)), r.quat_rates[i].assign(bodies, kNoTurn);
  m.faults.reserve(m.blocks.size() + 1);
  r.ready = true;
}

}  // namespace

void prepare(World& world) {
  for (Mechanism& m : world.mechanisms)
    if (!m.room.ready) make_room(m);
}

void step(World& world, Mechanism& m, Real h) {
  m.lost = Entity{}, m.faults.clear(), m.room.worst_lack = 0;
  m.parts = m.iterations = m.events = m.solves = 0;
  gather(world, m);
  gather_hangings(m, h);
  const auto acts = [](Vec3 v) { return v != Vec3(0); };
  m.room.pushed = std::any_of(m.owed.begin(), m.owed.end(), acts) ||
                  std::any_of(m.room.applied.begin(), m.room.applied.end(), acts);
  const bool begins = m.fresh;
  bool good = all_finite(m);
  if (good && begins) good = start(world, m, h);
  m.cannot_close = begins && !good && all_finite(m);
  if (good && m.unilateral) good = go_among_limits(world, m, h);
  else if (good) good = go(world, m, {0, h, h});
  const bool open = !good || m.room.worst_lack > 1e-2;
  if (open && !m.blocks.empty()) {
    MechanismFault f;
    f.kind = MechanismFault::inconsistent;
    f.block = good ? m.room.worst_lack_block : worst_block(m);
    f.residual = good ? m.room.worst_lack : m.residual;
    m.faults.push_back(f);
  }
  if (!good) {
    m.lost = m.bodies.front();
    for (std::size_t b = 0; b + m.hangings.size() < m.count(); ++b)
      if (const Motions& s = m.room.state; !is_finite(s.x[b]) || !is_finite(s.q[b]) ||
                                           !is_finite(s.v[b]) || !is_finite(s.w[b])) {
        m.lost = m.bodies[b];
        break;
      }
    m.fresh = true;
    return;
  }
  settle_hangings(m);
  std::fill(m.owed.begin(), m.owed.end(), Vec3(0));
  count_turns(world, m, false);
  write_back(world, m);
  for (std::size_t i = 0; i < m.frames.size(); ++i) {
    const Placed& at = m.room.placed[m.count() + i];
    m.frames[i].before = {at.position, at.rotation}, m.frames[i].known = true;
  }
}

JointForce joint_force(const Mechanism& m, const Block& joint) {
  JointForce sum;
  if (!m.room.ready) return sum;
  Vec3 pull[2] = {Vec3(0), Vec3(0)};
  add_pull(joint, &m.room.jacobian[joint.first_vector], 1, &m.loads[joint.first_row], pull);
  sum.force = pull[0], sum.torque = pull[1];
  return sum;
}

std::vector<MechanismFault> inspect(const World& world, std::size_t number) {
  Mechanism m = world.mechanisms[number];
  make_room(m);
  gather(world, m);
  m.faults.clear();
  constexpr Real kAny = 1e-3;
  gather_hangings(m, kAny);
  const bool closed = start(world, m, kAny);
  std::vector<MechanismFault> found = m.faults;
  if (!closed) {
    const std::uint32_t worst = worst_block(m);
    for (std::uint32_t i = 0; i < m.blocks.size(); ++i) {
      Real lack = 0;
      for (std::size_t r = 0; r < m.blocks[i].rows && bears(m, i); ++r)
        lack = std::max(lack, std::abs(m.room.c[m.blocks[i].first_row + r]));
      if (i == worst || lack > 0.1 * m.residual)
        found.push_back({MechanismFault::inconsistent, i, 0, lack});
    }
  }
  for (std::uint32_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    if (b.kind == BlockKind::joint &&
        !on_right_branch(world.links.values()[b.source].joint, m.room.placed[b.body[0]].rotation,
                         m.room.placed[b.body[1]].rotation))
      found.push_back({MechanismFault::wrong_branch, i, 0, 0});
  }
  return found;
}

}  // namespace pantin::lagrangian
